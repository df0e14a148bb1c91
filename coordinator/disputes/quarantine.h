#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "coordinator/loop/machine_id.h"

namespace parray::coordinator {

/// A machine that gets no leases because it returned wrong bits.
struct Quarantine {
  std::uint64_t machine = 0;  ///< machine_key()
  std::string name;           ///< text_of() the machine; empty: of an earlier life, not seen since
  std::string worker;         ///< name of its worker at that time; empty likewise
  std::string reason;
  double since = 0;  ///< seconds since 1970
  double until = 0;  ///< likewise; 0: until it is readmitted
};

/// Machines in quarantine. A quarantine of a key lasts until somebody readmits the machine. One of
/// an address ends by itself after address_seconds, because addresses pass to other machines.
///
/// Plain state; one thread. Times are seconds since 1970 by the wall clock.
class QuarantineLedger {
 public:
  static constexpr double address_seconds = 24 * 3600;

  /// Puts a machine into quarantine at the time `since`; sets `until`. Returns false if it is in
  /// quarantine already.
  bool add(Quarantine quarantine);
  /// Null: the machine is not in quarantine.
  [[nodiscard]] const Quarantine* find(std::uint64_t machine) const;
  /// Ends quarantines of a machine that has this key, of one with this text_of(), or of one whose
  /// worker had this name. Returns the machines.
  std::vector<std::uint64_t> readmit(std::string_view name);
  /// Ends the quarantine of one machine; false if there was none.
  bool readmit(std::uint64_t machine) { return machines_.erase(machine) > 0; }
  /// Ends quarantines whose time is over. Returns the machines.
  std::vector<std::uint64_t> expire(double now);

  [[nodiscard]] const std::map<std::uint64_t, Quarantine>& all() const { return machines_; }

  [[nodiscard]] nlohmann::json to_json() const;
  /// Inverse. Throws nlohmann::json::exception.
  static QuarantineLedger from_json(const nlohmann::json& list);

 private:
  std::map<std::uint64_t, Quarantine> machines_;
};

}  // namespace parray::coordinator

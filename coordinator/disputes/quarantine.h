#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.h"
#include "coordinator/loop/machine_id.h"

namespace parray::coordinator {

/// A machine that gets no leases because it returned wrong bits.
struct Quarantine {
  std::uint64_t machine = 0;  ///< machine_key()
  std::string name;           ///< text_of() the machine; empty: it has not joined since the restart
  std::string worker;         ///< name of its worker at that time; empty: unknown
  std::string host;           ///< of that worker; empty: unknown
  std::string reason;
  double since = 0;  ///< seconds since 1970
  double until = 0;  ///< seconds since 1970; 0: until it is readmitted
};

/// The machines in quarantine. A quarantine lasts until the machine is readmitted. Only the
/// quarantine of a machine known by its address (MachineId::Kind) ends after address_seconds,
/// because another machine may get the address.
///
/// Not thread-safe. Times are seconds since 1970 by the wall clock.
class QuarantineLedger {
 public:
  static constexpr double address_seconds = 24 * 3600;

  /// Puts a machine into quarantine from `since` on and sets `until`. False: it is there already.
  bool add(Quarantine quarantine);
  /// Finds a machine. Null: it is not in quarantine.
  [[nodiscard]] const Quarantine* find(std::uint64_t machine) const;
  /// Ends the quarantines of some machines, and returns these machines. If `host`, `name` is the
  /// host of the machine's worker. Otherwise it is the name of a worker key, an address, text_of()
  /// the machine, or the name of its worker.
  std::vector<std::uint64_t> readmit(std::string_view name, bool host);
  /// Ends the quarantine of one machine. False: there was none.
  bool readmit(std::uint64_t machine) { return machines_.erase(machine) > 0; }
  /// Ends the quarantines whose time is over. Returns the machines.
  std::vector<std::uint64_t> expire(double now);

  [[nodiscard]] const std::map<std::uint64_t, Quarantine>& all() const { return machines_; }

  [[nodiscard]] nlohmann::json to_json() const;
  /// Reads the output of to_json(). Throws nlohmann::json::exception.
  static QuarantineLedger from_json(const nlohmann::json& list);

 private:
  std::map<std::uint64_t, Quarantine> machines_;
};

/// The finding that a machine returned wrong bits: results that differ from correct tracing.
struct FaultFinding {
  /// Higher than that of every earlier finding, also after a restart of the coordinator.
  std::uint64_t number = 0;
  std::uint64_t machine = 0;  ///< machine_key() of the machine
  std::string worker;         ///< name of its worker at that time, for people
};

/// Keeps the latest finding of each machine. A finding remains after the quarantine: jobs that are
/// resumed later may contain results or checks of the machine. Not thread-safe.
class FaultFindings {
 public:
  /// Adds a finding with the next number. It replaces an earlier finding of the same machine. If
  /// there are more than `most`, removes the oldest.
  FaultFinding add(std::uint64_t machine, std::string worker);
  /// Returns the findings with numbers above `number`, in ascending order.
  [[nodiscard]] std::vector<FaultFinding> after(std::uint64_t number) const;
  /// Returns the number of the latest finding. 0: there is none.
  [[nodiscard]] std::uint64_t latest() const { return list_.empty() ? 0 : list_.back().number; }

  [[nodiscard]] nlohmann::json to_json() const;
  /// Reads the output of to_json(). Throws nlohmann::json::exception.
  static FaultFindings from_json(const nlohmann::json& list);

  static constexpr std::size_t most = 4096;

 private:
  std::vector<FaultFinding> list_;  ///< by number
};

/// Returns the error that the state's note "workers", which contains the findings, is not valid.
/// `why` says what is wrong with it.
RunError damaged_worker_note(std::string_view why);

}  // namespace parray::coordinator

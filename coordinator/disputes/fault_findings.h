#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "common/rooms.h"

namespace parray::coordinator {

/// The finding that a machine returned wrong bits.
struct FaultFinding {
  std::uint64_t number = 0;   ///< grows from one finding to the next, in all lives
  std::uint64_t machine = 0;  ///< machine_key()
  std::string worker;         ///< name of its worker at that time, for people
};

/// The latest finding of each machine. A quarantine may end before a job that relies on the
/// machine goes on; a finding stays. Plain state; one thread.
class FaultFindings {
 public:
  /// Adds one; it replaces an earlier one of the machine. The oldest goes where there are too many.
  FaultFinding add(std::uint64_t machine, std::string worker);
  /// Those with higher numbers, in their order.
  [[nodiscard]] std::vector<FaultFinding> after(std::uint64_t number) const;
  /// The number of the latest; 0: there is none.
  [[nodiscard]] std::uint64_t latest() const { return list_.empty() ? 0 : list_.back().number; }

  [[nodiscard]] nlohmann::json to_json() const;
  /// Inverse. Throws nlohmann::json::exception.
  static FaultFindings from_json(const nlohmann::json& list);

  static constexpr std::size_t most = 4096;

 private:
  std::vector<FaultFinding> list_;  ///< by number
};

}  // namespace parray::coordinator

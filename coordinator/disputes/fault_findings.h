#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.h"
#include "common/rooms.h"

namespace parray::coordinator {

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

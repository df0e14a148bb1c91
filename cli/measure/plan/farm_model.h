#pragma once

#include <cstdint>
#include <vector>

#include "common/scene/settings_fwd.h"
#include "common/schedule/chunk_sizer.h"

namespace parray::plan {

/// Predicts the time of passes on a farm from their time on this machine. Without workers, the farm
/// is this machine, and its time is that of this machine.
class FarmModel {
 public:
  FarmModel() = default;
  /// `speeds`: samples per second of each worker, divided by those of this machine with `threads`
  /// threads; all > 0. Each worker has `threads` threads. `settings`: those of the picture.
  FarmModel(const RenderSettings& settings, std::vector<double> speeds, std::uint32_t threads);

  /// Returns whether the farm is this machine.
  [[nodiscard]] bool here() const { return speeds_.empty(); }
  [[nodiscard]] const std::vector<double>& speeds() const { return speeds_; }

  /// Returns the farm's seconds for tracing that takes `wall` seconds here, in `passes` equal
  /// passes with `samples` per pixel in total. Replays the coordinator's lease rules in virtual
  /// time (cli/check/audit/audit.h), with the same cost for every cell. Leaves out the network,
  /// the scene's transfer and the coordinator's own work.
  [[nodiscard]] double seconds(double wall, double samples, int passes) const;

 private:
  Boxed<RenderSettings> settings_;
  std::vector<double> speeds_;
  std::uint32_t threads_ = 1;
};

}  // namespace parray::plan

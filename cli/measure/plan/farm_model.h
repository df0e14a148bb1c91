#pragma once

#include <cstdint>
#include <vector>

#include "common/scene/settings.h"
#include "common/schedule/chunk_sizer.h"

namespace parray::plan {

/// Who is to trace: how long passes take there that take so long here. None: this machine.
class FarmModel {
 public:
  FarmModel() = default;
  /// Workers by their speed in samples a second, relative to this machine's with `threads` threads;
  /// all > 0. The coordinator runs here.
  FarmModel(const RenderSettings& settings, std::vector<double> speeds, std::uint32_t threads);

  [[nodiscard]] bool here() const { return speeds_.empty(); }
  [[nodiscard]] const std::vector<double>& speeds() const { return speeds_; }

  /// What tracing of `wall` seconds here takes there, in `passes` equal passes of `samples` a pixel
  /// together: leases are dealt out in virtual time by the coordinator's own rules
  /// (cli/check/audit/replay.h), every cell at the same cost. Nothing is sent, and no worker has to
  /// be given the scene: that comes on top.
  [[nodiscard]] double seconds(double wall, double samples, int passes) const;

 private:
  RenderSettings settings_;
  std::vector<double> speeds_;
  std::uint32_t threads_ = 1;
};

}  // namespace parray::plan

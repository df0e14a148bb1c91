#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/scene/settings.h"
#include "tests/bench/device_checks.h"

/// Launches of one picture, and the same samples on the CPU.
namespace parray::bench {

/// How a launch divides a picture into work items.
struct ItemPlan {
  std::uint32_t samples = 16;  ///< of an item
  std::uint32_t blocks = 1;    ///< items of a pixel
  std::uint32_t every = 1;     ///< traces only each `every`-th row of tiles
  bool tiles = true;           ///< false: rows of pixels instead of tiles
};

/// Returns the items of a launch. The threads of a warp trace the same samples of the pixels of a
/// tile (8 x 4) or of a row.
std::vector<DeviceItem> items_of(const RenderSettings& settings, const ItemPlan& plan);

/// A picture on the device.
class DeviceWork {
 public:
  DeviceWork(const test::CudaDevice& device, const DeviceScene& scene, const DevicePicture& picture,
             std::vector<DeviceItem> items);

  /// Traces all items and returns the device's seconds.
  double trace(const test::CudaKernel& kernel, std::uint32_t block) const;

  /// Overwrites the results of some_items(), so that they are right only if trace() writes them.
  void spoil_some_results();
  /// Returns some items from the middle.
  [[nodiscard]] std::span<const DeviceItem> some_items() const;
  /// Returns the results of some_items().
  [[nodiscard]] std::vector<DeviceSums> some_results() const;
  /// Returns the results of all items.
  [[nodiscard]] std::vector<DeviceSums> all_results() const;

  [[nodiscard]] const std::string& kernel() const { return kernel_; }
  [[nodiscard]] std::uint64_t samples() const { return samples_; }
  [[nodiscard]] std::size_t item_count() const { return items_.size(); }

 private:
  [[nodiscard]] std::size_t some_begin() const;

  const test::CudaDevice& device_;
  std::string kernel_;
  std::vector<DeviceItem> items_;
  std::uint64_t samples_ = 0;
  test::CudaMemory scene_memory_, picture_memory_, item_memory_, sum_memory_;
};

/// Describes the first item whose results are not the CPU's; empty: there is none. Items that were
/// handed back count as right.
std::string first_difference(std::span<const DeviceItem> items, std::span<const DeviceSums> found,
                             const PathTracer& cpu);

/// Returns the samples per second of one core of the CPU, in each turn.
std::vector<double> cpu_rates(const PathTracer& cpu, const RenderSettings& settings,
                              std::size_t turns, double seconds);

}  // namespace parray::bench

#include <algorithm>
#include <cstdio>
#include <cstring>

#include "common/base/arrays.h"
#include "tests/bench/bench.h"
#include "tests/bench/bench_scenes.h"
#include "tests/bench/device_speed.h"
#include "tests/bench/device_work.h"

namespace parray::bench {
namespace {

/// Samples of a pixel in each launch.
constexpr std::uint32_t samples_of_a_pixel = 64;

/// Returns the median seconds of `rounds` calls of `work`, which returns its seconds.
template <typename Work>
double median_seconds(std::size_t rounds, const Work& work) {
  std::vector<double> seconds;
  work();
  for (std::size_t round = 0; round < rounds; ++round) seconds.push_back(work());
  return median(seconds);
}

/// Returns the seconds of the host for an empty launch with its wait.
double empty_launch(const test::CudaDevice& device, const test::CudaKernel& kernel) {
  const test::CudaMemory none(device.driver(), 64);
  const TimeLimit clock(0);
  device.launch(kernel, 1, 32, none.address(), none.address(), none.address(), std::uint32_t{0},
                none.address());
  device.wait();
  return clock.used();
}

Json measure_copies(const SpeedOptions& options, const test::CudaDevice& device) {
  const std::size_t bytes = std::size_t{options.width} * options.height * sizeof(DeviceSums);
  AlignedArray<std::byte> host(bytes);
  std::memset(host.data(), 1, bytes);
  test::CudaMemory memory(device.driver(), bytes);
  const auto rate = [&](const auto& copy) {
    return static_cast<double>(bytes) / 1e9 / median_seconds(options.rounds, [&] {
             const TimeLimit clock(0);
             copy();
             return clock.used();
           });
  };
  return {{"gb_per_s_to_device", rate([&] {
             memory.copy_in({host.data(), bytes});
           })},
          {"gb_per_s_from_device", rate([&] {
             memory.copy_out({host.data(), bytes});
           })}};
}

}  // namespace

Json measure_launches(const SpeedOptions& options, int cap, std::uint32_t block,
                      const test::CudaDevice& device, ModulesByCap& modules) {
  const Scene scene = scene_of_size(goal_spheres, options.generated);
  RenderSettings settings = small_picture();
  settings.width = options.width;
  settings.height = options.height;
  settings.precision = Precision::f32;
  const DeviceScene tables(scene, Precision::f32, AcceleratorKind::bvh);
  const DevicePicture picture(tables, scene.camera, settings);
  const test::CudaKernel kernel = modules.with(cap).kernel(kernel_name(tables, picture));
  Json figures = {{"most_registers", name_of_cap(cap)}, {"block", block}};
  figures["empty_launch_us"] =
      1e6 * median_seconds(20, [&] { return empty_launch(device, kernel); });
  figures.update(measure_copies(options, device));
  figures["divisions"] = Json::array();
  for (const bool tiles : {true, false}) {
    for (const std::uint32_t samples : {1U, 4U, 16U, 64U}) {
      // Launches of the same samples: with short items there are more of them.
      const ItemPlan plan{samples, samples_of_a_pixel / samples, samples == 1 ? 4U : 1U, tiles};
      const DeviceWork work(device, tables, picture, items_of(settings, plan));
      const double seconds =
          median_seconds(options.rounds, [&] { return work.trace(kernel, block); });
      figures["divisions"].push_back(
          {{"order", tiles ? "tiles of 8 x 4" : "rows"},
           {"samples_of_an_item", samples},
           {"items", work.item_count()},
           {"million_samples_per_s", static_cast<double>(work.samples()) / seconds / 1e6}});
    }
  }
  return figures;
}

}  // namespace parray::bench

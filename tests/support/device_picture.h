#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/scene/settings.h"
#include "common/trace/device/device_fingerprint.h"
#include "common/trace/device/device_tables.h"
#include "common/trace/tracer.h"
#include "tests/support/reference_tracer.h"
#include "tests/support/rooms.h"

/// Pictures traced by kernels of a device, with any means to launch them.
namespace parray::test {

/// One launch of a kernel: its parameters as spans of the host's memory.
struct Launch {
  std::string kernel;
  std::span<const std::byte> scene;
  std::span<const std::byte> picture;
  std::span<const DeviceItem> items;
  std::span<DeviceSums> sums;
};
/// Traces all items of a launch before it returns.
using Launcher = std::function<void(const Launch&)>;

/// Sums of a picture, and how many of its pixels the CPU traced because a kernel handed them back.
struct DevicePictureSums {
  ReferenceSums sums;
  std::uint64_t handed_back = 0;
};

/// Traces items to `pixels`, one element for each item. The CPU's scalar tracer `fallback` traces
/// the items that the kernel hands back. Returns their number.
inline std::uint64_t trace_items(const DeviceScene& scene, const DevicePicture& picture,
                                 const PathTracer& fallback, const Launcher& launch,
                                 std::span<const DeviceItem> items, std::span<PixelSums> pixels,
                                 TraceCounts& counts) {
  std::vector<DeviceSums> results(items.size());
  if (scene.fits()) {
    launch({kernel_name(scene, picture), scene.bytes(), picture.bytes(), items, results});
  }
  std::uint64_t handed_back = 0;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const DeviceItem& item = items[i];
    if (!scene.fits() || results[i].handed_back != 0) {
      ++handed_back;
      fallback.trace({item.y, item.x, item.x + 1}, {item.begin, item.end}, pixels.subspan(i, 1),
                     counts);
    } else {
      add_result(item, results[i], pixels[i], counts);
    }
  }
  return handed_back;
}

/// Traces all samples of a picture. `settings` has a precision and a search that devices know.
inline DevicePictureSums device_sums(const Scene& scene, const RenderSettings& settings,
                                     const Launcher& launch) {
  const DeviceScene tables(scene, settings.precision, settings.accelerator);
  const DevicePicture picture(tables, scene.camera, settings);
  std::vector<DeviceItem> items;
  for (std::uint32_t y = 0; y < settings.height; ++y) {
    for (std::uint32_t x = 0; x < settings.width; ++x) {
      items.push_back({x, y, 0, settings.samples_per_pixel});
    }
  }
  DevicePictureSums result{{std::vector<PixelSums>(items.size()), {}}, 0};
  const auto fallback = make_scalar_tracer(scene, settings);
  result.handed_back = trace_items(tables, picture, *fallback, launch, items, result.sums.pixels,
                                   result.sums.counts);
  return result;
}

/// Returns the fingerprint that a device has.
inline std::string fingerprint_of(const Launcher& launch) {
  return device_fingerprint([&launch](const Scene& scene, const RenderSettings& settings,
                                      std::span<PixelSums> pixels, TraceCounts& counts) {
    const ReferenceSums found = device_sums(scene, settings, launch).sums;
    std::copy(found.pixels.begin(), found.pixels.end(), pixels.begin());
    counts += found.counts;
  });
}

/// A device as a PathTracer. The CPU's scalar tracer does all but trace_run().
class DeviceTracer final : public PathTracer {
 public:
  DeviceTracer(const Scene& scene, const RenderSettings& settings, Launcher launch)
      : DeviceTracer(make_scalar_tracer(scene, settings), scene, settings, std::move(launch)) {}

  void trace_run(const PixelRun& run, const RunSamples& samples, std::span<PixelSums> sums,
                 TraceCounts& counts) const override {
    std::vector<DeviceItem> items;
    for (std::uint32_t x = run.x_begin; x < run.x_end; ++x) {
      const SampleRange range = samples[x - run.x_begin];
      items.push_back({x, run.y, range.begin, range.end});
    }
    trace_items(tables_, picture_, *scalar_, launch_, items, sums, counts);
  }
  void first_hits(const PixelRun& run, const SampleRange& samples,
                  std::span<FirstHit> hits) const override {
    scalar_->first_hits(run, samples, hits);
  }
  void add_sky_samples(const PixelRun& run, const RunSamples& samples,
                       std::span<SkySamples> sky) const override {
    scalar_->add_sky_samples(run, samples, sky);
  }

 private:
  DeviceTracer(std::unique_ptr<PathTracer> scalar, const Scene& scene,
               const RenderSettings& settings, Launcher launch)
      : PathTracer(scalar->accelerator()),
        scalar_(std::move(scalar)),
        tables_(scene, settings.precision, settings.accelerator),
        picture_(tables_, scene.camera, settings),
        launch_(std::move(launch)) {}

  std::unique_ptr<PathTracer> scalar_;
  DeviceScene tables_;
  DevicePicture picture_;
  Launcher launch_;
};

}  // namespace parray::test

#include "tests/bench/device_work.h"

#include <algorithm>
#include <thread>
#include <utility>

#include "common/math/float_mode.h"
#include "common/trace/tracer.h"
#include "tests/bench/bench.h"
#include "tests/bench/on_processors.h"

namespace parray::bench {
namespace {

constexpr std::uint32_t tile_width = 8;
constexpr std::uint32_t tile_height = 4;
/// Items that are compared with the CPU.
constexpr std::size_t some = 16'384;

/// Adds the items of the pixels [x, x + width) x [y, y + height) of a picture.
void add_items(const RenderSettings& settings, const ItemPlan& plan, std::uint32_t x_begin,
               std::uint32_t y_begin, std::uint32_t width, std::uint32_t height,
               std::vector<DeviceItem>& items) {
  const std::uint32_t x_end = std::min(settings.width, x_begin + width);
  const std::uint32_t y_end = std::min(settings.height, y_begin + height);
  for (std::uint32_t block = 0; block < plan.blocks; ++block) {
    const std::uint32_t sample = block * plan.samples;
    for (std::uint32_t y = y_begin; y < y_end; ++y) {
      for (std::uint32_t x = x_begin; x < x_end; ++x) {
        items.push_back({x, y, sample, sample + plan.samples});
      }
    }
  }
}

/// Traces an item on the CPU, in the form of a device.
DeviceSums cpu_result(const PathTracer& cpu, const DeviceItem& item) {
  PixelSums pixel;
  TraceCounts counts;
  cpu.trace({item.y, item.x, item.x + 1}, {item.begin, item.end}, {&pixel, 1}, counts);
  DeviceSums sums{};
  for (std::size_t channel = 0; channel < 3; ++channel) {
    sums.sum[channel] = pixel.sum[channel];
    sums.sum_of_squares[channel] = pixel.sum_of_squares[channel];
    sums.odd[channel] = pixel.odd[channel];
  }
  sums.rays = counts.rays;
  sums.lost = counts.lost;
  sums.nonfinite = static_cast<std::uint32_t>(counts.nonfinite);
  return sums;
}

std::string difference(const DeviceItem& item, const DeviceSums& found,
                       const DeviceSums& expected) {
  const std::string where = "pixel (" + std::to_string(item.x) + ", " + std::to_string(item.y) +
                            "), samples " + std::to_string(item.begin) + " to " +
                            std::to_string(item.end - 1) + ": ";
  const auto text = [&](const std::string& what, std::uint64_t a, std::uint64_t b) {
    return where + what + " is " + std::to_string(a) + ", not " + std::to_string(b);
  };
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string of = " of channel " + std::to_string(i);
    if (found.sum[i] != expected.sum[i]) return text("the sum" + of, found.sum[i], expected.sum[i]);
    if (found.sum_of_squares[i] != expected.sum_of_squares[i]) {
      return text("the sum of squares" + of, found.sum_of_squares[i], expected.sum_of_squares[i]);
    }
    if (found.odd[i] != expected.odd[i]) {
      return text("the sum of odd samples" + of, found.odd[i], expected.odd[i]);
    }
  }
  if (found.rays != expected.rays) return text("the number of rays", found.rays, expected.rays);
  if (found.lost != expected.lost) return text("the lost light", found.lost, expected.lost);
  if (found.nonfinite != expected.nonfinite) {
    return text("the number of non-finite samples", found.nonfinite, expected.nonfinite);
  }
  return "";
}

std::vector<double> measure_rates(const PathTracer& cpu, const RenderSettings& settings,
                                  std::size_t turns, double seconds) {
  constexpr std::uint32_t samples_of_a_call = 16;
  const FloatMode ieee;
  std::vector<double> rates;
  std::vector<PixelSums> sums(settings.width);
  std::uint32_t y = 0;
  for (std::size_t round = 0; round <= turns; ++round) {
    TraceCounts counts;
    const double begin = cpu_seconds();
    double elapsed = 0;
    while (elapsed < seconds) {
      y = (y + settings.height * 5 / 13 + 1) % settings.height;
      cpu.trace({y, 0, settings.width}, {0, samples_of_a_call}, sums, counts);
      elapsed = cpu_seconds() - begin;
    }
    if (round > 0) rates.push_back(static_cast<double>(counts.samples) / elapsed);
  }
  return rates;
}

}  // namespace

std::vector<DeviceItem> items_of(const RenderSettings& settings, const ItemPlan& plan) {
  std::vector<DeviceItem> items;
  const std::uint32_t width = plan.tiles ? tile_width : settings.width;
  const std::uint32_t height = plan.tiles ? tile_height : 1;
  for (std::uint32_t y = 0; y < settings.height; y += height) {
    if (y / height % plan.every != 0) continue;
    for (std::uint32_t x = 0; x < settings.width; x += width) {
      add_items(settings, plan, x, y, width, height, items);
    }
  }
  return items;
}

DeviceWork::DeviceWork(const test::CudaDevice& device, const DeviceScene& scene,
                       const DevicePicture& picture, std::vector<DeviceItem> items)
    : device_(device),
      kernel_(kernel_name(scene, picture)),
      items_(std::move(items)),
      scene_memory_(device.driver(), scene.bytes()),
      picture_memory_(device.driver(), picture.bytes()),
      item_memory_(device.driver(), std::as_bytes(std::span(items_))),
      sum_memory_(device.driver(), items_.size() * sizeof(DeviceSums)) {
  for (const DeviceItem& item : items_) samples_ += item.end - item.begin;
}

double DeviceWork::trace(const test::CudaKernel& kernel, std::uint32_t block) const {
  const auto count = static_cast<std::uint32_t>(items_.size());
  test::CudaTimer timer(device_.driver());
  timer.start();
  device_.launch(kernel, count, block, scene_memory_.address(), picture_memory_.address(),
                 item_memory_.address(), count, sum_memory_.address());
  timer.stop();
  return timer.seconds();
}

std::span<const DeviceItem> DeviceWork::some_items() const {
  const std::size_t count = std::min(some, items_.size());
  return std::span(items_).subspan((items_.size() - count) / 2, count);
}

/// Returns the first byte of the results of some_items().
std::size_t DeviceWork::some_begin() const {
  return static_cast<std::size_t>(some_items().data() - items_.data()) * sizeof(DeviceSums);
}

void DeviceWork::spoil_some_results() {
  const std::vector<std::byte> wrong(some_items().size() * sizeof(DeviceSums), std::byte{0x5A});
  sum_memory_.copy_in(wrong, some_begin());
}

std::vector<DeviceSums> DeviceWork::some_results() const {
  std::vector<DeviceSums> results(some_items().size());
  sum_memory_.copy_out(std::as_writable_bytes(std::span(results)), some_begin());
  return results;
}

std::vector<DeviceSums> DeviceWork::all_results() const {
  std::vector<DeviceSums> results(items_.size());
  sum_memory_.copy_out(std::as_writable_bytes(std::span(results)));
  return results;
}

std::string first_difference(std::span<const DeviceItem> items, std::span<const DeviceSums> found,
                             const PathTracer& cpu) {
  std::vector<std::string> differences(items.size());
  on_processors(items.size(), [&](std::size_t i) {
    if (found[i].handed_back != 1) {
      differences[i] = difference(items[i], found[i], cpu_result(cpu, items[i]));
    }
  });
  const auto first = std::find_if(differences.begin(), differences.end(),
                                  [](const std::string& text) { return !text.empty(); });
  return first == differences.end() ? "" : *first;
}

std::vector<double> cpu_rates(const PathTracer& cpu, const RenderSettings& settings,
                              std::size_t turns, double seconds) {
  std::vector<double> rates;
  std::jthread([&] {  // the core is that of this thread alone
    pin_to_one_core();
    rates = measure_rates(cpu, settings, turns, seconds);
  })
      .join();
  return rates;
}

}  // namespace parray::bench

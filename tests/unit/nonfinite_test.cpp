#include "common/trace/nonfinite.h"

#include <doctest/doctest.h>

#include <array>
#include <atomic>
#include <limits>
#include <vector>

#include "common/base/bytes.h"
#include "common/image/framebuffer.h"
#include "common/image/image.h"
#include "common/schedule/row_order.h"
#include "coordinator/job.h"
#include "proto/messages.h"
#include "tests/support/sample_scenes.h"
#include "worker/team.h"

/// Samples that are not finite: left out, counted and found. No scene is known that has them, so a
/// kernel with known holes stands in.
namespace parray {
namespace {

/// Radiance 0.25 in red, 0.5 in green and 1 in blue, but for the samples that `hole` names.
class HoleyKernel final : public Kernel {
 public:
  static bool hole(std::uint32_t x, std::uint32_t y, std::uint32_t sample) {
    return (x == 3 && y == 1 && sample >= 5) || (x == 7 && y == 2 && sample % 4 == 2) ||
           (x == 0 && y == 4);
  }

  void trace_run(const PixelRun& run, const RunSamples& samples, std::span<PixelSums> sums,
                 TraceCounts& counts) const override {
    const RadianceScale scale(1);
    for (std::uint32_t x = run.x_begin; x < run.x_end; ++x) {
      const SampleRange range = samples[x - run.x_begin];
      for (std::uint32_t s = range.begin; s < range.end; ++s) {
        const double nan = std::numeric_limits<double>::quiet_NaN();
        const Vec3d radiance = hole(x, run.y, s) ? Vec3d{0.25, nan, 1} : Vec3d{0.25, 0.5, 1};
        add_sample(radiance, scale, s, sums[x - run.x_begin], counts);
      }
    }
  }
  void first_hits(const PixelRun& /*run*/, const SampleRange& /*samples*/,
                  std::span<FirstHit> /*hits*/) const override {}
  [[nodiscard]] std::size_t accelerator_bytes() const override { return 0; }
  [[nodiscard]] std::string_view isa() const override { return "none"; }
};

constexpr std::uint32_t width = 9;
constexpr std::uint32_t height = 5;
constexpr std::uint32_t spp = 11;

RenderSettings settings_of(RowOrder order) {
  RenderSettings settings;
  settings.width = width;
  settings.height = height;
  settings.samples_per_pixel = spp;
  settings.row_order = order;
  return settings;
}

RowBlock traced(const RenderSettings& settings, const WorkRect& rect, int threads) {
  std::atomic<std::uint64_t> traced = 0;
  const std::atomic<bool> stop = false;
  return trace_rect(HoleyKernel(), settings, rect, threads, traced, stop);
}

std::uint64_t holes() {
  std::uint64_t count = 0;
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      for (std::uint32_t s = 0; s < spp; ++s) {
        count += HoleyKernel::hole(x, y, s) ? 1U : 0U;
      }
    }
  }
  return count;
}

TEST_CASE("every sample that is not finite is found, with its pixel and its number") {
  const auto found =
      locate_nonfinite(HoleyKernel(), {2, 4, 9}, std::vector<SampleRange>(5, {3, 11}), 77);
  REQUIRE(found.size() == 1);
  CHECK(found[0] == ExcludedSamples{77, 7, 6, 2});  // samples 6 and 10
  CHECK(
      locate_nonfinite(HoleyKernel(), {2, 0, 7}, std::vector<SampleRange>(7, {0, spp}), 0).empty());
}

TEST_CASE("a pixel is the mean of its finite samples, however the work is cut") {
  for (const RowOrder order : {RowOrder::sequential, RowOrder::interleaved}) {
    const RenderSettings settings = settings_of(order);
    for (const std::uint32_t cut : {0U, 1U, 6U, 11U}) {
      Framebuffer framebuffer(settings);
      for (const WorkRect& rect :
           {WorkRect{0, 2, 0, spp}, WorkRect{2, height, 0, cut}, WorkRect{2, height, cut, spp}}) {
        if (rect.units() > 0) {
          framebuffer.merge(traced(settings, rect, 3));
        }
      }
      CHECK(framebuffer.counts().nonfinite == holes());
      CHECK(framebuffer.excluded().size() == 3);
      const auto& nan_pixel = framebuffer.excluded().at({1, 3});
      CHECK(nan_pixel.first == 5);
      CHECK(nan_pixel.count == 6);
      const Image image = resolve_image(framebuffer, 1);
      for (std::size_t pixel = 0; pixel < std::size_t{width} * height; ++pixel) {
        const bool nothing_left = pixel == std::size_t{4} * width;
        CAPTURE(pixel);
        CHECK(image.rgb[3 * pixel] == (nothing_left ? 0.0F : 0.25F));
        CHECK(image.rgb[3 * pixel + 1] == (nothing_left ? 0.0F : 0.5F));
        CHECK(image.rgb[3 * pixel + 2] == (nothing_left ? 0.0F : 1.0F));
      }
    }
  }
}

TEST_CASE("equal leases have equal bytes, holes included, for any number of threads") {
  const RenderSettings settings = settings_of(RowOrder::interleaved);
  const WorkRect rect{0, height, 0, spp};
  const std::string expected = row_block_to_bytes(traced(settings, rect, 1));
  for (int threads = 2; threads <= 4; ++threads) {
    CHECK(row_block_to_bytes(traced(settings, rect, threads)) == expected);
  }
}

TEST_CASE(
    "a row block carries what it leaves out, and is refused when it leaves out anything else") {
  const RowBlock block = traced(settings_of(RowOrder::sequential), {1, 3, 2, 9}, 1);
  REQUIRE(block.excluded.size() == 2);
  CHECK(row_block_from_bytes(row_block_to_bytes(block)) == block);
  const auto refused = [&block](auto change) {
    RowBlock changed = block;
    change(changed);
    CHECK_THROWS_AS(row_block_from_bytes(row_block_to_bytes(changed)), DecodeError);
  };
  refused([](RowBlock& b) { b.excluded.pop_back(); });
  refused([](RowBlock& b) { b.counts.nonfinite += 1; });
  refused([](RowBlock& b) { b.excluded[0].count += 1; });
  refused([](RowBlock& b) { b.excluded[0].position = 0; });
  refused([](RowBlock& b) { b.excluded[0].position = 3; });
  refused([](RowBlock& b) { b.excluded[0].x = width; });
  refused([](RowBlock& b) { b.excluded[0].first = 1; });
  refused([](RowBlock& b) { b.excluded[0].first = 9; });
}

TEST_CASE("the report says which pixels lack samples") {
  Job job;
  job.record.settings = settings_of(RowOrder::sequential);
  const Scene scene = test::small_scene();
  job.start_work(std::make_shared<const std::string>(scene_to_bytes(scene)));
  job.work->framebuffer.merge(traced(job.record.settings, {0, height, 0, spp}, 1));
  job.work->started = Time(0);
  const auto report = finish_picture(job, seconds(1)).report;
  CHECK(report.at("nonfinite_samples") == holes());
  CHECK(report.at("nonfinite_pixels") == 3);
  REQUIRE(report.at("nonfinite").size() == 3);
  const auto& first = report.at("nonfinite").at(0);
  CHECK(first.at("x") == 3);
  CHECK(first.at("y") == 1);
  CHECK(first.at("first_sample") == 5);
  CHECK(first.at("samples") == 6);
}

}  // namespace
}  // namespace parray

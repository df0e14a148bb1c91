
#include <doctest/doctest.h>

#include <array>
#include <atomic>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/base/bytes.h"
#include "common/image/framebuffer.h"
#include "common/image/image.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"
#include "coordinator/jobs/report.h"
#include "tests/support/rooms.h"
#include "tests/support/window_rig.h"
#include "worker/cell_tracer.h"

/// Samples that are not finite: left out, counted and found. No scene is known that has them, so a
/// tracer with known holes stands in.
namespace parray {
namespace {

/// Radiance 0.25 in red, 0.5 in green and 1 in blue, but for the samples that `hole` names.
class HoleyTracer final : public PathTracer {
 public:
  HoleyTracer()
      : PathTracer(make_accelerator({}, Precision::f32, AcceleratorKind::linear, Isa::automatic)) {}

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
  void add_sky_samples(const PixelRun& /*run*/, const RunSamples& /*samples*/,
                       std::span<SkySamples> /*sky*/) const override {}
};

constexpr std::uint32_t holey_width = 9;
constexpr std::uint32_t holey_height = 5;
constexpr std::uint32_t holey_spp = 11;

RenderSettings holey_settings(RowOrder order) {
  RenderSettings settings;
  settings.width = holey_width;
  settings.height = holey_height;
  settings.samples_per_pixel = holey_spp;
  settings.row_order = order;
  return settings;
}

TracedCells traced_with_holes(const CellBatch& batch, int threads) {
  std::atomic<std::uint64_t> traced = 0;
  return trace_cells(HoleyTracer(), batch, threads, traced, false);
}

/// A picture whose samples are handed out in one pass, or in several.
JobPicture traced_picture(RowOrder order, bool progressive, int threads) {
  RenderSettings settings = holey_settings(order);
  settings.progressive = progressive;
  JobPicture picture(settings, SceneFacts(test::small_scene()));
  while (picture.begin_pass()) {
    const auto plan = picture.plan();
    for (std::uint64_t cell = plan->cells(); cell-- > 0;) {
      picture.collector().take(1, traced_with_holes(plan->batch({cell, cell + 1}), threads));
    }
  }
  return picture;
}

std::uint64_t holes() {
  std::uint64_t count = 0;
  for (std::uint32_t y = 0; y < holey_height; ++y) {
    for (std::uint32_t x = 0; x < holey_width; ++x) {
      for (std::uint32_t s = 0; s < holey_spp; ++s) count += HoleyTracer::hole(x, y, s) ? 1U : 0U;
    }
  }
  return count;
}

TEST_CASE("every sample that is not finite is found, with its pixel and its number") {
  const auto found =
      locate_nonfinite(HoleyTracer(), {2, 4, 9}, std::vector<SampleRange>(5, {3, 11}));
  REQUIRE(found.size() == 1);
  CHECK(found[0] == ExcludedSamples{2, 7, 6, 2});  // samples 6 and 10
  CHECK(locate_nonfinite(HoleyTracer(), {2, 0, 7}, std::vector<SampleRange>(7, {0, holey_spp}))
            .empty());
}

TEST_CASE("a lease that comes back in part names the excluded samples of that part alone") {
  const auto plan = test::whole_plan(holey_settings(RowOrder::sequential));
  const CellBatch batch = plan->batch({0, plan->cells()});
  std::atomic<std::uint64_t> count = 0;
  const TracedCells part = trace_cells(HoleyTracer(), batch, 3, count, false, 1e-12);
  const CellBatch first = plan->batch(part.range);
  REQUIRE(part.range.count() < batch.range.count());
  CHECK(fault_of(part, first, holey_settings(RowOrder::sequential).max_depth).empty());
  CHECK(part.excluded == traced_with_holes(first, 1).excluded);
}

TEST_CASE("a pixel is the mean of its finite samples, however the work is cut") {
  for (const RowOrder order : {RowOrder::sequential, RowOrder::interleaved}) {
    for (const bool progressive : {false, true}) {
      const JobPicture picture = traced_picture(order, progressive, 3);
      const Framebuffer& framebuffer = picture.framebuffer();
      CHECK(framebuffer.counts().nonfinite == holes());
      CHECK(framebuffer.excluded().size() == 3);
      const auto& nan_pixel = framebuffer.excluded().at({1, 3});
      CHECK(nan_pixel.first == 5);
      CHECK(nan_pixel.count == 6);
      const Image image = resolve_image(framebuffer, 1);
      for (std::size_t pixel = 0; pixel < std::size_t{holey_width} * holey_height; ++pixel) {
        const bool nothing_left = pixel == std::size_t{4} * holey_width;
        CAPTURE(pixel);
        CHECK(image.rgb[3 * pixel] == (nothing_left ? 0.0F : 0.25F));
        CHECK(image.rgb[3 * pixel + 1] == (nothing_left ? 0.0F : 0.5F));
        CHECK(image.rgb[3 * pixel + 2] == (nothing_left ? 0.0F : 1.0F));
      }
    }
  }
}

TEST_CASE("equal leases have equal bytes, holes included, for any number of threads") {
  const auto plan = test::whole_plan(holey_settings(RowOrder::interleaved));
  const CellBatch batch = plan->batch({0, plan->cells()});
  const std::string expected = pack_cells(traced_with_holes(batch, 1), *plan->grid());
  for (int threads = 2; threads <= 4; ++threads) {
    CHECK(pack_cells(traced_with_holes(batch, threads), *plan->grid()) == expected);
  }
}

TEST_CASE("a result carries what it leaves out, and is refused when it leaves out anything else") {
  const RenderSettings settings = holey_settings(RowOrder::sequential);
  const WorkPlan plan(settings, {{{2, 9}}, {}});
  const CellBatch batch = plan.batch({1, 3});
  const TracedCells cells = traced_with_holes(batch, 1);
  REQUIRE(cells.excluded.size() == 2);
  const TracedCells unpacked =
      unpack_cells(pack_cells(cells, *plan.grid()), batch, settings.max_depth);
  CHECK(unpacked.excluded == cells.excluded);
  const auto refused = [&](auto change) {
    TracedCells changed = cells;
    change(changed);
    CHECK_FALSE(fault_of(changed, batch, settings.max_depth).empty());
    CHECK_THROWS_AS(unpack_cells(pack_cells(changed, *plan.grid()), batch, settings.max_depth),
                    DecodeError);
  };
  refused([](TracedCells& c) { c.excluded.pop_back(); });
  refused([](TracedCells& c) { c.excluded[0].count += 1; });
  refused([](TracedCells& c) { c.excluded[0].y = 0; });
  refused([](TracedCells& c) { c.excluded[0].y = 3; });
  refused([](TracedCells& c) { c.excluded[0].x = holey_width; });
  refused([](TracedCells& c) { c.excluded[0].first = 1; });
  refused([](TracedCells& c) { c.excluded[0].first = 9; });
}

TEST_CASE("the report says which pixels lack samples") {
  const JobPicture picture = traced_picture(RowOrder::sequential, false, 1);
  JobRecord record;
  record.settings = picture.settings();
  RenderFacts facts;
  facts.render_seconds = 1;
  const auto report = nlohmann::json::parse(finish_picture(picture, record, facts).report);
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

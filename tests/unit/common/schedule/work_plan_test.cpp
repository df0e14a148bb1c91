#include "common/schedule/work_plan.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <tuple>
#include <vector>

#include "common/scene/limits.h"
#include "common/scene/settings.h"
#include "common/schedule/cell_grid.h"
#include "coordinator/jobs/job_picture.h"
#include "proto/window.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/window_rig.h"

namespace parray {
namespace {

using test::Dice;
using test::whole_plan;

constexpr std::uint64_t full_cell = 2048;  // samples that a cell should not exceed

RenderSettings sized(std::uint32_t width, std::uint32_t height, std::uint32_t spp) {
  RenderSettings settings;
  settings.width = width;
  settings.height = height;
  settings.samples_per_pixel = spp;
  settings.row_order = RowOrder::sequential;
  return settings;
}

struct Trial {
  RenderSettings settings;
  Pass pass;
  std::uint32_t tile = 0;

  [[nodiscard]] WorkPlan plan() const { return {settings, pass, tile}; }
};

/// Up to three stages, some of which begin where the one before has not ended.
Trial random_trial(Dice& dice) {
  Trial trial;
  const std::uint32_t spp = dice.one_in(3) ? 1 + dice.below32(9000) : 1 + dice.below32(60);
  const std::uint32_t most = std::max(1U, 100'000 / spp);
  const std::uint32_t width = 1 + dice.below32(std::min(most, 3000U));
  trial.settings = sized(width, 1 + dice.below32(std::min(most / width + 1, 60U)), spp);
  trial.settings.row_order = dice.one_in(2) ? RowOrder::sequential : RowOrder::interleaved;
  trial.settings.schedule = dice.one_in(2) ? SchedulePolicy::weighted : SchedulePolicy::guided;
  trial.tile = dice.one_in(2) ? dice.below32(2) : 2 + dice.below32(20);
  for (std::uint32_t begin = dice.below32(spp); begin < spp;) {
    const std::uint32_t end =
        trial.pass.stages.size() == 2 ? spp : begin + 1 + dice.below32(spp - begin);
    trial.pass.stages.push_back({begin, end});
    begin = end + dice.below32(3);
  }
  return trial;
}

/// How often each sample of each pixel is there.
class Samples {
 public:
  explicit Samples(const RenderSettings& settings)
      : width_(settings.width),
        spp_(settings.samples_per_pixel),
        times_(std::size_t{settings.width} * settings.height * spp_) {}
  void add(std::uint32_t y, std::uint32_t x, const SampleRange& samples) {
    const std::size_t first = (std::size_t{y} * width_ + x) * spp_;
    for (std::uint32_t s = samples.begin; s < samples.end; ++s) ++times_.at(first + s);
  }
  void add(const WorkPlan& plan) {
    const CellBatch batch = plan.batch({0, plan.cells()});
    for (std::uint64_t index = 0; index < plan.cells(); ++index) {
      const Cell cell = plan.cell(index);
      const auto ranges = batch.run_samples(index);
      for (std::uint32_t i = 0; i < cell.pixels(); ++i) add(cell.y, cell.x_begin + i, ranges[i]);
    }
  }
  friend bool operator==(const Samples&, const Samples&) = default;

 private:
  std::uint32_t width_;
  std::uint32_t spp_;
  std::vector<std::uint8_t> times_;
};

Samples wanted(const Trial& trial) {
  Samples samples(trial.settings);
  for (std::uint32_t y = 0; y < trial.settings.height; ++y) {
    for (std::uint32_t x = 0; x < trial.settings.width; ++x) {
      const std::size_t pixel = std::size_t{y} * trial.settings.width + x;
      for (const SampleRange& stage : trial.pass.stages) {
        samples.add(
            y, x, trial.pass.samples.empty() ? stage : common_of(stage, trial.pass.samples[pixel]));
      }
    }
  }
  return samples;
}

std::uint64_t samples_of(const WorkPlan& plan, std::uint64_t cell) {
  return plan.batch({cell, cell + 1}).sample_count();
}

/// Some pixels with none, most with a few, some with many of the samples.
std::vector<SampleRange> random_samples(Dice& dice, const RenderSettings& settings) {
  std::vector<SampleRange> samples(std::size_t{settings.width} * settings.height);
  for (SampleRange& pixel : samples) {
    pixel.begin = dice.below32(settings.samples_per_pixel);
    const std::uint32_t most = settings.samples_per_pixel - pixel.begin + 1;
    pixel.end =
        pixel.begin + (dice.one_in(4) ? 0 : dice.below32(dice.one_in(9) ? most : most / 8 + 1));
  }
  return samples;
}

}  // namespace

TEST_CASE("the cells of a plan hold every sample of every pixel exactly once") {
  Dice dice(1);
  for (int i = 0; i < 400; ++i) {
    CAPTURE(i);
    const Trial trial = random_trial(dice);
    Samples planned(trial.settings);
    planned.add(trial.plan());
    REQUIRE(planned == wanted(trial));
  }
}

TEST_CASE("where pixels have samples of their own, each is in exactly one cell, and no other") {
  Dice dice(6);
  for (int i = 0; i < 300; ++i) {
    CAPTURE(i);
    Trial trial = random_trial(dice);
    trial.pass.stages = {{0, trial.settings.samples_per_pixel}};
    trial.pass.samples = random_samples(dice, trial.settings);
    const WorkPlan plan = trial.plan();
    Samples planned(trial.settings);
    planned.add(plan);
    REQUIRE(planned == wanted(trial));
    std::uint64_t samples = 0;
    bool small = true;
    for (std::uint64_t index = 0; index < plan.cells(); ++index) {
      samples += samples_of(plan, index);
      small = small && samples_of(plan, index) <= 1U << 20;
    }
    CHECK(plan.samples() == samples);
    CHECK(small);
  }
}

TEST_CASE("a pass with a few pixels of very many samples has few cells, none of them long") {
  std::vector<SampleRange> samples(100'000, {30, 40});
  samples[5000] = {10'000, 400'000};
  samples[77] = {32, limits::max_samples_per_pixel};
  const WorkPlan plan(sized(1000, 100, 500), {{{30, limits::max_samples_per_pixel}}, samples});
  std::uint64_t longest = 0;
  for (std::uint64_t index = 0; index < plan.cells(); ++index) {
    longest = std::max(longest, samples_of(plan, index));
  }
  CHECK(longest <= 1U << 20);
  CHECK(WindowLayout(*plan.grid(), 1).bytes() < 2'000'000'000);
}

TEST_CASE("cells come in the order of stages, samples, bands, columns and rows") {
  Dice dice(2);
  for (int i = 0; i < 300; ++i) {
    CAPTURE(i);
    const Trial trial = random_trial(dice);
    const WorkPlan plan = trial.plan();
    const auto row_at = make_row_order(trial.settings.row_order, trial.settings.height);
    std::vector<std::uint32_t> position(row_at.size());
    for (std::uint32_t p = 0; p < row_at.size(); ++p) position[row_at[p]] = p;
    const auto order_of = [&](std::uint64_t index) {
      const Cell cell = plan.cell(index);
      const std::uint32_t band = position[cell.y] / plan.grid()->shape().band_rows;
      return std::tuple(cell.samples.begin, band, cell.x_begin, position[cell.y]);
    };
    bool sorted = true;
    for (std::uint64_t cell = 1; cell < plan.cells(); ++cell) {
      sorted = sorted && order_of(cell - 1) < order_of(cell);
    }
    CHECK(sorted);
  }
}

TEST_CASE("cells of lattices have every pixel of theirs once, and no other") {
  Dice dice(5);
  for (int i = 0; i < 60; ++i) {
    CAPTURE(i);
    const RenderSettings settings = sized(1 + dice.below32(300), 1 + dice.below32(300), 9);
    const auto lattices = nested_lattices(settings.width, settings.height);
    Pass pass;
    const std::size_t first = dice.below32(static_cast<std::uint32_t>(lattices.size()));
    std::vector<std::uint32_t> left(std::size_t{settings.width} * settings.height);
    std::uint64_t samples = 0;
    for (std::size_t l = first; l < lattices.size(); ++l) {
      const Lattice& lattice = lattices[l];
      pass.stages.emplace_back(3, 5, lattice);
      samples += 2 * lattice.pixels(settings.width, settings.height);
      for (std::uint32_t y = lattice.y; y < settings.height; y += lattice.step) {
        for (std::uint32_t x = lattice.x; x < settings.width; x += lattice.step) {
          left[std::size_t{y} * settings.width + x] = 2;
        }
      }
    }
    const WorkPlan plan(settings, std::move(pass));
    CHECK(plan.samples() == samples);
    CHECK(plan.batch({0, plan.cells()}).sample_count() == samples);
    for (std::uint64_t index = 0; index < plan.cells(); ++index) {
      const Cell cell = plan.cell(index);
      const auto columns = plan.batch({index, index + 1}).column_ranges_of(index);
      REQUIRE(columns.size() == cell.x_end - cell.x_begin);
      std::uint32_t pixels = 0;
      for (std::uint32_t x = cell.x_begin; x < cell.x_end; ++x) {
        pixels += columns[x - cell.x_begin].count() > 0 ? 1 : 0;
        left[std::size_t{cell.y} * settings.width + x] -= columns[x - cell.x_begin].count();
      }
      REQUIRE(pixels == cell.pixels());
      const auto same = plan.grid()->cells_of_same_pixels(index);
      REQUIRE(std::find(same.begin(), same.end(), index) != same.end());
    }
    CHECK(left == std::vector<std::uint32_t>(left.size(), 0));
  }
}

TEST_CASE("a cell is small, and no larger than the plan says") {
  Dice dice(4);
  for (int i = 0; i < 300; ++i) {
    const Trial trial = random_trial(dice);
    const WorkPlan plan = trial.plan();
    const std::uint64_t most =
        trial.tile > 1 ? std::uint64_t{trial.tile} * trial.settings.samples_per_pixel : full_cell;
    bool small = true;
    for (std::uint64_t index = 0; index < plan.cells(); ++index) {
      small = small && samples_of(plan, index) > 0 && samples_of(plan, index) <= most &&
              plan.cell(index).pixels() <= plan.grid()->shape().cell_pixels;
    }
    CHECK(small);
    CHECK(plan.grid()->shape().piece_cells == std::max(trial.tile, 1U));
  }
}

TEST_CASE("a piece of a plan with tiles is a square of the image") {
  const auto plan = whole_plan(sized(64, 48, 5), 16);
  REQUIRE(plan->cells() == 48 * 4);
  for (std::uint64_t piece = 0; piece < plan->cells(); piece += 16) {
    const Cell first = plan->cell(piece);
    for (std::uint32_t i = 0; i < 16; ++i) {
      CHECK(plan->cell(piece + i) == Cell{first.y + i, first.x_begin, first.x_begin + 16, {0, 5}});
    }
  }
}

TEST_CASE("a plan keeps its cells' numbers whatever is done of it") {
  Dice dice(8);
  for (int i = 0; i < 50; ++i) {
    CAPTURE(i);
    RenderSettings settings = sized(1 + dice.below32(60), 1 + dice.below32(30), 50);
    settings.progressive = dice.one_in(2);
    const SceneFacts facts(test::small_scene());
    JobPicture first(settings, facts);
    first.begin_pass();
    JobPicture second(settings, facts);
    for (std::uint64_t cell = 0; cell < first.plan()->cells(); ++cell) {
      if (dice.one_in(3)) {
        const TracedCells cells = test::made_cells(first.plan()->batch({cell, cell + 1}));
        first.collector().take(1, cells);
        second.replay(first.cells_entry(1, cells.range, pack_cells(cells, *first.plan()->grid())));
      }
    }
    if (second.has_begun()) {
      CHECK(second.plan()->grid()->shape() == first.plan()->grid()->shape());
      CHECK(second.collector().missing() == first.collector().missing());
    }
  }
}

TEST_CASE("one pixel with a million samples is shared as ranges of samples") {
  const auto plan = whole_plan(sized(1, 1, 1'000'000));
  CHECK(plan->cells() == 489);
  CHECK(plan->cell(0) == Cell{0, 0, 1, {0, 2048}});
  CHECK(plan->cell(488) == Cell{0, 0, 1, {488 * 2048, 1'000'000}});
}

TEST_CASE("one row of the greatest width is shared as runs of pixels") {
  const auto plan = whole_plan(sized(65'536, 1, 10));
  CHECK(plan->grid()->shape().cell_pixels == 204);
  CHECK(plan->cells() == 322);
  CHECK(plan->cell(321) == Cell{0, 321 * 204, 65'536, {0, 10}});
}

TEST_CASE("plans of the greatest images are exact, and no longer than memory allows") {
  for (const std::uint32_t width : {1024U, 8192U, limits::max_image_side}) {
    const auto height = static_cast<std::uint32_t>(limits::max_pixels / width);
    for (const std::uint32_t spp : {1U, 1000U, 3000U, limits::max_samples_per_pixel}) {
      for (const std::uint32_t tile : {0U, 64U}) {
        CAPTURE(width);
        CAPTURE(spp);
        CAPTURE(tile);
        const auto plan = whole_plan(sized(width, height, spp), tile);
        const WindowLayout layout(*plan->grid(), 6);
        CHECK(plan->cells() <= std::uint64_t{limits::max_pixels} * 2);
        CHECK(layout.record_offset(plan->cells() - 1) + layout.record_bytes() == layout.bytes());
        const Cell last = plan->cell(plan->cells() - 1);
        CHECK(last.y == height - 1);
        CHECK(last.x_end == width);
        CHECK(last.samples.end == spp);
      }
    }
  }
}

TEST_CASE("places in a list of cells are those cells, in as few ranges as there can be") {
  const CellList list({{3, 5}, {9, 10}, {20, 26}});
  CHECK(list.count() == 9);
  CHECK(list.cells_at({0, 9}) == list.ranges());
  CHECK(list.cells_at({1, 4}) == std::vector<CellRange>{{4, 5}, {9, 10}, {20, 21}});
  CHECK(list.cells_at({4, 6}) == std::vector<CellRange>{{21, 23}});
  CHECK(list.cells_at({2, 3}) == std::vector<CellRange>{{9, 10}});
  CHECK(list.cells_at({2, 2}).empty());
  CHECK(CellList().count() == 0);
  CHECK(CellList(std::vector<CellRange>()).count() == 0);
}

}  // namespace parray

#include "common/schedule/work_plan.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <span>
#include <tuple>
#include <vector>

#include "common/scene/limits.h"
#include "common/schedule/row_order.h"
#include "proto/window.h"
#include "tests/support/dice.h"

namespace parray {
namespace {

using test::Dice;

constexpr std::uint64_t full_cell = 2048;  // samples that a cell should not exceed

struct Trial {
  RenderSettings settings;
  std::vector<WorkRect> pending;
  std::uint32_t tile = 0;

  std::vector<SampleRange> samples{};  ///< of each pixel, image order; empty: all

  [[nodiscard]] WorkPlan plan() const { return {settings, pending, tile, samples}; }
};

RenderSettings sized(std::uint32_t width, std::uint32_t height, std::uint32_t spp) {
  RenderSettings settings;
  settings.width = width;
  settings.height = height;
  settings.samples_per_pixel = spp;
  return settings;
}

Trial whole(std::uint32_t width, std::uint32_t height, std::uint32_t spp, std::uint32_t tile = 0) {
  return {sized(width, height, spp), {{0, height, 0, spp}}, tile};
}

/// Bands of rows, some of them done, each with one or two ranges of samples left; in any order.
std::vector<WorkRect> random_pending(Dice& dice, const RenderSettings& settings) {
  std::vector<WorkRect> rects;
  const std::uint32_t spp = settings.samples_per_pixel;
  for (std::uint32_t row = 0; row < settings.height;) {
    const std::uint32_t end = row + 1 + dice.below32(settings.height - row);
    const std::uint32_t cut = dice.below32(spp + 1);
    if (!dice.one_in(4)) {
      if (cut > 0) {
        rects.push_back({row, end, 0, cut});
      }
      const std::uint32_t begin = cut + dice.below32(spp - cut + 1);
      if (begin < spp) {
        rects.push_back({row, end, begin, spp});
      }
    }
    row = end;
  }
  for (std::size_t i = rects.size(); i > 1; --i) {
    std::swap(rects[i - 1], rects[dice.below(i)]);
  }
  return rects;
}

Trial random_trial(Dice& dice) {
  Trial trial;
  const std::uint32_t spp = dice.one_in(3) ? 1 + dice.below32(9000) : 1 + dice.below32(60);
  const std::uint32_t most = std::max(1U, 100'000 / spp);
  const std::uint32_t width = 1 + dice.below32(std::min(most, 3000U));
  trial.settings = sized(width, 1 + dice.below32(std::min(most / width + 1, 60U)), spp);
  trial.pending = random_pending(dice, trial.settings);
  trial.tile = dice.one_in(2) ? dice.below32(2) : 2 + dice.below32(20);
  return trial;
}

/// How often each sample of each pixel is wanted.
class Samples {
 public:
  explicit Samples(const RenderSettings& settings)
      : width_(settings.width),
        spp_(settings.samples_per_pixel),
        times_(std::size_t{settings.width} * settings.height * spp_) {}
  void add(const Cell& cell) {
    for (std::uint32_t i = 0; i < cell.pixels(); ++i) {
      const std::size_t first = (std::size_t{cell.position} * width_ + cell.x_begin + i) * spp_;
      const SampleRange samples = cell.samples_of(i);
      for (std::uint32_t s = samples.begin; s < samples.end; ++s) {
        ++times_[first + s];
      }
    }
  }
  void add(const WorkRect& rect) {
    for (std::uint32_t row = rect.row_begin; row < rect.row_end; ++row) {
      add(Cell{row, 0, width_, rect.sample_begin, rect.sample_end});
    }
  }
  friend bool operator==(const Samples&, const Samples&) = default;

 private:
  std::uint32_t width_;
  std::uint32_t spp_;
  std::vector<std::uint8_t> times_;
};

/// What cells are sorted by.
auto order_of(const WorkPlan& plan, std::uint64_t index) {
  const Cell cell = plan.cell(index);
  const auto& rects = plan.rects();
  const auto rect = static_cast<std::size_t>(
      std::find_if(rects.begin(), rects.end(),
                   [&](const WorkRect& r) {
                     return r.row_begin <= cell.position && cell.position < r.row_end &&
                            r.sample_begin <= cell.sample_begin && cell.sample_begin < r.sample_end;
                   }) -
      rects.begin());
  const std::uint32_t band = (cell.position - rects.at(rect).row_begin) / plan.band_rows();
  return std::tuple(rect, cell.sample_begin, band, cell.x_begin, cell.position);
}

/// pass_of(), pass_rect() and pass_cells() of one pass, against its cells.
bool is_row_of_cells(const WorkPlan& plan, std::uint64_t pass, std::uint32_t width) {
  const WorkRect rect = plan.pass_rect(pass);
  const WorkPlan::Stride stride = plan.pass_cells(pass);
  std::uint32_t x = 0;
  for (std::uint64_t i = 0; i < plan.cells_per_row(); ++i) {
    const std::uint64_t index = stride.first + i * stride.step;
    const Cell cell = plan.cell(index);
    const Cell expected{rect.row_begin, x, cell.x_end, rect.sample_begin, rect.sample_end};
    if (index >= plan.cells() || plan.pass_of(index) != pass || cell != expected ||
        cell.x_end <= x) {
      return false;
    }
    x = cell.x_end;
  }
  return rect.rows() == 1 && x == width;
}

}  // namespace

TEST_CASE("the cells of a plan hold every pending sample of every pixel exactly once") {
  Dice dice(1);
  for (int i = 0; i < 400; ++i) {
    const Trial trial = random_trial(dice);
    CAPTURE(i);
    const WorkPlan plan = trial.plan();
    Samples wanted(trial.settings);
    Samples planned(trial.settings);
    Samples passes(trial.settings);
    for (const WorkRect& rect : trial.pending) {
      wanted.add(rect);
    }
    for (std::uint64_t cell = 0; cell < plan.cells(); ++cell) {
      planned.add(plan.cell(cell));
    }
    for (std::uint64_t pass = 0; pass < plan.passes(); ++pass) {
      passes.add(plan.pass_rect(pass));
    }
    REQUIRE(planned == wanted);
    REQUIRE(passes == wanted);
  }
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

TEST_CASE("in a pass every sample that a pixel has is in exactly one cell, and no other") {
  Dice dice(6);
  for (int i = 0; i < 300; ++i) {
    CAPTURE(i);
    Trial trial = random_trial(dice);
    trial.settings.row_order = dice.one_in(2) ? RowOrder::sequential : RowOrder::interleaved;
    trial.samples = random_samples(dice, trial.settings);
    const auto row_at = make_row_order(trial.settings.row_order, trial.settings.height);
    const WorkPlan plan = trial.plan();
    Samples wanted(trial.settings);
    std::uint64_t samples = 0;
    for (const WorkRect& rect : trial.pending) {
      for (std::uint32_t row = rect.row_begin; row < rect.row_end; ++row) {
        const std::size_t first = std::size_t{row_at[row]} * trial.settings.width;
        Cell cell{row, 0, trial.settings.width, rect.sample_begin, rect.sample_end};
        cell.pass = std::span(trial.samples).subspan(first, trial.settings.width);
        wanted.add(cell);
      }
    }
    Samples planned(trial.settings);
    bool small = true;
    for (std::uint64_t index = 0; index < plan.cells(); ++index) {
      const Cell cell = plan.cell(index);
      planned.add(cell);
      samples += cell.samples();
      small = small && cell.pixels() <= plan.cell_pixels() && cell.samples() <= 1U << 20;
    }
    REQUIRE(planned == wanted);
    CHECK(plan.samples() == samples);
    CHECK(small);
    CHECK(plan.passes() * plan.cells_per_row() == plan.cells());
  }
}

TEST_CASE("a pass with a few pixels of very many samples has few cells, none of them long") {
  const RenderSettings settings = sized(1000, 100, 500);
  std::vector<SampleRange> samples(100'000, {30, 40});
  samples[5000] = {10'000, 400'000};
  samples[77] = {32, limits::max_samples_per_pixel};
  const WorkPlan plan(settings, {{0, 100, 30, limits::max_samples_per_pixel}}, 0, samples);
  std::uint64_t longest = 0;
  for (std::uint64_t index = 0; index < plan.cells(); ++index) {
    longest = std::max(longest, plan.cell(index).samples());
  }
  CHECK(longest <= 1U << 20);
  CHECK(WindowLayout(plan, 1).bytes() < 2'000'000'000);
}

TEST_CASE("cells come in the order of rectangles, samples, bands, columns and rows") {
  Dice dice(2);
  for (int i = 0; i < 300; ++i) {
    const Trial trial = random_trial(dice);
    CAPTURE(i);
    const WorkPlan plan = trial.plan();
    bool sorted = true;
    for (std::uint64_t cell = 1; cell < plan.cells(); ++cell) {
      sorted = sorted && order_of(plan, cell - 1) < order_of(plan, cell);
    }
    CHECK(sorted);
  }
}

TEST_CASE("a row pass is made of the cells that say so, from left to right") {
  Dice dice(3);
  for (int i = 0; i < 300; ++i) {
    const Trial trial = random_trial(dice);
    CAPTURE(i);
    const WorkPlan plan = trial.plan();
    CHECK(plan.passes() * plan.cells_per_row() == plan.cells());
    for (std::uint64_t pass = 0; pass < plan.passes(); ++pass) {
      REQUIRE(is_row_of_cells(plan, pass, trial.settings.width));
    }
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
      const Cell cell = plan.cell(index);
      small = small && cell.samples() > 0 && cell.samples() <= most &&
              cell.pixels() <= plan.cell_pixels() &&
              static_cast<double>(cell.samples()) <= plan.cell_samples();
    }
    CHECK(small);
    CHECK(plan.piece_cells() == std::max(trial.tile, 1U));
  }
}

TEST_CASE("a piece of a plan with tiles is a square of the image") {
  const WorkPlan plan = whole(64, 48, 5, 16).plan();
  REQUIRE(plan.cells() == 48 * 4);
  for (std::uint64_t piece = 0; piece < plan.cells(); piece += plan.piece_cells()) {
    const Cell first = plan.cell(piece);
    for (std::uint32_t i = 0; i < 16; ++i) {
      CHECK(plan.cell(piece + i) ==
            Cell{first.position + i, first.x_begin, first.x_begin + 16, 0, 5});
    }
  }
}

TEST_CASE("nothing pending is no cells") {
  const WorkPlan plan(sized(20, 10, 5), {});
  CHECK(plan.cells() == 0);
  CHECK(plan.passes() == 0);
}

TEST_CASE("one pixel with a million samples is shared as ranges of samples") {
  const WorkPlan plan = whole(1, 1, 1'000'000).plan();
  CHECK(plan.cells() == 489);
  CHECK(plan.layers(0) == 489);
  CHECK(plan.cell(0) == Cell{0, 0, 1, 0, 2048});
  CHECK(plan.cell(488) == Cell{0, 0, 1, 488 * 2048, 1'000'000});
}

TEST_CASE("one row of the greatest width is shared as runs of pixels") {
  const WorkPlan plan = whole(65'536, 1, 10).plan();
  CHECK(plan.cell_pixels() == 204);
  CHECK(plan.cells() == 322);
  CHECK(plan.cell(321) == Cell{0, 321 * 204, 65'536, 0, 10});
  CHECK(is_row_of_cells(plan, 0, 65'536));
}

TEST_CASE("plans of the greatest images are exact, and no longer than memory allows") {
  Dice dice(5);
  for (const std::uint32_t width : {1024U, 8192U, limits::max_image_side}) {
    const auto height = static_cast<std::uint32_t>(limits::max_pixels / width);
    for (const std::uint32_t spp : {1U, 1000U, 3000U, limits::max_samples_per_pixel}) {
      for (const std::uint32_t tile : {0U, 64U}) {
        CAPTURE(width);
        CAPTURE(spp);
        CAPTURE(tile);
        const WorkPlan plan = whole(width, height, spp, tile).plan();
        const WindowLayout layout(plan, 6);
        CHECK(plan.cells() <= 1U << 24);
        CHECK(layout.bytes() > std::size_t{1} << 31);
        CHECK(layout.record_offset(plan.cells() - 1) + layout.record_bytes() == layout.bytes());
        const Cell last = plan.cell(plan.cells() - 1);
        CHECK(last.position == height - 1);
        CHECK(last.x_end == width);
        CHECK(last.sample_end == spp);
        for (int i = 0; i < 50; ++i) {
          CHECK(is_row_of_cells(plan, dice.below(plan.passes()), width));
        }
      }
    }
  }
}

}  // namespace parray

#include "common/schedule/cell_grid.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <string>

#include "common/base/divide_up.h"
#include "common/base/error.h"
#include "common/scene/limits.h"

namespace parray::schedule {
namespace {

void check(bool good, const char* what) {
  if (!good) throw InputError(std::string("impossible grid of cells: ") + what + " out of range");
}

void check_shape(const GridShape& s) {
  constexpr std::uint32_t most = 1U << 16;
  constexpr std::size_t most_stages = 64;
  const auto within = [](std::uint32_t value, std::uint32_t highest) {
    return value >= 1 && value <= highest;
  };
  check(within(s.width, limits::max_image_side), "width");
  check(within(s.height, limits::max_image_side), "height");
  check(std::uint64_t{s.width} * s.height <= limits::max_pixels, "pixels");
  check(within(s.band_rows, most), "band_rows");
  check(within(s.cell_pixels, s.width), "cell_pixels");
  check(s.layer_samples >= 1, "layer_samples");
  check(within(s.piece_cells, most), "piece_cells");
  check(!s.stages.empty() && s.stages.size() <= most_stages, "stages");
  for (std::size_t i = 0; i < s.stages.size(); ++i) {
    const Stage& stage = s.stages[i];
    const Lattice& lattice = stage.lattice;
    check(stage.begin < stage.end, "stages");
    check(within(lattice.step, limits::max_image_side) && lattice.x < lattice.step &&
              lattice.y < lattice.step && lattice.pixels(s.width, s.height) > 0,
          "stages");
    for (std::size_t before = 0; before < i; ++before) {
      const Stage& earlier = s.stages[before];
      check(earlier.lattice != lattice || earlier.end <= stage.begin, "stages");
    }
  }
}

std::uint32_t reverse_bits(std::uint32_t value, int bits) {
  std::uint32_t result = 0;
  for (int b = 0; b < bits; ++b) result = result << 1 | (value >> b & 1U);
  return result;
}

}  // namespace

std::vector<std::uint32_t> make_row_order(RowOrder order, std::uint32_t height) {
  std::vector<std::uint32_t> rows;
  rows.reserve(height);
  if (order != RowOrder::interleaved) {
    rows.resize(height);
    std::iota(rows.begin(), rows.end(), 0U);
    return rows;
  }
  const int bits = height > 1 ? static_cast<int>(std::bit_width(height - 1)) : 0;
  for (std::uint32_t i = 0; i < 1ULL << bits; ++i) {
    const std::uint32_t row = reverse_bits(i, bits);
    if (row < height) rows.push_back(row);
  }
  return rows;
}

CellGrid::CellGrid(GridShape shape) : shape_(std::move(shape)) {
  check_shape(shape_);
  constexpr std::uint64_t most_cells = 1ULL << 40;
  first_cell_.push_back(0);
  for (const Stage& stage : shape_.stages) {
    const bool same = !parts_.empty() && shape_.stages[parts_.size() - 1].lattice == stage.lattice;
    Part part = same ? parts_.back() : Part{};
    if (!same) {
      part.columns = divide_up(stage.lattice.across(shape_.width), shape_.cell_pixels);
      part.row_at = make_row_order(shape_.row_order, stage.lattice.down(shape_.height));
    }
    part.layers = divide_up(stage.count(), shape_.layer_samples);
    // Up to 2^32 layers of at most 2^26 cells each.
    first_cell_.push_back(first_cell_.back() + part.layers * part.layer_cells());
    if (first_cell_.back() >= most_cells) {
      throw InputError("impossible grid of cells: too many cells");
    }
    parts_.push_back(std::move(part));
  }
}

CellGrid::Place CellGrid::place_of(std::uint64_t cell) const {
  const auto stage = static_cast<std::size_t>(std::ranges::upper_bound(first_cell_, cell) -
                                              first_cell_.begin() - 1);
  const Part& part = parts_[stage];
  const std::uint64_t in_stage = cell - first_cell_[stage];
  const std::uint64_t within_layer = in_stage % part.layer_cells();
  const std::uint64_t first_row =
      within_layer / (shape_.band_rows * part.columns) * shape_.band_rows;
  const std::uint64_t rows =
      std::min<std::uint64_t>(shape_.band_rows, part.row_at.size() - first_row);
  const std::uint64_t in_band = within_layer - first_row * part.columns;
  const std::uint64_t row = in_band % rows;
  return {stage,       in_stage / part.layer_cells(), first_row + row, in_band / rows, rows - row,
          within_layer};
}

Cell CellGrid::cell(std::uint64_t index) const { return cell_at(place_of(index)); }

/// Within a column of a band only the row changes.
std::vector<Cell> CellGrid::cells_of(const CellRange& range) const {
  std::vector<Cell> cells;
  cells.reserve(range.count());
  for (std::uint64_t index = range.begin; index < range.end;) {
    const Place top = place_of(index);
    const Stage& stage = shape_.stages[top.stage];
    const std::uint32_t* const rows = parts_[top.stage].row_at.data() + top.position;
    const std::uint64_t count = std::min(top.rows_left, range.end - index);
    Cell cell = cell_at(top);
    for (std::uint64_t row = 0; row < count; ++row) {
      cell.y = stage.lattice.y + rows[row] * stage.lattice.step;
      cells.push_back(cell);
    }
    index += count;
  }
  return cells;
}

Cell CellGrid::cell_at(const Place& place) const {
  const Stage& stage = shape_.stages[place.stage];
  const Lattice& lattice = stage.lattice;
  const auto first = static_cast<std::uint32_t>(place.column) * shape_.cell_pixels;
  const std::uint32_t last = std::min(first + shape_.cell_pixels, lattice.across(shape_.width)) - 1;
  const auto begin = stage.begin + static_cast<std::uint32_t>(place.layer * shape_.layer_samples);
  return {lattice.y + parts_[place.stage].row_at[place.position] * lattice.step,
          lattice.x + first * lattice.step,
          lattice.x + last * lattice.step + 1,
          {begin, begin + std::min(shape_.layer_samples, stage.end - begin)},
          lattice.step};
}

std::vector<std::uint64_t> CellGrid::cells_of_same_pixels(std::uint64_t cell) const {
  const Place place = place_of(cell);
  std::vector<std::uint64_t> same;
  for (std::size_t stage = 0; stage < parts_.size(); ++stage) {
    if (shape_.stages[stage].lattice != shape_.stages[place.stage].lattice) continue;
    for (std::uint64_t first = first_cell_[stage]; first < first_cell_[stage + 1];
         first += parts_[stage].layer_cells()) {
      same.push_back(first + place.within_layer);
    }
  }
  return same;
}

CellList::CellList(std::vector<CellRange> ranges) : ranges_(std::move(ranges)), first_{0} {
  for (const CellRange& range : ranges_) first_.push_back(first_.back() + range.count());
}

std::vector<CellRange> CellList::cells_at(const CellRange& places) const {
  std::vector<CellRange> cells;
  std::uint64_t place = places.begin;
  auto at = static_cast<std::size_t>(std::ranges::upper_bound(first_, place) - first_.begin() - 1);
  for (; place < places.end; place = first_[at]) {
    const std::uint64_t begin = ranges_[at].begin + (place - first_[at]);
    cells.push_back({begin, std::min(begin + (places.end - place), ranges_[at].end)});
    ++at;
  }
  return cells;
}

std::vector<SampleRange> CellBatch::column_ranges_of(std::uint64_t index) const {
  const Cell cell = grid->cell(index);
  const RunSamples view = run_samples(index);
  std::vector<SampleRange> ranges(cell.x_end - cell.x_begin);
  for (std::size_t i = 0; i < cell.pixels(); ++i) ranges[i * cell.step] = view[i];
  return ranges;
}

RunSamples CellBatch::run_samples(std::uint64_t index, const Cell& cell) const {
  if (samples.empty()) return RunSamples(cell.samples);
  const std::size_t pixels = grid->shape().cell_pixels;
  return RunSamples(std::span(samples).subspan((index - range.begin) * pixels, pixels));
}

std::uint64_t CellBatch::sample_count(std::span<const Cell> cells) const {
  std::uint64_t count = 0;
  if (samples.empty()) {
    for (const Cell& cell : cells) count += std::uint64_t{cell.pixels()} * cell.samples.count();
    return count;
  }
  for (const SampleRange& pixel : samples) count += pixel.count();
  return count;
}

}  // namespace parray::schedule

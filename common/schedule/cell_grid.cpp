#include "common/schedule/cell_grid.h"

#include <algorithm>
#include <string>

#include "common/base/divide_up.h"
#include "common/base/error.h"
#include "common/scene/limits.h"
#include "common/schedule/row_order.h"

namespace parray {
namespace {

void check(bool good, const char* what) {
  if (!good) {
    throw InputError(std::string("impossible grid of cells: ") + what);
  }
}

void check_shape(const GridShape& s) {
  constexpr std::uint32_t most = 1U << 16;
  constexpr std::size_t most_stages = 8;
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
  std::uint32_t end = 0;
  for (const SampleRange& stage : s.stages) {
    check(stage.begin >= end && stage.begin < stage.end, "stages");
    end = stage.end;
  }
}

}  // namespace

CellGrid::CellGrid(GridShape shape) : shape_(std::move(shape)) {
  check_shape(shape_);
  columns_ = divide_up(shape_.width, shape_.cell_pixels);
  row_at_ = make_row_order(shape_.row_order, shape_.height);
  constexpr std::uint64_t most_cells = 1ULL << 40;
  first_cell_.push_back(0);
  for (std::size_t stage = 0; stage < shape_.stages.size(); ++stage) {
    // Up to 2^32 layers of at most 2^26 cells each.
    first_cell_.push_back(first_cell_.back() + layers(stage) * shape_.height * columns_);
    check(first_cell_.back() < most_cells, "too many cells");
  }
}

std::uint64_t CellGrid::layers(std::size_t stage) const {
  return divide_up(shape_.stages[stage].count(), shape_.layer_samples);
}

CellGrid::Place CellGrid::place_of(std::uint64_t cell) const {
  const auto stage = static_cast<std::size_t>(
      std::upper_bound(first_cell_.begin(), first_cell_.end(), cell) - first_cell_.begin() - 1);
  const std::uint64_t layer_cells = shape_.height * columns_;
  const std::uint64_t in_stage = cell - first_cell_[stage];
  const std::uint64_t within_layer = in_stage % layer_cells;
  const std::uint64_t first_row = within_layer / (shape_.band_rows * columns_) * shape_.band_rows;
  const std::uint64_t rows = std::min<std::uint64_t>(shape_.band_rows, shape_.height - first_row);
  const std::uint64_t in_band = within_layer - first_row * columns_;
  return {stage, in_stage / layer_cells, first_row + in_band % rows, in_band / rows, within_layer};
}

Cell CellGrid::cell(std::uint64_t index) const {
  const Place place = place_of(index);
  const SampleRange stage = shape_.stages[place.stage];
  const auto x = static_cast<std::uint32_t>(place.column) * shape_.cell_pixels;
  const auto begin = stage.begin + static_cast<std::uint32_t>(place.layer * shape_.layer_samples);
  return {row_at_[place.position],
          x,
          std::min(x + shape_.cell_pixels, shape_.width),
          {begin, begin + std::min(shape_.layer_samples, stage.end - begin)}};
}

std::vector<std::uint64_t> CellGrid::cells_of_same_pixels(std::uint64_t cell) const {
  const std::uint64_t within_layer = place_of(cell).within_layer;
  const std::uint64_t layer_cells = shape_.height * columns_;
  std::vector<std::uint64_t> same;
  for (std::uint64_t first = 0; first < cells(); first += layer_cells) {
    same.push_back(first + within_layer);
  }
  return same;
}

std::vector<SampleRange> CellBatch::ranges_of(std::uint64_t index) const {
  const RunSamples view = run_samples(index);
  std::vector<SampleRange> ranges(grid->cell(index).pixels());
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    ranges[i] = view[i];
  }
  return ranges;
}

RunSamples CellBatch::run_samples(std::uint64_t index) const {
  if (samples.empty()) {
    return RunSamples(grid->cell(index).samples);
  }
  const std::size_t pixels = grid->shape().cell_pixels;
  return RunSamples(std::span(samples).subspan((index - range.begin) * pixels, pixels));
}

std::uint64_t CellBatch::sample_count() const {
  std::uint64_t count = 0;
  if (samples.empty()) {
    for (std::uint64_t index = range.begin; index < range.end; ++index) {
      const Cell cell = grid->cell(index);
      count += std::uint64_t{cell.pixels()} * cell.samples.count();
    }
    return count;
  }
  for (const SampleRange& pixel : samples) {
    count += pixel.count();
  }
  return count;
}

}  // namespace parray

#include "common/schedule/work_plan.h"

#include <algorithm>

namespace parray {
namespace {

std::uint64_t divide_up(std::uint64_t a, std::uint64_t b) { return a / b + (a % b != 0 ? 1 : 0); }

/// Small enough that the threads of a rank end together, large enough that dealing cells out costs
/// nothing.
constexpr std::uint64_t least_cell_samples = 2048;
/// More cells would only cost memory.
constexpr std::uint64_t most_cells = 1U << 22;
/// Of a cell where there are tiles: about a tenth of a second.
constexpr std::uint64_t most_tile_samples = 1U << 20;
/// Interleaved rows that are cut across together: a lease of this many cells samples as many rows
/// of the whole image, so that what it costs says how fast a rank is, and not where it was at work.
/// More would keep rows from being finished, and kept, for longer.
constexpr std::uint32_t interleaved_band = 16;

}  // namespace

WorkPlan::WorkPlan(const RenderSettings& settings, std::vector<WorkRect> pending,
                   std::uint32_t tile)
    : width_(settings.width), tile_(std::max(tile, 1U)), band_(tile_), rects_(std::move(pending)) {
  // The other policies deal out whole rows.
  if (tile_ == 1 && settings.schedule == SchedulePolicy::weighted &&
      settings.row_order != RowOrder::sequential) {
    band_ = interleaved_band;
  }
  const std::uint64_t spp = settings.samples_per_pixel;
  const std::uint64_t total = spp * settings.width * settings.height;
  const std::uint64_t grain = std::max(least_cell_samples, divide_up(total, most_cells));
  cell_pixels_ = static_cast<std::uint32_t>(std::clamp<std::uint64_t>(grain / spp, 1, width_));
  layer_samples_ = static_cast<std::uint32_t>(std::min(grain, spp));
  if (tile_ > 1) {
    cell_pixels_ = std::min(tile_, width_);
    // A tile's cells are longer, but not so long that a rank could not be told to stop.
    layer_samples_ = static_cast<std::uint32_t>(
        std::min(spp, divide_up(std::max(most_tile_samples, grain), cell_pixels_)));
  }
  columns_ = divide_up(width_, cell_pixels_);
  first_cell_.push_back(0);
  first_pass_.push_back(0);
  for (std::size_t i = 0; i < rects_.size(); ++i) {
    const std::uint64_t rows = std::uint64_t{layers(i)} * rects_[i].rows();
    first_pass_.push_back(first_pass_.back() + rows);
    first_cell_.push_back(first_cell_.back() + rows * columns_);
  }
}

std::uint64_t WorkPlan::samples() const {
  std::uint64_t units = 0;
  for (const WorkRect& rect : rects_) {
    units += rect.units();
  }
  return units * width_;
}

double WorkPlan::cell_samples() const {
  return static_cast<double>(cell_pixels_) * static_cast<double>(layer_samples_);
}

std::uint32_t WorkPlan::layers(std::size_t rect) const {
  return static_cast<std::uint32_t>(divide_up(rects_[rect].samples(), layer_samples_));
}

std::size_t WorkPlan::rect_of(const std::vector<std::uint64_t>& first, std::uint64_t index) {
  return static_cast<std::size_t>(std::upper_bound(first.begin(), first.end(), index) -
                                  first.begin()) -
         1;
}

/// Order within a rectangle: range of samples, band of rows, column, row of the band. A band has
/// one row where policies deal out whole rows.
WorkPlan::Place WorkPlan::place_of(std::uint64_t cell) const {
  const std::size_t rect = rect_of(first_cell_, cell);
  std::uint64_t index = cell - first_cell_[rect];
  const std::uint64_t rows = rects_[rect].rows();
  const auto layer = static_cast<std::uint32_t>(index / (rows * columns_));
  index %= rows * columns_;
  const std::uint64_t band = index / (band_ * columns_);
  const std::uint64_t band_rows = std::min<std::uint64_t>(band_, rows - band * band_);
  index -= band * band_ * columns_;
  return {rect, layer, static_cast<std::uint32_t>(band * band_ + index % band_rows),
          index / band_rows};
}

Cell WorkPlan::cell(std::uint64_t index) const {
  const Place place = place_of(index);
  const WorkRect& rect = rects_[place.rect];
  Cell cell;
  cell.position = rect.row_begin + place.row;
  cell.x_begin = static_cast<std::uint32_t>(place.column) * cell_pixels_;
  cell.x_end = std::min(cell.x_begin + cell_pixels_, width_);
  cell.sample_begin = rect.sample_begin + place.layer * layer_samples_;
  cell.sample_end = std::min(cell.sample_begin + layer_samples_, rect.sample_end);
  return cell;
}

std::uint64_t WorkPlan::pass_of(std::uint64_t cell) const {
  const Place place = place_of(cell);
  return first_pass_[place.rect] + std::uint64_t{place.layer} * rects_[place.rect].rows() +
         place.row;
}

WorkRect WorkPlan::pass_rect(std::uint64_t pass) const {
  const std::size_t index = rect_of(first_pass_, pass);
  const WorkRect& rect = rects_[index];
  const std::uint64_t within = pass - first_pass_[index];
  const auto layer = static_cast<std::uint32_t>(within / rect.rows());
  const std::uint32_t row = rect.row_begin + static_cast<std::uint32_t>(within % rect.rows());
  const std::uint32_t begin = rect.sample_begin + layer * layer_samples_;
  return {row, row + 1, begin, std::min(begin + layer_samples_, rect.sample_end)};
}

WorkPlan::Stride WorkPlan::pass_cells(std::uint64_t pass) const {
  const std::size_t index = rect_of(first_pass_, pass);
  const std::uint64_t rows = rects_[index].rows();
  const std::uint64_t within = pass - first_pass_[index];
  const std::uint64_t layer_first = first_cell_[index] + within / rows * rows * columns_;
  const std::uint64_t row = within % rows;
  const std::uint64_t band = row / band_;
  const std::uint64_t band_rows = std::min<std::uint64_t>(band_, rows - band * band_);
  return {layer_first + band * band_ * columns_ + row % band_, band_rows};
}

}  // namespace parray

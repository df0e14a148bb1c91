#include "common/schedule/work_plan.h"

#include <algorithm>
#include <stdexcept>

#include "common/schedule/row_order.h"

namespace parray {
namespace {

std::uint64_t divide_up(std::uint64_t a, std::uint64_t b) { return a / b + (a % b != 0 ? 1 : 0); }

/// Small enough that the threads of a rank end together, large enough that dealing cells out costs
/// nothing.
constexpr std::uint64_t least_cell_samples = 2048;
/// More cells would only cost memory.
constexpr std::uint64_t most_cells = 1U << 22;
/// Of a cell of a tile, or of one where some pixels have many more samples than others: about a
/// tenth of a second.
constexpr std::uint64_t most_cell_samples = 1U << 20;
/// Interleaved rows that are cut across together: a lease of this many cells samples as many rows
/// of the whole image, so that what it costs says how fast a rank is, and not where it was at work.
/// More would keep rows from being finished, and kept, for longer.
constexpr std::uint32_t interleaved_band = 16;

}  // namespace

SampleRange Cell::samples_of(std::uint32_t index) const {
  const SampleRange own{sample_begin, sample_end};
  return pass.empty() ? own : common_of(pass[index], own);
}

std::vector<SampleRange> Cell::sample_ranges() const {
  std::vector<SampleRange> ranges;
  ranges.reserve(pixels());
  for (std::uint32_t i = 0; i < pixels(); ++i) {
    ranges.push_back(samples_of(i));
  }
  return ranges;
}

std::uint64_t Cell::samples() const {
  if (pass.empty()) {
    return std::uint64_t{pixels()} * (sample_end - sample_begin);
  }
  std::uint64_t count = 0;
  for (std::uint32_t i = 0; i < pixels(); ++i) {
    count += samples_of(i).count();
  }
  return count;
}

bool operator==(const Cell& a, const Cell& b) {
  return a.position == b.position && a.x_begin == b.x_begin && a.x_end == b.x_end &&
         a.sample_begin == b.sample_begin && a.sample_end == b.sample_end &&
         std::ranges::equal(a.pass, b.pass);
}

WorkPlan::WorkPlan(const RenderSettings& settings, std::vector<WorkRect> pending,
                   std::uint32_t tile, std::vector<SampleRange> samples)
    : width_(settings.width),
      tile_(std::max(tile, 1U)),
      band_(tile_),
      rects_(std::move(pending)),
      samples_(std::move(samples)) {
  // The other policies deal out whole rows.
  if (tile_ == 1 && settings.schedule == SchedulePolicy::weighted &&
      settings.row_order != RowOrder::sequential) {
    band_ = interleaved_band;
  }
  if (!samples_.empty()) {
    if (samples_.size() != std::size_t{width_} * settings.height) {
      throw std::logic_error("a pass of another image");
    }
    row_at_ = make_row_order(settings.row_order, settings.height);
  }
  count_samples();
  if (samples_.empty()) {
    cut_evenly();
  } else {
    cut_ragged();
  }
  columns_ = divide_up(width_, cell_pixels_);
  first_cell_.push_back(0);
  first_pass_.push_back(0);
  for (std::size_t i = 0; i < rects_.size(); ++i) {
    const std::uint64_t rows = std::uint64_t{layers(i)} * rects_[i].rows();
    first_pass_.push_back(first_pass_.back() + rows);
    first_cell_.push_back(first_cell_.back() + rows * columns_);
  }
  cell_samples_ = static_cast<double>(cell_pixels_) * static_cast<double>(layer_samples_);
  if (!samples_.empty()) {
    const auto cells = static_cast<double>(std::max<std::uint64_t>(first_cell_.back(), 1));
    cell_samples_ = std::max(static_cast<double>(total_) / cells, 1.0);
  }
}

void WorkPlan::count_samples() {
  for (const WorkRect& rect : rects_) {
    if (samples_.empty()) {
      total_ += rect.units() * width_;
      most_ = std::max(most_, rect.samples());
      continue;
    }
    for (std::uint32_t position = rect.row_begin; position < rect.row_end; ++position) {
      for (const SampleRange& pixel : row_samples(position)) {
        const std::uint32_t count = common_of(pixel, rect.sample_range()).count();
        total_ += count;
        most_ = std::max(most_, count);
      }
    }
  }
}

/// Samples are cut like pixels.
void WorkPlan::cut_evenly() {
  const std::uint64_t grain = std::max(least_cell_samples, divide_up(total_, most_cells));
  cell_pixels_ = static_cast<std::uint32_t>(std::clamp<std::uint64_t>(grain / most_, 1, width_));
  layer_samples_ = static_cast<std::uint32_t>(std::min<std::uint64_t>(grain, most_));
  if (tile_ > 1) {
    cell_pixels_ = std::min(tile_, width_);
    // A tile's cells are longer, but not so long that a rank could not be told to stop.
    layer_samples_ = static_cast<std::uint32_t>(std::min<std::uint64_t>(
        most_, divide_up(std::max(most_cell_samples, grain), cell_pixels_)));
  }
}

/// By the mean, and all samples of a pixel together if possible: of ranges of samples that few
/// pixels have, most cells would be empty, and a record is as long for nothing.
void WorkPlan::cut_ragged() {
  std::uint64_t rows = 0;
  for (const WorkRect& rect : rects_) {
    rows += rect.rows();
  }
  const std::uint64_t grain = std::max(least_cell_samples, divide_up(total_, most_cells));
  const std::uint64_t mean = std::max<std::uint64_t>(total_ / std::max(rows * width_, 1UL), 1);
  cell_pixels_ = static_cast<std::uint32_t>(
      std::clamp<std::uint64_t>(std::min(grain / mean, most_cell_samples / most_), 1, width_));
  layer_samples_ = static_cast<std::uint32_t>(most_cell_samples);
  if (tile_ > 1) {
    cell_pixels_ = std::min(tile_, width_);
  }
}

std::span<const SampleRange> WorkPlan::row_samples(std::uint32_t position) const {
  return std::span(samples_).subspan(std::size_t{row_at_[position]} * width_, width_);
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
  if (!samples_.empty()) {
    cell.pass = row_samples(cell.position).subspan(cell.x_begin, cell.pixels());
  }
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

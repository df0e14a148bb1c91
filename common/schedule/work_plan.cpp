#include "common/schedule/work_plan.h"

#include <algorithm>
#include <stdexcept>

#include "common/base/divide_up.h"
#include "common/scene/settings.h"

namespace parray::schedule {
namespace {

/// Fewest samples of a full cell: low enough that the threads of a team end together, high enough
/// that leasing cells costs nothing.
constexpr std::uint64_t least_cell_samples = 2048;
/// Bound on the number of cells; more would only cost memory.
constexpr std::uint64_t most_cells = 1U << 22;
/// Bound on the samples of a cell of a tile, or of a cell in which some pixels have many more
/// samples than others: about a tenth of a second.
constexpr std::uint64_t most_cell_samples = 1U << 20;
/// Rows of a band in interleaved order. A lease of this many cells samples as many rows of the
/// whole image. So its cost shows the speed of a worker, and not the part of the image that it
/// traced.
constexpr std::uint32_t interleaved_band = 16;

}  // namespace

WorkPlan::WorkPlan(const RenderSettings& settings, Pass pass, std::uint32_t tile)
    : samples_(std::move(pass.samples)) {
  GridShape shape;
  shape.width = settings.width;
  shape.height = settings.height;
  shape.row_order = settings.row_order;
  shape.stages = std::move(pass.stages);
  if (tile > 1) {
    shape.band_rows = shape.piece_cells = tile;
  } else if (settings.schedule == SchedulePolicy::weighted &&
             settings.row_order != RowOrder::sequential) {
    shape.band_rows = interleaved_band;  // the other policies lease whole rows
  }
  const std::uint64_t pixels = std::uint64_t{settings.width} * settings.height;
  std::uint32_t most = 1;  // most samples of a pixel
  if (samples_.empty()) {
    for (const Stage& stage : shape.stages) {
      total_ += stage.count() * stage.lattice.pixels(shape.width, shape.height);
    }
    shape = evenly(std::move(shape), tile);
  } else {
    if (samples_.size() != pixels) {
      throw std::logic_error("the pass belongs to a picture of another size");
    }
    for (const SampleRange& pixel : samples_) {
      total_ += pixel.count();
      most = std::max(most, pixel.count());
    }
    shape = ragged(std::move(shape), tile, most);
  }
  grid_ = std::make_shared<const CellGrid>(std::move(shape));
  cell_samples_ = std::max(static_cast<double>(total_) / static_cast<double>(cells()), 1.0);
}

/// Cuts samples like pixels.
GridShape WorkPlan::evenly(GridShape shape, std::uint32_t tile) const {
  std::uint32_t most = 1;
  std::uint32_t widest = 1;
  for (const Stage& stage : shape.stages) {
    most = std::max(most, stage.count());
    widest = std::max(widest, stage.lattice.across(shape.width));
  }
  const std::uint64_t grain = std::max(least_cell_samples, divide_up(total_, most_cells));
  shape.cell_pixels =
      static_cast<std::uint32_t>(std::clamp<std::uint64_t>(grain / most, 1, widest));
  shape.layer_samples = static_cast<std::uint32_t>(std::min<std::uint64_t>(grain, most));
  if (tile > 1) {
    shape.cell_pixels = std::min(tile, widest);
    // A tile's cells are longer, but short enough that a worker can stop in time.
    shape.layer_samples = static_cast<std::uint32_t>(std::min<std::uint64_t>(
        most, divide_up(std::max(most_cell_samples, grain), shape.cell_pixels)));
  }
  return shape;
}

/// Sizes cells by the mean number of samples, and keeps all samples of a pixel together if
/// possible. In layers that few pixels have, most cells would be empty, and an empty record is as
/// long as a full one.
GridShape WorkPlan::ragged(GridShape shape, std::uint32_t tile, std::uint32_t most) const {
  const std::uint64_t pixels = samples_.size();
  const std::uint64_t grain = std::max(least_cell_samples, divide_up(total_, most_cells));
  const std::uint64_t mean = std::max<std::uint64_t>(total_ / pixels, 1);
  shape.cell_pixels = static_cast<std::uint32_t>(
      std::clamp<std::uint64_t>(std::min(grain / mean, most_cell_samples / most), 1, shape.width));
  shape.layer_samples = static_cast<std::uint32_t>(most_cell_samples);
  if (tile > 1) shape.cell_pixels = std::min(tile, shape.width);
  return shape;
}

CellBatch WorkPlan::batch(const CellRange& range) const {
  CellBatch batch{grid_, range, {}};
  if (samples_.empty()) return batch;
  const GridShape& shape = grid_->shape();
  batch.samples.resize(range.count() * shape.cell_pixels);
  auto target = batch.samples.begin();
  for (std::uint64_t index = range.begin; index < range.end; ++index) {
    const Cell cell = grid_->cell(index);
    const std::size_t first = std::size_t{cell.y} * shape.width + cell.x_begin;
    for (std::uint32_t i = 0; i < cell.pixels(); ++i) {
      target[i] = common_of(samples_[first + i], cell.samples);
    }
    target += shape.cell_pixels;
  }
  return batch;
}

}  // namespace parray::schedule

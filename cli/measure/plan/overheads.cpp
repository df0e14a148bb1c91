#include "cli/measure/plan/overheads.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>

#include "cli/output/picture/image_file.h"
#include "common/adaptive/error_estimate.h"
#include "common/base/files.h"
#include "common/image/image.h"
#include "common/scene/settings.h"
#include "common/schedule/traced_cells.h"
#include "common/schedule/work_plan.h"
#include "coordinator/leases/result_collector.h"

namespace parray::plan {
namespace {

namespace fs = std::filesystem;

/// Returns a worker's result for the whole picture, with invented counts.
TracedCells as_cells(const Framebuffer& traced, const CellBatch& batch) {
  const std::size_t size = record_bytes(batch.grid->shape().cell_pixels);
  TracedCells cells;
  cells.range = batch.range;
  cells.samples = batch.sample_count();
  cells.records.resize(batch.range.count() * size);
  for (std::uint64_t index = 0; index < batch.range.count(); ++index) {
    const Cell cell = batch.grid->cell(index);
    const PixelSums* const sums =
        traced.pixels().data() + std::size_t{cell.y} * traced.width() + cell.x_begin;
    std::memcpy(cells.records.data() + index * size + sizeof(CellHeader), sums,
                cell.pixels() * sizeof(PixelSums));
  }
  return cells;
}

}  // namespace

void forget_memory() {
  constexpr int large = 128 * 1024;  // glibc's default; setting it stops glibc from raising it
  mallopt(M_MMAP_THRESHOLD, large);  // NOLINT(concurrency-mt-unsafe): before other threads allocate
}

Collecting effort_of_collecting(const Framebuffer& traced) {
  RenderSettings settings;
  settings.width = traced.width();
  settings.height = traced.height();
  const auto most = *std::max_element(traced.samples().begin(), traced.samples().end());
  Pass pass{{{0, most}}, {}};
  for (const std::uint32_t count : traced.samples()) pass.samples.push_back({0, count});
  const auto plan = std::make_shared<const WorkPlan>(settings, std::move(pass));
  const CellBatch batch = plan->batch({0, plan->cells()});
  const TracedCells cells = as_cells(traced, batch);
  Framebuffer received(traced.width(), traced.height());
  if (const std::string fault = fault_of(cells, batch, settings.max_depth); !fault.empty()) {
    throw std::logic_error("collecting " + fault);
  }
  const auto collect = [&] {
    ResultCollector collector(plan, received);
    const Effort began = effort_now();
    static_cast<void>(fault_of(cells, batch, settings.max_depth));
    collector.take(0, cells);
    return effort_now() - began;
  };
  const Effort first = collect();
  const Effort again = collect();
  const Effort touching = first - again;
  return {again, {std::max(touching.wall, 0.0), std::max(touching.cpu, 0.0)}};
}

Effort measure_overheads(const DirectRender& picture, const fs::path& extension) {
  const Effort began = effort_now();
  const Image image = resolve_image(picture.framebuffer, picture.largest_radiance);
  const ErrorEstimate error = estimate_error(picture.state());
  for (int side = 0; side < 2; ++side) {  // coordinator and client each compute the hash
    image_sha256(image);
  }
  const OwnedPath file(fs::temp_directory_path() /
                       ("parray-plan-" + std::to_string(getpid()) + extension.string()));
  write_image(file.path(), image, {});
  return effort_now() - began;
}

}  // namespace parray::plan

#include "cli/measure/plan/effort.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <ctime>
#include <memory>
#include <stdexcept>
#include <string>

#include "cli/farm/direct_render.h"
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

static double seconds_of(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

Effort effort_now() { return {seconds_of(CLOCK_MONOTONIC), seconds_of(CLOCK_PROCESS_CPUTIME_ID)}; }

static constexpr double least_doubt = 0.05;
/// Smallest share of a pass's time that belongs to its samples.
static constexpr double least_share = 0.3;

PassCost fit_pass_cost(std::span<const TracedPass> passes) {
  // Weighted by 1 / time^2: minimises the sum of (pass / t + sample * n / t - 1)^2.
  double u = 0;
  double un = 0;
  double unn = 0;
  double right = 0;
  double right_n = 0;
  Effort all;
  double samples = 0;
  double shortest = INFINITY;
  for (const TracedPass& one : passes) {
    const double t = one.effort.cpu;
    u += 1 / (t * t);
    un += one.samples / (t * t);
    unn += one.samples * one.samples / (t * t);
    right += 1 / t;
    right_n += one.samples / t;
    all = all + one.effort;
    samples += one.samples;
    shortest = std::min(shortest, t);
  }
  const double determinant = u * unn - un * un;
  const double exact = determinant > 0 ? (right * unn - right_n * un) / determinant : 0;
  const double pass = std::clamp(exact, 0.0, (1 - least_share) * shortest);
  const double slower = all.wall / all.cpu;
  const auto count = static_cast<double>(passes.size());
  PassCost times;
  times.pass = {slower * pass, pass};
  times.sample = 1 / samples * (all - count * times.pass);
  double squares = 0;
  for (const TracedPass& one : passes) {
    const double expected = times.pass.wall + one.samples * times.sample.wall;
    squares += std::pow(one.effort.wall / expected - 1, 2);
  }
  times.doubt = std::max(least_doubt, std::sqrt(squares / (count * (count - 1))));
  return times;
}

Effort sample_effort(std::span<const TracedPass> passes, Effort pass) {
  Effort all;
  double samples = 0;
  for (const TracedPass& one : passes) {
    all = all + one.effort;
    samples += one.samples;
  }
  const auto count = static_cast<double>(passes.size());
  const Effort rest = all - count * pass;
  return 1 / samples *
         Effort{std::max(rest.wall, least_share * all.wall),
                std::max(rest.cpu, least_share * all.cpu)};
}

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

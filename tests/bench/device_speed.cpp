#include "tests/bench/device_speed.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <numeric>

#include "common/scene/requirements.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"
#include "tests/bench/bench.h"
#include "tests/bench/bench_scenes.h"
#include "tests/bench/device_work.h"

namespace parray::bench {
namespace {

/// Scenes with more spheres are not traced by linear search.
constexpr std::uint32_t most_linear = 48;
constexpr std::uint32_t first_block = 128;

/// Everything that one row of the table needs.
struct Row {
  const SpeedOptions& options;
  const test::CudaDevice& device;
  ModulesByCap& modules;
  Verdict& verdict;
  RenderSettings settings;
  std::uint32_t spheres;

  [[nodiscard]] std::string name() const {
    return std::to_string(spheres) + " spheres (" + std::string(name_of(settings.precision)) +
           ", " + std::string(name_of(settings.accelerator)) + ")";
  }
};

/// One cell of the table: a limit of registers and a size of blocks.
struct Cell {
  int cap;
  std::uint32_t block;
  test::CudaKernel kernel;
  std::vector<double> seconds;
};

double million(double value) { return value / 1e6; }

/// Returns a plan of launches that take about launch_seconds.
ItemPlan plan_of(const Row& row, const DeviceScene& scene, const DevicePicture& picture) {
  constexpr double most_blocks = 4;
  ItemPlan plan;
  const DeviceWork work(row.device, scene, picture, items_of(row.settings, plan));
  const test::CudaKernel kernel = row.modules.with(row.options.caps.front()).kernel(work.kernel());
  work.trace(kernel, first_block);
  const double ratio = row.options.launch_seconds / work.trace(kernel, first_block);
  if (ratio > 1) {
    plan.blocks = static_cast<std::uint32_t>(std::min(most_blocks, std::ceil(ratio)));
  } else if (ratio < 0.4) {
    plan.every = static_cast<std::uint32_t>(std::min(16.0, std::round(1 / ratio)));
  }
  return plan;
}

std::vector<Cell> cells_of(const Row& row, const std::string& kernel) {
  std::vector<Cell> cells;
  for (const int cap : row.options.caps) {
    for (const std::uint32_t block : row.options.blocks) {
      cells.push_back({cap, block, row.modules.with(cap).kernel(kernel), {}});
    }
  }
  return cells;
}

/// Launches the picture once in each cell before it is measured, and compares some results with
/// the CPU's.
void check_cells(const Row& row, DeviceWork& work, const std::vector<Cell>& cells,
                 const PathTracer& cpu) {
  std::vector<DeviceSums> first;
  for (const Cell& cell : cells) {
    work.spoil_some_results();
    work.trace(cell.kernel, cell.block);
    std::vector<DeviceSums> found = work.some_results();
    const bool is_first = first.empty();
    if (is_first) first = found;
    if (!is_first &&
        std::memcmp(found.data(), first.data(), found.size() * sizeof(DeviceSums)) == 0) {
      continue;
    }
    const std::string text = first_difference(work.some_items(), found, cpu);
    if (!text.empty()) {
      row.verdict.wrong("picture of " + row.name() + " with the limit of registers " +
                        name_of_cap(cell.cap) + " and blocks of " + std::to_string(cell.block) +
                        ", " + text);
    }
  }
}

/// Cells take turns, so that a device whose clock drifts drifts for all.
void measure_cells(const Row& row, const DeviceWork& work, std::vector<Cell>& cells) {
  for (std::size_t round = 0; round < row.options.rounds; ++round) {
    for (Cell& cell : cells) cell.seconds.push_back(work.trace(cell.kernel, cell.block));
  }
}

Json figures_of(const Row& row, const DeviceWork& work, const Cell& cell, double rays) {
  const double rate = static_cast<double>(work.samples()) / median(cell.seconds);
  const int at_once = row.device.blocks_at_once(cell.kernel, static_cast<int>(cell.block));
  return {{"most_registers", name_of_cap(cell.cap)},
          {"block", cell.block},
          {"registers", cell.kernel.registers},
          {"local_bytes", cell.kernel.local_bytes},
          {"warps_at_once", at_once * static_cast<int>(cell.block) / 32},
          {"million_samples_per_s", million(rate)},
          {"million_rays_per_s", million(rate * rays)},
          {"seconds", cell.seconds}};
}

const Json& best_of(const Json& cells) {
  return *std::max_element(cells.begin(), cells.end(), [](const Json& a, const Json& b) {
    return a["million_samples_per_s"].get<double>() < b["million_samples_per_s"].get<double>();
  });
}

/// Adds the figures of all cells of a row to `figures`.
void measure_row(const Row& row, const Scene& scene, const PathTracer& cpu, Json& figures) {
  const DeviceScene tables(scene, row.settings.precision, row.settings.accelerator, 4);
  if (!tables.fits()) {
    figures["left_out"] = "the tree is deeper than a kernel's stack";
    return;
  }
  const DevicePicture picture(tables, scene.camera, row.settings);
  DeviceWork work(row.device, tables, picture,
                  items_of(row.settings, plan_of(row, tables, picture)));
  std::vector<Cell> cells = cells_of(row, work.kernel());
  check_cells(row, work, cells, cpu);
  measure_cells(row, work, cells);
  const std::vector<DeviceSums> results = work.all_results();
  std::uint64_t rays = 0;
  std::uint64_t handed_back = 0;
  for (const DeviceSums& sums : results) {
    rays += sums.rays;
    handed_back += sums.handed_back;
  }
  const double rays_of_a_sample = static_cast<double>(rays) / static_cast<double>(work.samples());
  figures.update({{"kernel", work.kernel()},
                  {"scene_bytes", tables.bytes().size()},
                  {"items", work.item_count()},
                  {"samples", work.samples()},
                  {"rays_per_sample", rays_of_a_sample},
                  {"items_handed_back", handed_back},
                  {"cells", Json::array()}});
  for (const Cell& cell : cells) {
    figures["cells"].push_back(figures_of(row, work, cell, rays_of_a_sample));
  }
  figures["best"] = best_of(figures["cells"]);
}

void print_row(const Json& figures, double cpu) {
  const Json& best = figures["best"];
  const double rate = best["million_samples_per_s"];
  std::printf("%8s  %-5s  %-6s  %9.1f  %-4s  %3d  %9.2f  %7.1f\n",
              figures["spheres"].dump().c_str(), figures["precision"].get<std::string>().c_str(),
              figures["search"].get<std::string>().c_str(), rate,
              best["most_registers"].get<std::string>().c_str(), best["block"].get<int>(), cpu,
              rate / cpu);
  static_cast<void>(std::fflush(stdout));
}

void print_heads(const SpeedOptions& options) {
  std::printf(
      "\nM samples/s, best of limits of registers (%zu) and sizes of blocks (%zu), and of "
      "one core (%s)\n",
      options.caps.size(), options.blocks.size(), processor().c_str());
  std::puts(" spheres  type   search     device  regs  block    one core   ratio");
}

RenderSettings settings_of(const SpeedOptions& options, Precision precision) {
  RenderSettings settings = small_picture();
  settings.width = options.width;
  settings.height = options.height;
  settings.precision = precision;
  return settings;
}

std::vector<AcceleratorKind> searches_at(std::uint32_t spheres) {
  if (spheres > most_linear) return {AcceleratorKind::bvh};
  return {AcceleratorKind::linear, AcceleratorKind::bvh};
}

/// Adds the rows of one scene and precision to `rows`.
void measure_scene(Row row, const Scene& scene, Json& rows) {
  const RenderSettings on_cpu = resolve_settings(requirements_of(scene), row.settings).settings;
  const auto cpu = make_path_tracer(scene, on_cpu);
  const std::vector<double> rates =
      cpu_rates(*cpu, on_cpu, row.options.cpu_rounds, row.options.cpu_seconds);
  const double cpu_rate = million(median(rates));
  for (const AcceleratorKind search : searches_at(row.spheres)) {
    row.settings.accelerator = search;
    Json figures = {{"spheres", row.spheres},    {"precision", name_of(row.settings.precision)},
                    {"search", name_of(search)}, {"cpu_search", name_of(on_cpu.accelerator)},
                    {"cpu_isa", cpu->isa()},     {"cpu_million_samples_per_s", cpu_rate}};
    measure_row(row, scene, *cpu, figures);
    if (figures.contains("best")) {
      figures["ratio"] = figures["best"]["million_samples_per_s"].get<double>() / cpu_rate;
      print_row(figures, cpu_rate);
    }
    rows.push_back(std::move(figures));
  }
}

}  // namespace

std::string name_of_cap(int cap) { return cap == 0 ? "none" : std::to_string(cap); }

const test::CudaModule& ModulesByCap::with(int cap) {
  auto& module = modules_[cap];
  if (module == nullptr) {
    const TimeLimit clock(0);
    module = std::make_unique<test::CudaModule>(device_.driver(), ptx_, cap);
    seconds_[name_of_cap(cap)] = clock.used();
  }
  return *module;
}

void measure_speed(const SpeedOptions& options, const TimeLimit& time,
                   const test::CudaDevice& device, ModulesByCap& modules, Verdict& verdict,
                   const std::function<void(const Json&)>& keep) {
  for (const int cap : options.caps) modules.with(cap);
  Json figures = {{"cpu", processor()},
                  {"picture", {{"width", options.width}, {"height", options.height}}},
                  {"compile_seconds", modules.compile_seconds()},
                  {"rows", Json::array()},
                  {"left_out", Json::array()}};
  print_heads(options);
  double longest = 0;
  for (const std::uint32_t spheres : options.spheres) {
    const Scene scene = scene_of_size(spheres, options.generated);
    for (const Precision precision : options.precisions) {
      const double begin = time.used();
      if (time.allows(longest)) {
        measure_scene({options, device, modules, verdict, settings_of(options, precision), spheres},
                      scene, figures["rows"]);
      } else {
        const std::string name = std::to_string(spheres) + " " + std::string(name_of(precision));
        std::printf("left out, because the time is over: %s\n", name.c_str());
        figures["left_out"].push_back(name);
      }
      longest = std::max(longest, time.used() - begin);
      keep(figures);
    }
  }
}

}  // namespace parray::bench

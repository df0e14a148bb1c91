// Jobs of parray-mpi in virtual time, for ranks that are not at hand: one line of CSV for each
// number of ranks, and where the time of their cores went.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numeric>
#include <random>

#include "common/base/error.h"
#include "common/scene/settings.h"
#include "tests/experiments/simulation/seed_job.h"
#include "tests/experiments/simulation/sim_job.h"
#include "tests/support/rooms.h"

namespace {

using namespace parray;
using namespace parray::simulation;

struct Arguments {
  std::string rows;
  std::vector<std::uint32_t> ranks = {1, 4, 16, 64, 96, 256, 512, 1024, 4096};
  std::uint32_t threads = 2;
  std::uint32_t samples_per_pixel = 500;
  std::string schedule = "weighted";
  std::string row_order = "interleaved";
  std::string link = known_links().front().name;
  double cell_noise = 0.3;
  double slowness = 1;
  double speed_spread = 0;
  double slow_rank = 1;
  std::vector<double> stall;
  std::uint32_t failures = 0;
  std::uint64_t seed = 1;
  std::uint32_t ledger_ranks = Ledgers::group_ranks;
  bool seed_scheme = false;
  bool hot_band = false;
  std::uint32_t enlarge = 1;
  bool start = true;
  std::string per_rank;
  std::string label;
  HostCosts host;
  StartCosts start_costs;
  LinkCosts link_costs;
};

/// A row's cost on one thread, and the picture's width, from a report with mpi.row_seconds.
struct Measured {
  std::uint32_t width = 0;
  std::uint32_t samples_per_pixel = 0;
  double build = 0;
  std::vector<double> row_seconds;
};

Measured read_report(const std::string& path) {
  std::ifstream file(path);
  const nlohmann::json report = nlohmann::json::parse(file, nullptr, false);
  if (report.is_discarded() || !report.contains("/mpi/row_seconds"_json_pointer)) {
    throw InputError(path + ": no mpi.row_seconds; make it by parray-mpi --row-seconds --report");
  }
  Measured measured;
  measured.width = report.at("width");
  measured.samples_per_pixel = report.at("samples_per_pixel");
  measured.build = report.at("seconds").at("build");
  measured.row_seconds = report.at("mpi").at("row_seconds").get<std::vector<double>>();
  return measured;
}

/// As many times as wide and high; a pixel costs what it did.
Measured enlarged(Measured measured, std::uint32_t times) {
  measured.width *= times;
  std::vector<double> rows;
  for (const double row : measured.row_seconds) rows.insert(rows.end(), times, row * times);
  measured.row_seconds = std::move(rows);
  return measured;
}

/// A tenth of the rows, in the middle, 20 times as dear as the others; the same total.
void make_hot_band(std::vector<double>& rows) {
  const double total = std::accumulate(rows.begin(), rows.end(), 0.0);
  const std::size_t height = rows.size();
  for (std::size_t row = 0; row < height; ++row) {
    rows[row] = row >= height * 9 / 20 && row < height * 11 / 20 ? 20 : 1;
  }
  const double sum = std::accumulate(rows.begin(), rows.end(), 0.0);
  for (double& row : rows) row *= total / sum;
}

std::vector<double> speeds_of(const Arguments& a, std::uint32_t ranks) {
  std::vector<double> speeds(ranks, 1.0);
  std::mt19937_64 engine(a.seed);
  std::normal_distribution<double> normal;
  for (double& speed : speeds) speed = std::exp(a.speed_spread * normal(engine));
  speeds.back() /= a.slow_rank;
  return speeds;
}

JobOptions job_options(const Arguments& a, const Measured& measured, std::uint32_t ranks) {
  JobOptions job;
  job.settings.width = measured.width;
  job.settings.height = static_cast<std::uint32_t>(measured.row_seconds.size());
  job.settings.samples_per_pixel = a.samples_per_pixel;
  job.settings.schedule = schedule_from(a.schedule);
  job.settings.row_order = row_order_from(a.row_order);
  job.row_seconds = measured.row_seconds;
  for (double& row : job.row_seconds) {
    row *= a.slowness * a.samples_per_pixel / measured.samples_per_pixel;
  }
  if (a.hot_band) make_hot_band(job.row_seconds);
  job.cell_noise = a.cell_noise;
  job.seed = a.seed;
  job.ranks = ranks;
  job.threads = a.threads;
  job.ledger_ranks = a.ledger_ranks;
  job.speeds = speeds_of(a, ranks);
  job.link = a.link_costs;
  job.host = a.host;
  if (a.start) {
    job.start = a.start_costs;
    job.start.build = measured.build;
  }
  const double ideal =
      std::accumulate(job.row_seconds.begin(), job.row_seconds.end(), 0.0) / (ranks * a.threads);
  const double ready = job.start.mpi + job.start.build;
  if (a.stall.size() == 2) {  // of the last rank
    const Time begin = to_time(ready + a.stall[0] * ideal);
    job.stops.push_back({ranks - 1, begin, begin + to_time(a.stall[1] * ideal)});
  }
  for (std::uint32_t i = 0; i < a.failures && i + 1 < ranks; ++i) {
    const double when = ideal * (i + 1) / (a.failures + 1);
    job.stops.push_back({ranks - 1 - i, to_time(ready + when), never});
  }
  return job;
}

void print_header() {
  std::puts(
      "label,ranks,threads,cores,schedule,row_order,link,seconds,start_seconds,work_seconds,"
      "speedup,"
      "efficiency,efficiency_without_start,loss_start,loss_leases,loss_coordinator,loss_within_"
      "rank,"
      "loss_imbalance,loss_tail,loss_ending,loss_faults,leases,copies,duplicate_cells,"
      "floor_cells,floor_rank_0,floor_link");
}

/// The parts are shares of all cores' time; with `efficiency` they add up to 1.
void print_line(const Arguments& a, const SimJob& job, std::uint32_t ranks) {
  const Spent spent = job.spent_together();
  const double all = job.cores() * job.seconds();
  if (std::abs(spent.sum() / all - 1) > 1e-6 ||
      std::abs(spent.useful / job.work_seconds() - 1) > 1e-6) {
    throw RunError("the account of the cores' time does not add up");
  }
  std::uint64_t leases = 0;
  for (std::uint32_t rank = 0; rank < ranks; ++rank) leases += job.tally(rank).leases;
  const auto& tally = job.totals();
  std::printf("%s,%u,%u,%u,%s,%s,%s,%.6g,%.6g,%.6g,%.5g,%.4f,%.4f,", a.label.c_str(), ranks,
              a.threads, ranks * a.threads, a.schedule.c_str(), a.row_order.c_str(),
              a.link_costs.name.c_str(), job.seconds(), job.start_seconds(), job.work_seconds(),
              job.work_seconds() / job.seconds(), job.efficiency(), job.running_efficiency());
  std::printf("%.5f,%.5f,%.5f,%.5f,%.5f,%.5f,%.5f,%.5f,%llu,%llu,%llu,", spent.start / all,
              spent.leases / all, spent.coordinator / all, spent.inner / all, spent.imbalance / all,
              spent.tail / all, spent.ending / all, spent.faults / all,
              static_cast<unsigned long long>(leases),
              static_cast<unsigned long long>(tally.copies),
              static_cast<unsigned long long>(tally.duplicates));
  const Floors floors = job.floors();
  std::printf("%.6g,%.6g,%.6g\n", floors.cells, floors.rank_0, floors.link);
}

void write_ranks(const std::string& path, const std::vector<double>& normalized) {
  std::ofstream file(path);
  file << "rank,normalized_seconds\n";
  for (std::size_t rank = 0; rank < normalized.size(); ++rank) {
    file << rank << ',' << normalized[rank] << '\n';
  }
  if (!file.flush()) throw RunError("writing " + path + ": failed");
}

/// The seed program's MPI (static) or MPI-LB (guided).
std::vector<double> simulate_seed(const Arguments& a, const JobOptions& job) {
  const SeedJob seed = seed_job(job, schedule_from(a.schedule));
  const double seconds = seed.seconds + job.start.mpi;
  const double efficiency = seed.work / (job.ranks * job.threads * seed.seconds);
  std::printf("%s,%u,%u,%u,%s,sequential,%s,%.6g,%.6g,%.6g,%.5g,%.4f,%.4f,,,,,,,,,%llu,0,0,,,\n",
              a.label.c_str(), job.ranks, a.threads, job.ranks * a.threads, a.schedule.c_str(),
              a.link_costs.name.c_str(), seconds, job.start.mpi, seed.work, seed.work / seconds,
              efficiency * seed.seconds / seconds, efficiency,
              static_cast<unsigned long long>(seed.leases));
  return seed.normalized;
}

std::vector<double> simulate_parray(const Arguments& a, const JobOptions& options) {
  SimJob job(options);
  if (!job.run()) {
    throw RunError("the job of " + std::to_string(options.ranks) + " ranks does not end");
  }
  print_line(a, job, options.ranks);
  std::vector<double> normalized;
  for (std::uint32_t rank = 0; rank < options.ranks; ++rank) {
    normalized.push_back(job.normalized_seconds(rank));
  }
  return normalized;
}

void simulate(const Arguments& a) {
  const Measured measured = enlarged(read_report(a.rows), a.enlarge);
  print_header();
  for (const std::uint32_t ranks : a.ranks) {
    const JobOptions job = job_options(a, measured, ranks);
    const auto normalized = a.seed_scheme ? simulate_seed(a, job) : simulate_parray(a, job);
    std::fflush(stdout);
    if (!a.per_rank.empty()) write_ranks(a.per_rank, normalized);
  }
}

/// Figures given on the command line take the place of the link's.
void add_costs(CLI::App& app, Arguments& a) {
  const auto add = [&app](const char* name, double& target, const char* what) {
    app.add_option(name, target, what)->check(CLI::NonNegativeNumber)->group("Costs, in seconds");
  };
  add("--atomic", a.link_costs.atomic, "A fetch_add, load or store on the window");
  add("--atomic-service", a.link_costs.atomic_service, "Of that, what cannot be done at once");
  add("--put", a.link_costs.put, "A put of no bytes");
  add("--bandwidth", a.link_costs.bytes_per_second, "Bytes a second of rank 0's link");
  add("--hand-over", a.host.hand_over, "From one slice to the next in a rank");
  add("--collect-entry", a.host.collect_entry, "Rank 0: taking in a result");
  add("--collect-cell", a.host.collect_cell, "Rank 0: checking and merging a cell");
  add("--mpi-start", a.start_costs.mpi, "mpirun and MPI_Init");
  add("--mpi-start-per-doubling", a.start_costs.mpi_per_doubling, "For twice the ranks");
  add("--scene-bytes", a.start_costs.scene_bytes, "Broadcast at the start");
}

int run(int argc, char** argv) {
  CLI::App app("Jobs of parray-mpi in virtual time");
  Arguments a;
  std::string link;
  app.add_option("--rows", a.rows, "Report of parray-mpi --row-seconds")->required();
  app.add_option("--ranks", a.ranks, "Numbers of ranks")
      ->delimiter(',')
      ->check(CLI::Range(1, 65536));
  app.add_option("--threads", a.threads, "Of each rank")->check(CLI::Range(1, 4096));
  app.add_option("--spp", a.samples_per_pixel, "Samples of each pixel")
      ->check(CLI::Range(1, 65536));
  app.add_option("--enlarge", a.enlarge, "So many times as wide and high a picture")
      ->check(CLI::Range(1, 16));
  app.add_option("--ledger-ranks", a.ledger_ranks, "Ranks that share a ledger")
      ->check(CLI::Range(1, 65536));
  app.add_option("--schedule", a.schedule, "static, guided, factoring or weighted");
  app.add_option("--row-order", a.row_order, "sequential or interleaved");
  app.add_option("--link", a.link, "Rank 0's link: a known one");
  app.add_option("--cell-noise", a.cell_noise, "Spread of cells of one row (log-normal)");
  app.add_option("--slowness", a.slowness, "Tracing takes so many times as long");
  app.add_option("--speed-spread", a.speed_spread, "Spread of the ranks' speeds (log-normal)");
  app.add_option("--slow-rank", a.slow_rank, "The last rank is so many times slower");
  app.add_option("--stall", a.stall,
                 "BEGIN LENGTH: the last rank stands still; the job's ideal is 1")
      ->expected(2);
  app.add_option("--failures", a.failures, "So many ranks die on the way");
  app.add_option("--seed", a.seed, "Of speeds and cells");
  app.add_flag(
      "--seed-scheme", a.seed_scheme,
      "As the seed program: a thread takes whole rows, and with guided leases one rank does "
      "nothing but hand them out; nobody repeats anything");
  app.add_flag("--hot-band", a.hot_band, "A tenth of the rows is 20 times as dear");
  app.add_flag("!--no-start", a.start, "Leave the start-up out");
  app.add_option("--per-rank", a.per_rank, "Write each rank's normalised time there");
  app.add_option("--label", a.label, "First column of the output");
  for (int i = 1; i + 1 < argc; ++i) {  // before its single figures
    if (std::string_view(argv[i]) == "--link") a.link = argv[i + 1];
  }
  a.link_costs = link_from(a.link);
  add_costs(app, a);
  CLI11_PARSE(app, argc, argv);
  simulate(a);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const InputError& error) {
    std::cerr << "simulate_mpi: " << error.what() << "\n";
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "simulate_mpi: " << error.what() << "\n";
    return 1;
  }
}

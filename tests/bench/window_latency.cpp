// What leases over a window cost on the links at hand, and by messages; and what a rank does
// besides tracing. Its figures are what tests/experiments/simulate takes.
#include <mpi.h>
#include <sys/prctl.h>

#include <cstdio>
#include <cstring>
#include <functional>
#include <numeric>
#include <thread>
#include <vector>

#include "cli/mpi/mpi_world.h"
#include "common/scene/settings.h"
#include "coordinator/leases/window_collector.h"
#include "proto/mpi_window.h"
#include "tests/bench/bench.h"
#include "tests/support/rooms.h"
#include "worker/task_thread.h"
#include "worker/window_source.h"

namespace {

using namespace parray;

/// The picture of the report.
RenderSettings settings_of_report(std::uint32_t samples_per_pixel = 500) {
  RenderSettings settings;
  settings.samples_per_pixel = samples_per_pixel;
  settings.precision = Precision::f64;
  settings.row_order = RowOrder::interleaved;
  return settings;
}

/// A picture whose one pass has begun, and the leases of it.
struct ReportJob {
  explicit ReportJob(std::uint32_t samples_per_pixel = 500)
      : picture(settings_of_report(samples_per_pixel), SceneFacts(Scene())) {
    picture.begin_pass();
    pass = {picture.plan(), CellList(picture.collector().missing())};
  }
  [[nodiscard]] const WorkPlan& plan() const { return *pass.plan; }

  JobPicture picture;
  RankPass pass;
  RankJob job{settings_of_report(), "", nullptr};
};

/// Median seconds of one operation.
double seconds_of(std::size_t repeats, const std::function<void()>& operation) {
  const SteadyClock clock;
  std::vector<double> seconds;
  for (std::size_t i = 0; i < repeats; ++i) {
    const Time begin = clock.now();
    operation();
    seconds.push_back(to_seconds(clock.now() - begin));
  }
  return bench::median(std::move(seconds));
}

void print(const char* what, double seconds) {
  std::printf("%-52s %10.3f us\n", what, 1e6 * seconds);
}

/// Rank 0 while another rank measures: looks after the window as often as parray-mpi's does.
void serve(const MpiWorld& world, const std::function<void()>& poll) {
  prctl(PR_SET_TIMERSLACK, 1000);  // as parray-mpi does: otherwise 50 us of sleep take 110
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibarrier(world.comm(), &request);
  for (int done = 0; done == 0;) {
    poll();
    MPI_Test(&request, &done, MPI_STATUS_IGNORE);
    std::this_thread::sleep_for(std::chrono::microseconds(50));
  }
}

void measure_window(Window& window, std::size_t data) {
  constexpr std::size_t repeats = 2000;
  print("window: fetch_add", seconds_of(repeats, [&] { window.fetch_add(0, 1); }));
  print("window: load", seconds_of(repeats, [&] { window.load(0); }));
  print("window: store", seconds_of(repeats, [&] { window.store(1, 1); }));
  for (const std::size_t bytes : {8UL, 1024UL, 65536UL, 1UL << 20, 1UL << 24}) {
    const std::vector<std::byte> records(bytes);
    const double seconds =
        seconds_of(bytes > 65536 ? 50 : repeats / 4, [&] { window.put(data, records); });
    std::printf("window: put of %9zu bytes %35.3f us  %8.2f GB/s\n", bytes, 1e6 * seconds,
                1e-9 * static_cast<double>(bytes) / seconds);
  }
}

/// With so many ranks a lease is a cell, and there are enough of them.
WindowOptions one_cell_leases(std::uint32_t rank) { return {.rank = rank, .all_threads = 1000000}; }

/// What a rank asks for and hands in.
void measure_leases(WindowSource& source, const char* by, const WorkPlan& plan) {
  const std::vector<std::byte> records(10 * record_bytes(plan.grid()->shape().cell_pixels));
  const std::string name = by;
  print((name + ": take of a lease").c_str(),
        seconds_of(1000, [&] { source.take_part(1e6, false); }));
  std::uint64_t cell = 0;
  print((name + ": put of 10 cells, 2000 samples each").c_str(), seconds_of(1000, [&] {
          source.put({cell, cell + 10}, records);
          cell += 10;
        }));
}

void measure_hand_over() {
  TaskThread<int, int> thread([](const int& task, const std::atomic<bool>&) { return task; },
                              [] {});
  print("hand-over to a team's thread and back", seconds_of(2000, [&] {
          thread.start(1);
          while (!thread.take()) thread.wait_until_done(milliseconds(1));
        }));
}

/// A whole picture's results, by rank 0: processor time a cell.
void measure_collector(std::uint32_t samples_per_pixel, std::uint64_t cells_an_entry) {
  ReportJob report(samples_per_pixel);
  const WorkPlan& plan = report.plan();
  const WindowLayout layout(*plan.grid(), 1);
  std::vector<std::uint64_t> words((layout.bytes() + 7) / 8);
  const auto memory = std::as_writable_bytes(std::span(words));
  LocalWindow window(memory);
  WindowSource source(report.job, report.pass, layout, window, {});
  const SteadyClock clock;
  WindowCollector::Totals totals;
  report.picture.touch(0, 1);  // pages that the kernel has to find cost more than what is measured
  RankJudge judge(report.picture, rank_voices({"one host"}), {});
  WindowCollector collector(report.picture, judge, layout, window, memory, clock.now(), totals, {});
  double digests = 0;
  for (std::uint64_t begin = 0; begin < plan.cells(); begin += cells_an_entry) {
    const CellRange range{begin, std::min(begin + cells_an_entry, plan.cells())};
    const auto records =
        memory.subspan(layout.record_offset(range.begin), range.count() * layout.record_bytes());
    const double before = bench::cpu_seconds();
    const std::uint64_t digest = range_digest(cell_digests(records, layout.record_bytes()));
    digests += bench::cpu_seconds() - before;
    source.log(range, digest);
  }
  const auto cells = static_cast<double>(plan.cells());
  const double begin = bench::cpu_seconds();
  while (!collector.done()) collector.collect(clock.now(), 4096);
  const double seconds = bench::cpu_seconds() - begin;
  std::printf("digests: %.2f GB/s\n",
              1e-9 * cells * static_cast<double>(layout.record_bytes()) / digests);
  std::printf("rank 0: results of %5llu cells of %3u pixels: %.3f us a cell, %.0f ms a picture\n",
              static_cast<unsigned long long>(cells_an_entry), plan.grid()->shape().cell_pixels,
              1e6 * seconds / cells, 1e3 * seconds);
}

}  // namespace

int main() {
  const MpiWorld world;
  ReportJob report;
  const WindowLayout layout(*report.plan().grid(), world.ranks());
  const bool measures = world.rank() + 1 == world.ranks();
  MpiWindow window(world.comm(), layout.bytes(), layout.zeroed_bytes());
  if (measures) {
    bench::warn_of_assertions();
    std::printf("%s; medians; %u ranks\n", bench::processor().c_str(), world.ranks());
    measure_window(window.of(0), layout.record_offset(0));
  }
  const auto meet = [&world] { return world.barrier(seconds(3600)); };
  if (world.ranks() > 1) {
    if (world.first()) {
      serve(world, [&] { window.progress(); });
    } else {
      WindowSource source(report.job, report.pass, layout, window.of(0),
                          one_cell_leases(world.rank()));
      if (measures) measure_leases(source, "window", report.plan());
      serve(world, [] {});
    }
    if (world.first()) {
      serve(world, [&] { answer_requests(world.comm(), window.memory()); });
    } else {
      RequestWindow requests(ask_first_rank(world.comm()));
      WindowSource source(report.job, report.pass, layout, requests, one_cell_leases(world.rank()));
      if (measures) measure_leases(source, "messages", report.plan());
      serve(world, [] {});
    }
  }
  if (measures) {
    measure_hand_over();
    for (const std::uint64_t cells : {1U, 30U, 1000U}) measure_collector(500, cells);
    measure_collector(12, 10);
    measure_collector(6, 10);
  }
  return meet() ? 0 : 1;
}

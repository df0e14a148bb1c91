#include "worker/cell_tracer.h"

#include <doctest/doctest.h>

#include <atomic>
#include <new>
#include <stdexcept>
#include <thread>
#include <vector>

#include "common/scene/settings.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/small_traces.h"

namespace parray::test {

TEST_CASE("cells have the bits of single samples, whatever the threads, tiles and ranges") {
  Dice dice(1);
  for (const auto& settings :
       {sized(20, 13, 6), sized(3, 2, 5000), sized(500, 4, 9), sized(1, 1, 20'000)}) {
    const auto tracer = make_path_tracer(*shared_scene(), settings);
    for (const std::uint32_t tile : {0U, 4U}) {
      const auto plan = test::whole_plan(settings, tile);
      const std::uint64_t begin = dice.below(plan->cells());
      const CellRange part{begin, begin + 1 + dice.below(plan->cells() - begin)};
      for (const CellRange& range : {CellRange{0, plan->cells()}, part}) {
        const CellBatch batch = plan->batch(range);
        const auto expected = plain_records(settings, batch);
        for (const int threads : {1, 2, 3, 8}) {
          CAPTURE(threads);
          CAPTURE(tile);
          const TracedCells cells = traced(*tracer, batch, threads);
          CHECK(cells.range == range);
          CHECK(without_times(cells) == expected);
          CHECK(cells.samples == batch.sample_count());
          CHECK(fault_of(cells, batch, settings.max_depth).empty());
        }
      }
    }
  }
}

TEST_CASE("pixels with their own sample ranges get exactly these samples") {
  Dice dice(2);
  for (const auto& settings : {sized(33, 21, 50), sized(200, 3, 5), sized(2, 2, 4000)}) {
    const auto tracer = make_path_tracer(*shared_scene(), settings);
    const std::vector<std::uint32_t> before(std::size_t{settings.width} * settings.height, 6);
    const auto ranges = test::ragged_ranges(dice, before, settings.samples_per_pixel);
    const WorkPlan plan(settings, {{{6, 6 + settings.samples_per_pixel}}, ranges});
    const CellBatch batch = plan.batch({0, plan.cells()});
    for (const int threads : {1, 2}) {
      CHECK(without_times(traced(*tracer, batch, threads)) == plain_records(settings, batch));
    }
  }
}

TEST_CASE("cells of overlapping bodies of one glass are possible results") {
  Scene scene = small_scene();
  scene.camera.look_from = {0, 0, 30};
  scene.materials = {{MaterialType::dielectric, {1, 1, 1}, 0, 1.5}};
  scene.spheres.clear();
  for (int i = 0; i < 150; ++i) scene.spheres.push_back({{0, 0, 0.1 * i}, 4, 0});
  for (const std::uint32_t max_depth : {2U, 10U}) {
    for (const Precision precision : {Precision::f32, Precision::f64}) {
      RenderSettings settings = sized(20, 13, 6);
      settings.max_depth = max_depth;
      settings.precision = precision;
      const CellBatch batch = whole(settings);
      const TracedCells cells = traced(*make_path_tracer(scene, settings), batch, 1);
      CHECK(fault_of(cells, batch, max_depth).empty());
      std::uint64_t rays = 0;
      const std::size_t size = record_bytes(batch.grid->shape().cell_pixels);
      for (std::size_t at = 0; at < cells.records.size(); at += size) {
        rays += header_of(std::span(cells.records).subspan(at)).rays;
      }
      CHECK(rays > batch.sample_count() * max_depth);
    }
  }
}

TEST_CASE("records contain the time that their cells took") {
  const RenderSettings settings = sized(20, 20, 100);
  const CellBatch batch = whole(settings);
  const TracedCells cells = traced(*make_path_tracer(*shared_scene(), settings), batch, 1);
  double nanoseconds = 0;
  const std::size_t size = record_bytes(batch.grid->shape().cell_pixels);
  for (std::size_t at = 0; at < cells.records.size(); at += size) {
    const CellHeader header = header_of(std::span(cells.records).subspan(at));
    CHECK(header.nanoseconds > 0);
    nanoseconds += static_cast<double>(header.nanoseconds);
  }
  CHECK(nanoseconds <= 1e9 * cells.seconds);
}

TEST_CASE("a long lease returns its first cells, with the same bits") {
  const RenderSettings settings = sized(64, 64, 1024);
  const auto tracer = make_path_tracer(*shared_scene(), settings);
  const CellBatch batch = whole(settings);
  for (const int threads : {1, 2, 3}) {
    std::atomic<std::uint64_t> count = 0;
    const TracedCells part = trace_cells(*tracer, batch, threads, count, false, 1e-3);
    REQUIRE(part.range.begin == batch.range.begin);
    REQUIRE(part.range.count() > 0);
    REQUIRE(part.range.end < batch.range.end);
    const CellBatch first{batch.grid, part.range, {}};
    CHECK(part.samples == first.sample_count());
    CHECK(part.samples <= count);
    CHECK(without_times(part) == without_times(traced(*tracer, first, threads)));
    CHECK(fault_of(part, first, settings.max_depth).empty());
  }
}

TEST_CASE("a lease without time traces one piece") {
  const RenderSettings settings = sized(64, 64, 4);
  const auto tracer = make_path_tracer(*shared_scene(), settings);
  const CellBatch batch = whole(settings);
  std::atomic<std::uint64_t> count = 0;
  const TracedCells part = trace_cells(*tracer, batch, 1, count, false, 1e-12);
  CHECK(part.range.count() == batch.grid->shape().piece_cells);
}

TEST_CASE("a stop ends tracing early") {
  const auto tracer = make_path_tracer(*shared_scene(), endless());
  const auto plan = test::whole_plan(endless());
  const CellBatch batch = plan->batch({0, 10'000});
  std::atomic<std::uint64_t> count = 0;
  std::atomic<bool> stop = true;
  CHECK(trace_cells(*tracer, batch, 2, count, stop).samples == 0);
  CHECK(count == 0);
  stop = false;
  std::thread stopper([&] {
    eventually([&] { return count > 0; });
    stop = true;
  });
  const TracedCells cells = trace_cells(*tracer, batch, 2, count, stop);
  stopper.join();
  CHECK(cells.samples == count);
  CHECK(count > 0);
  CHECK(count < batch.sample_count());
}

TEST_CASE("an exception of a thread stops the others and reaches the caller unchanged") {
  const CellBatch batch = whole(endless());
  const ThrowingTracer tracer([] { throw std::runtime_error("a broken sphere"); });
  for (const int threads : {1, 2, 4}) {
    std::atomic<std::uint64_t> count = 0;
    CHECK_THROWS_WITH_AS(trace_cells(tracer, batch, threads, count, false), "a broken sphere",
                         std::runtime_error);
    CHECK(count < batch.sample_count());
  }
}

}  // namespace parray::test

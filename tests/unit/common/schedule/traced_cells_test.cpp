#include "common/schedule/traced_cells.h"

#include <doctest/doctest.h>

#include <array>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "common/base/bytes.h"
#include "common/scene/settings.h"
#include "tests/support/dice.h"
#include "tests/support/memory.h"
#include "tests/support/rooms.h"
#include "tests/support/window_rig.h"

namespace parray {
namespace {

using test::Dice;
using test::made_cells;

constexpr std::uint32_t depth = 8;

/// Some cells of a picture; ragged: with samples of each pixel's own.
CellBatch random_batch(Dice& dice, bool ragged) {
  RenderSettings settings =
      test::made_settings(1 + dice.below32(90), 1 + dice.below32(20), 1 + dice.below32(90));
  Pass pass{{{0, settings.samples_per_pixel}}, {}};
  if (ragged) {
    const std::vector<std::uint32_t> none(std::size_t{settings.width} * settings.height);
    pass.samples = test::ragged_ranges(dice, none, settings.samples_per_pixel);
  }
  const WorkPlan plan(settings, std::move(pass));
  const std::uint64_t begin = dice.below(plan.cells());
  return plan.batch(
      {begin, begin + 1 + dice.below(std::min<std::uint64_t>(plan.cells() - begin, 12))});
}

TracedCells without_times(TracedCells cells, const CellBatch& batch) {
  const std::size_t size = record_bytes(batch.grid->shape().cell_pixels);
  for (std::size_t at = 0; at < cells.records.size(); at += size) {
    std::fill_n(
        cells.records.begin() + static_cast<std::ptrdiff_t>(at + offsetof(CellHeader, nanoseconds)),
        sizeof(std::uint64_t), std::byte{});
  }
  cells.seconds = 0;
  return cells;
}

bool refused(std::string_view bytes, const CellBatch& batch) {
  try {
    unpack_cells(bytes, batch, depth);
  } catch (const DecodeError&) {
    return true;
  }
  return false;
}

/// One cell of two pixels with 4 samples each, of which one is not finite.
struct OneCell {
  OneCell() {
    GridShape shape{2, 1, RowOrder::sequential, 1, 2, 4, 1, {{0, 4}}};
    batch = {std::make_shared<const CellGrid>(shape), {0, 1}, {}};
    cells.range = {0, 1};
    cells.samples = 8;
    header = {20, 1, 0, 99};
    sums[0].sum = {5, 6, 7};
    sums[0].odd = {5, 0, 1};
    cells.excluded = {{0, 1, 2, 1}};
  }
  std::string fault() {
    cells.records.resize(record_bytes(2));
    std::memcpy(cells.records.data(), &header, sizeof header);
    std::memcpy(cells.records.data() + sizeof header, sums.data(), sizeof sums);
    const std::string found = fault_of(cells, batch, depth);
    // What is wrong in memory is wrong on the wire, too.
    const bool packable = cells.records.size() == record_bytes(2) && cells.range == batch.range;
    if (packable && cells.samples == 8) {
      CHECK(refused(pack_cells(cells, *batch.grid), batch) == !found.empty());
    }
    return found;
  }

  CellBatch batch;
  TracedCells cells;
  CellHeader header;
  std::array<PixelSums, 2> sums{};
};

constexpr std::uint64_t one = std::uint64_t{1} << 32;  // the largest radiance of a sample

}  // namespace

TEST_CASE("cells come back as they were packed, but for the times") {
  Dice dice(1);
  for (int round = 0; round < 400; ++round) {
    CAPTURE(round);
    const CellBatch batch = random_batch(dice, dice.one_in(2));
    const TracedCells cells = made_cells(batch, dice.bits());
    REQUIRE(fault_of(cells, batch, depth) == "");
    const TracedCells back = unpack_cells(pack_cells(cells, *batch.grid), batch, depth);
    REQUIRE(back == without_times(cells, batch));
  }
}

TEST_CASE("equal counts and sums have equal bytes, however long they took; others have others") {
  Dice dice(2);
  const CellBatch batch = random_batch(dice, false);
  const std::string bytes = pack_cells(made_cells(batch, 1), *batch.grid);
  CHECK(pack_cells(made_cells(batch, 999), *batch.grid) == bytes);
  TracedCells other = made_cells(batch);
  other.records.front() ^= std::byte{1};
  CHECK(pack_cells(other, *batch.grid) != bytes);
}

TEST_CASE("few samples take few bytes") {
  const auto plan = test::whole_plan(test::made_settings(64, 8, 1));
  const CellBatch batch = plan->batch({0, plan->cells()});
  CHECK(pack_cells(made_cells(batch), *batch.grid).size() < 64 * 8 * 20);  // 72 as sums
}

TEST_CASE("packed cells that are cut short or go on are refused") {
  Dice dice(3);
  for (int round = 0; round < 20; ++round) {
    const CellBatch batch = random_batch(dice, dice.one_in(2));
    const std::string bytes = pack_cells(made_cells(batch), *batch.grid);
    for (std::size_t size = 0; size < bytes.size(); size += 1 + dice.below(bytes.size() / 50 + 1)) {
      CHECK_UNARY(refused(bytes.substr(0, size), batch));
    }
    CHECK(refused(bytes + '\0', batch));
    CHECK(refused(bytes + std::string(16, '\0'), batch));
  }
}

TEST_CASE("packed cells of another batch are refused, or are other cells") {
  const auto plan = test::whole_plan(test::made_settings(64, 8, 40));
  const std::string bytes = pack_cells(made_cells(plan->batch({0, 2})), *plan->grid());
  CHECK(refused(bytes, plan->batch({0, 1})));
  CHECK(refused(bytes, plan->batch({0, 3})));
}

TEST_CASE("a byte changed anywhere is refused, or gives numbers that tracing could have given") {
  Dice dice(4);
  int refusals = 0;
  for (int round = 0; round < 3000; ++round) {
    const CellBatch batch = random_batch(dice, dice.one_in(2));
    std::string bytes = pack_cells(made_cells(batch), *batch.grid);
    const std::size_t at = dice.below(bytes.size());
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << dice.below(8)));
    try {
      const TracedCells back = unpack_cells(bytes, batch, depth);
      REQUIRE(fault_of(back, batch, depth) == "");
      REQUIRE(pack_cells(back, *batch.grid) == bytes);  // there is one form only
    } catch (const DecodeError&) {
      ++refusals;
    }
  }
  CHECK(refusals > 300);
}

TEST_CASE("bytes at random are refused without memory that they ask for") {
  Dice dice(5);
  const CellBatch batch = random_batch(dice, false);
  const std::uint64_t before = test::peak_address_space();
  for (int round = 0; round < 20'000; ++round) {
    std::string bytes(dice.below(200), '\0');
    for (char& byte : bytes) byte = static_cast<char>(dice.one_in(3) ? 0xFF : dice.below(256));
    CHECK_UNARY(refused(bytes, batch));
  }
  CHECK(test::peak_address_space() - before < std::uint64_t{16} << 20);
}

TEST_CASE("a result is of the cells and samples that were leased") {
  OneCell f;
  CHECK(f.fault() == "");
  SUBCASE("another range") { f.cells.range = {0, 2}; }
  SUBCASE("more samples") { ++f.cells.samples; }
  CHECK(f.fault() != "");
}

TEST_CASE("counts are no more than the samples can have") {
  OneCell f;
  SUBCASE("rays") {
    f.header.rays = 8 * depth * TraceCounts::rays_of_segment;
    CHECK(f.fault() == "");
    ++f.header.rays;
  }
  SUBCASE("very many rays") { f.header.rays = UINT64_MAX; }
  SUBCASE("samples that are not finite") { f.header.nonfinite = 9; }
  SUBCASE("lost throughput") {
    f.header.lost = 8 * TraceCounts::lost_of(1);
    CHECK(f.fault() == "");
    f.header.lost = 8 * (TraceCounts::lost_of(1) + 1) + 1;
  }
  CHECK(f.fault().find("counts") != std::string::npos);
}

TEST_CASE("sums are no more than the samples can have") {
  OneCell f;
  SUBCASE("sum") {
    f.sums[1].sum[2] = 4 * one;
    CHECK(f.fault() == "");
    ++f.sums[1].sum[2];
  }
  SUBCASE("square") {
    f.sums[0].sum_of_squares[0] = 4 * one;
    CHECK(f.fault() == "");
    ++f.sums[0].sum_of_squares[0];
  }
  SUBCASE("odd samples") { f.sums[0].odd[1] = 7; }
  SUBCASE("2^63") { f.sums[0].sum[0] = std::uint64_t{1} << 63; }
  SUBCASE("of a pixel without samples") {
    f.batch.samples = {{0, 4}, {2, 2}};
    f.cells.samples = 4;
    f.sums[1].sum[0] = 1;
  }
  CHECK(f.fault().find("sums") != std::string::npos);
}

TEST_CASE("excluded samples are those that are not in the sums, each named, all in the cells") {
  OneCell f;
  SUBCASE("one too few") { f.cells.excluded.clear(); }
  SUBCASE("one too many") { f.header.nonfinite = 0; }
  SUBCASE("another number") { f.cells.excluded[0].count = 2; }
  SUBCASE("none") { f.cells.excluded[0].count = 0; }
  SUBCASE("another row") { f.cells.excluded[0].y = 1; }
  SUBCASE("another column") { f.cells.excluded[0].x = 2; }
  SUBCASE("another sample") { f.cells.excluded[0].first = 4; }
  SUBCASE("more than follow") {
    f.cells.excluded[0] = {0, 1, 3, 2};
    f.header.nonfinite = 2;
  }
  SUBCASE("so many that their sum is the right one") {
    f.cells.excluded = {{0, 0, 0, 1}, {0, 1, 0, UINT32_MAX}, {0, 1, 0, 1}};
  }
  SUBCASE("one that comes twice") {
    f.cells.excluded = {{0, 1, 2, 1}, {0, 1, 2, 1}};
    f.header.nonfinite = 2;
  }
  SUBCASE("two of one pixel") {
    f.cells.excluded = {{0, 1, 1, 1}, {0, 1, 2, 1}};
    f.header.nonfinite = 2;
  }
  SUBCASE("out of order") {
    f.cells.excluded = {{0, 1, 2, 1}, {0, 0, 2, 1}};
    f.header.nonfinite = 2;
  }
  CHECK(f.fault().find("sample") != std::string::npos);
}

TEST_CASE("excluded samples are ones of their own cell and of their pixel's own range") {
  // Two cells of one pixel: samples 0 to 3, of which the pixel has 1 and 2, and samples 4 to 7.
  const auto grid =
      std::make_shared<const CellGrid>(GridShape{1, 1, RowOrder::sequential, 1, 1, 4, 1, {{0, 8}}});
  const CellBatch batch{grid, {0, 2}, {{1, 3}, {4, 8}}};
  const auto fault = [&](std::uint64_t first, std::uint64_t second,
                         const std::vector<ExcludedSamples>& excluded) {
    TracedCells cells;
    cells.range = batch.range;
    cells.samples = batch.sample_count();
    cells.records.resize(2 * record_bytes(1));
    cells.records[8] = std::byte(first);
    cells.records[record_bytes(1) + 8] = std::byte(second);
    cells.excluded = excluded;
    return fault_of(cells, batch, 10);
  };
  CHECK(fault(1, 2, {{0, 0, 2, 1}, {0, 0, 5, 2}}) == "");
  CHECK(fault(2, 1, {{0, 0, 2, 1}, {0, 0, 5, 2}}) != "");  // each cell has its own count
  CHECK(fault(1, 0, {{0, 0, 0, 1}}) != "");
  CHECK(fault(2, 0, {{0, 0, 2, 2}}) != "");
  CHECK(fault(1, 0, {{0, 0, 3, 1}}) != "");
}

TEST_CASE("cells that are not there are refused before memory is taken for them") {
  const auto grid = std::make_shared<const CellGrid>(
      GridShape{65536, 1024, RowOrder::sequential, 1, 65536, 1, 1, {{0, 1U << 20}}});
  const CellBatch batch{grid, {0, grid->cells()}, {}};
  CHECK_THROWS_AS(static_cast<void>(unpack_cells(std::string(1000, '\0'), batch, 10)), DecodeError);
}

}  // namespace parray

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "common/schedule/cell_grid.h"
#include "common/schedule/chunk_sizer.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::Dice;
using enum SchedulePolicy;

std::uint64_t ceil_div(std::uint64_t a, std::uint64_t b) { return (a + b - 1) / b; }

/// All chunks of a job, as one asker after the other takes them.
std::vector<std::uint64_t> chunks_of(SchedulePolicy policy, ChunkRequest request) {
  std::vector<std::uint64_t> chunks;
  request.remaining = request.total;
  request.step = 0;
  while (request.remaining > 0) {
    const std::uint64_t units = chunk_units(policy, request);
    REQUIRE(units >= 1);
    REQUIRE(units <= request.remaining);
    chunks.push_back(units);
    request.remaining -= units;
    ++request.step;
  }
  return chunks;
}

ChunkRequest rows(std::uint64_t count, std::uint32_t workers, std::uint32_t threads = 1,
                  std::uint64_t row_units = 1) {
  ChunkRequest request;
  request.total = count * row_units;
  request.remaining = request.total;
  request.row_units = row_units;
  request.workers = workers;
  request.threads = threads;
  return request;
}

ChunkRequest random_request(Dice& dice) {
  ChunkRequest request =
      rows(1 + dice.below(2000), 1 + dice.below32(300), 1 + dice.below32(64), 1 + dice.below(600));
  request.share = dice.one_in(8) ? 1 : dice.unit() + 1e-9;
  request.least = 1 + dice.below(dice.one_in(2) ? 4 : 100'000);
  request.most = request.least + dice.below(100'000);
  return request;
}

}  // namespace

TEST_CASE("the chunks of every policy add up to the job, whatever the numbers") {
  Dice dice(1);
  for (int i = 0; i < 2000; ++i) {
    const ChunkRequest request = random_request(dice);
    for (const SchedulePolicy policy : {static_split, guided, factoring, weighted}) {
      CAPTURE(name_of(policy));
      std::uint64_t sum = 0;
      for (const std::uint64_t chunk : chunks_of(policy, request)) sum += chunk;
      REQUIRE(sum == request.total);
    }
  }
}

TEST_CASE("a chunk lies within what remains for requests from any moment of a job") {
  Dice dice(2);
  for (int i = 0; i < 100'000; ++i) {
    ChunkRequest request = random_request(dice);
    request.total *= dice.one_in(10) ? std::uint64_t{1} << 30 : 1;
    request.remaining = 1 + dice.below(request.total);
    request.step = dice.one_in(10) ? dice.bits() : dice.below(5000);
    for (const SchedulePolicy policy : {static_split, guided, factoring, weighted}) {
      const std::uint64_t units = chunk_units(policy, request);
      CHECK_UNARY(units >= 1);
      CHECK_UNARY(units <= request.remaining);
    }
  }
}

TEST_CASE("only the weighted policy cuts rows, unless a cut row is all that is left") {
  Dice dice(3);
  for (int i = 0; i < 20'000; ++i) {
    ChunkRequest request = random_request(dice);
    request.remaining = 1 + dice.below(request.total);
    for (const SchedulePolicy policy : {static_split, guided, factoring}) {
      const std::uint64_t units = chunk_units(policy, request);
      CHECK_UNARY(units % request.row_units == 0 || units == request.remaining);
    }
  }
}

TEST_CASE("static gives every worker one equal share") {
  CHECK(chunks_of(static_split, rows(100, 4)) == std::vector<std::uint64_t>{25, 25, 25, 25});
  CHECK(chunks_of(static_split, rows(10, 4)) == std::vector<std::uint64_t>{3, 3, 3, 1});
  CHECK(chunks_of(static_split, rows(3, 8)) == std::vector<std::uint64_t>{1, 1, 1});
  CHECK(chunks_of(static_split, rows(1, 1)) == std::vector<std::uint64_t>{1});
  CHECK(chunks_of(static_split, rows(10, 4, 1, 50)) ==
        std::vector<std::uint64_t>{150, 150, 150, 50});
  for (std::uint32_t workers = 1; workers < 40; ++workers) {
    for (std::uint64_t height = 1; height < 60; ++height) {
      CHECK_UNARY(chunks_of(static_split, rows(height, workers)).size() <= workers);
    }
  }
}

TEST_CASE("guided gives ceil(R / P) rows, never below two a thread") {
  CHECK(chunks_of(guided, rows(100, 4)) ==
        std::vector<std::uint64_t>{25, 19, 14, 11, 8, 6, 5, 3, 3, 2, 2, 2});
  CHECK(chunks_of(guided, rows(40, 4, 4)) == std::vector<std::uint64_t>{10, 8, 8, 8, 6});
  CHECK(chunks_of(guided, rows(5, 2, 8)) == std::vector<std::uint64_t>{5});
  CHECK(chunks_of(guided, rows(3, 100)) == std::vector<std::uint64_t>{2, 1});
  Dice dice(4);
  for (int i = 0; i < 20'000; ++i) {
    ChunkRequest request = random_request(dice);
    request.remaining = request.row_units * (1 + dice.below(request.total / request.row_units));
    const std::uint64_t left = request.remaining / request.row_units;
    const std::uint64_t expected = std::max<std::uint64_t>(ceil_div(left, request.workers),
                                                           std::uint64_t{2} * request.threads);
    CHECK_UNARY(chunk_units(guided, request) == std::min(expected, left) * request.row_units);
  }
}

TEST_CASE("factoring gives batches of P equal chunks, each batch half of what is left") {
  const auto chunks = chunks_of(factoring, rows(64, 4));
  CHECK(chunks ==
        std::vector<std::uint64_t>{8, 8, 8, 8, 4, 4, 4, 4, 2, 2, 2, 2, 1, 1, 1, 1, 1, 1, 1, 1});
  for (const std::uint32_t workers : {1U, 3U, 16U, 100U}) {
    for (const std::uint64_t height : {1ULL, 2ULL, 799ULL, 1080ULL, 4000ULL}) {
      const auto all = chunks_of(factoring, rows(height, workers));
      CHECK(std::is_sorted(all.rbegin(), all.rend()));
      CHECK(all.front() == ceil_div(height, std::uint64_t{2} * workers));
      std::uint64_t left = height;
      for (std::size_t i = 0; i < all.size(); i += workers) {
        const std::uint64_t before = left;
        for (std::size_t k = i; k < std::min(i + workers, all.size()); ++k) {
          // Equal within a batch, but for the job's last chunk.
          CHECK_UNARY((all[k] == all[i] || k + 1 == all.size()));
          left -= all[k];
        }
        CHECK_UNARY(left <= before / 2);
      }
    }
  }
}

TEST_CASE("chunk_starts gives what one asker after the other takes, and ends with the total") {
  Dice dice(6);
  for (int i = 0; i < 1000; ++i) {
    ChunkRequest job = random_request(dice);
    for (const SchedulePolicy policy : {static_split, guided, factoring}) {
      CAPTURE(name_of(policy));
      job.remaining = dice.below(job.total + 1);  // whatever these were
      job.step = dice.below(9);
      std::vector<std::uint64_t> expected = {0};
      for (const std::uint64_t chunk : chunks_of(policy, job)) {
        expected.push_back(expected.back() + chunk);
      }
      const auto starts = chunk_starts(policy, job);
      REQUIRE(starts == expected);
      REQUIRE(starts.back() == job.total);
    }
  }
}

TEST_CASE("weighted gives half of the asker's share of what is left, within least and most") {
  ChunkRequest request = rows(100, 4, 1, 10);
  request.share = 0.25;
  CHECK(chunk_units(weighted, request) == 125);
  request.share = 0.5;
  CHECK(chunk_units(weighted, request) == 250);
  request.share = 0.001;
  CHECK(chunk_units(weighted, request) == 1);
  request.least = 7;
  CHECK(chunk_units(weighted, request) == 7);
  request.share = 1;
  request.most = 40;
  CHECK(chunk_units(weighted, request) == 40);
  request.remaining = 5;  // less than `least`
  CHECK(chunk_units(weighted, request) == 5);
  request.remaining = 1;
  CHECK(chunk_units(weighted, request) == 1);
}

TEST_CASE("weighted chunks stay within least and most until the last") {
  Dice dice(5);
  for (int i = 0; i < 20'000; ++i) {
    ChunkRequest request = random_request(dice);
    request.remaining = 1 + dice.below(request.total);
    const std::uint64_t units = chunk_units(weighted, request);
    CHECK_UNARY((units >= request.least || units == request.remaining));
    CHECK_UNARY(units <= request.most);
    // A faster worker never gets less.
    ChunkRequest faster = request;
    faster.share = std::min(1.0, request.share * 1.5);
    CHECK_UNARY(chunk_units(weighted, faster) >= units);
  }
}

TEST_CASE("a bound of most below least gives least, and an infinite job does not overflow") {
  ChunkRequest request = rows(100, 2);
  request.least = 10;
  request.most = 3;
  CHECK(chunk_units(weighted, request) == 10);
  request = rows(std::uint64_t{1} << 16, 1, 4096, std::uint64_t{1} << 24);
  for (const SchedulePolicy policy : {static_split, guided, factoring, weighted}) {
    CHECK(chunk_units(policy, request) >= 1);
    CHECK(chunk_units(policy, request) <= request.total);
  }
}

TEST_CASE("a chunk depends on its request alone") {
  Dice dice(6);
  for (int i = 0; i < 1000; ++i) {
    const ChunkRequest request = random_request(dice);
    for (const SchedulePolicy policy : {static_split, guided, factoring, weighted}) {
      CHECK_UNARY(chunk_units(policy, request) == chunk_units(policy, request));
    }
  }
}

namespace {

/// Largest run of rows that the window [begin, begin + size) of an order leaves out.
std::uint32_t largest_gap(const std::vector<std::uint32_t>& order, std::size_t begin,
                          std::size_t size) {
  const auto first = order.begin() + static_cast<std::ptrdiff_t>(begin);
  std::vector<std::uint32_t> window(first, first + static_cast<std::ptrdiff_t>(size));
  std::sort(window.begin(), window.end());
  const auto height = static_cast<std::uint32_t>(order.size());
  std::uint32_t gap = std::max(window.front() + 1, height - window.back());
  for (std::size_t i = 1; i < window.size(); ++i) gap = std::max(gap, window[i] - window[i - 1]);
  return gap;
}

/// Whether every window has a row in every stretch of 3/size of the image.
bool is_spread(const std::vector<std::uint32_t>& order) {
  const std::size_t height = order.size();
  for (const std::size_t size : {2U, 3U, 4U, 5U, 8U, 13U, 16U, 31U, 32U, 64U, 100U, 200U}) {
    for (std::size_t begin = 0; begin + size <= height; ++begin) {
      if (largest_gap(order, begin, size) * size > 3 * height) return false;
    }
  }
  return true;
}

bool is_permutation_of_rows(std::vector<std::uint32_t> order, std::uint32_t height) {
  std::sort(order.begin(), order.end());
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    if (order[i] != i) return false;
  }
  return order.size() == height;
}

}  // namespace

TEST_CASE("every row order is a permutation for every height, also the largest") {
  for (const RowOrder order : {RowOrder::sequential, RowOrder::interleaved}) {
    for (std::uint32_t height = 1; height <= 300; ++height) {
      CHECK_UNARY(is_permutation_of_rows(make_row_order(order, height), height));
    }
    for (const std::uint32_t height : {4095U, 4096U, 4097U, 65535U, 65536U}) {
      CHECK(is_permutation_of_rows(make_row_order(order, height), height));
    }
  }
  CHECK_FALSE(is_permutation_of_rows({0, 2, 2}, 3));
}

TEST_CASE("the sequential order is the image's own") {
  CHECK(make_row_order(RowOrder::sequential, 4) == std::vector<std::uint32_t>{0, 1, 2, 3});
}

TEST_CASE("the interleaved order reverses bits") {
  CHECK(make_row_order(RowOrder::interleaved, 8) ==
        std::vector<std::uint32_t>{0, 4, 2, 6, 1, 5, 3, 7});
  CHECK(make_row_order(RowOrder::interleaved, 5) == std::vector<std::uint32_t>{0, 4, 2, 1, 3});
  CHECK(make_row_order(RowOrder::interleaved, 1) == std::vector<std::uint32_t>{0});
}

TEST_CASE("any window of an interleaved order samples the whole image") {
  for (std::uint32_t height = 1; height <= 300; ++height) {
    CAPTURE(height);
    CHECK(is_spread(make_row_order(RowOrder::interleaved, height)));
  }
  CHECK_FALSE(is_spread(make_row_order(RowOrder::sequential, 100)));
}

}  // namespace parray

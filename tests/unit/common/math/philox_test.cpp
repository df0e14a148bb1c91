#include "common/math/philox.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "common/math/lanes_scalar.h"
#include "common/trace/integrator/random.h"
#include "tests/support/rooms.h"
#include "tests/support/statistics.h"

namespace parray {
namespace {

using test::z_limit;

constexpr std::array<Purpose, 3> purposes{Purpose::camera, Purpose::scatter, Purpose::fuzz};

using Bits = std::array<std::uint32_t, 4>;

Bits philox(const Bits& counter, PhiloxKey key) {
  const auto block =
      philox4x32<std::uint32_t>({counter[0], counter[1], counter[2], counter[3]}, key);
  return {block.a, block.b, block.c, block.d};
}

std::array<double, 4> numbers(const SampleRandom& random, std::uint32_t bounce, Purpose purpose) {
  const auto u = random.at<double>(bounce, purpose);
  return {u.a, u.b, u.c, u.d};
}

/// Adjacent duplicates of a sorted list.
std::size_t repeats(std::vector<std::array<double, 4>>& blocks) {
  std::sort(blocks.begin(), blocks.end());
  std::size_t count = 0;
  for (std::size_t i = 1; i < blocks.size(); ++i) count += blocks[i] == blocks[i - 1] ? 1U : 0U;
  return count;
}

/// Correlation of two uniform numbers as a standard normal number.
class Correlation {
 public:
  void add(double a, double b) {
    sum_ += (a - 0.5) * (b - 0.5);
    ++count_;
  }
  [[nodiscard]] double z() const { return test::z_score(sum_, count_, 0, 1.0 / 144); }

 private:
  double sum_ = 0;
  double count_ = 0;
};

}  // namespace

TEST_CASE("Philox4x32-10 gives the known answers of its authors") {
  CHECK(philox({0, 0, 0, 0}, {0, 0}) == Bits{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8});
  CHECK(philox({0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff}, {0xffffffff, 0xffffffff}) ==
        Bits{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd});
  // The digits of pi.
  CHECK(philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}) ==
        Bits{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1});
}

TEST_CASE("random numbers are the top 24 bits of Philox at their address") {
  const SampleRandom random(0x0123456789ABCDEF, 77, 5);
  const auto u = random.at<double>(3, Purpose::fuzz);
  const Bits bits = philox({77, 5, 3U << 8 | 2U, 0}, {0x89ABCDEF, 0x01234567});
  CHECK(u.a == static_cast<double>(bits[0] >> 8) / 0x1p24);
  CHECK(u.b == static_cast<double>(bits[1] >> 8) / 0x1p24);
  CHECK(u.c == static_cast<double>(bits[2] >> 8) / 0x1p24);
  CHECK(u.d == static_cast<double>(bits[3] >> 8) / 0x1p24);
}

TEST_CASE("lanes of addresses draw what each address draws alone") {
  using Uint = math::scalar::DoubleLanes::Uint;
  using Double = math::scalar::DoubleLanes;
  Uint pixel;
  Uint sample;
  for (std::uint32_t i = 0; i < 4; ++i) {
    pixel.v[i] = 0x40000000 * i + 7;
    sample.v[i] = 3 * i;
  }
  const auto u = RandomAddress<Uint>(~0ULL - 5, pixel, sample).at<Double>(9, Purpose::scatter);
  double found[4][Double::count];
  u.a.store(found[0]);
  u.b.store(found[1]);
  u.c.store(found[2]);
  u.d.store(found[3]);
  for (std::uint32_t i = 0; i < 4; ++i) {
    const SampleRandom alone(~0ULL - 5, pixel.v[i], sample.v[i]);
    CHECK(std::array{found[0][i], found[1][i], found[2][i], found[3][i]} ==
          numbers(alone, 9, Purpose::scatter));
  }
}

TEST_CASE("random numbers lie in [0, 1), have 24 bits and are equal in every precision") {
  std::size_t outside = 0;
  std::size_t too_fine = 0;
  std::size_t unequal = 0;
  double largest = 0;
  double smallest = 1;
  for (std::uint32_t pixel = 0; pixel < 20'000; ++pixel) {
    const SampleRandom random(9, pixel, pixel % 64);
    const auto narrow = random.at<float>(pixel % 50, Purpose::scatter);
    const auto wide = random.at<double>(pixel % 50, Purpose::scatter);
    const std::array<float, 4> f{narrow.a, narrow.b, narrow.c, narrow.d};
    const std::array<double, 4> d{wide.a, wide.b, wide.c, wide.d};
    for (std::size_t i = 0; i < 4; ++i) {
      const double scaled = d[i] * 0x1p24;
      outside += d[i] >= 0 && d[i] < 1 ? 0U : 1U;
      too_fine += scaled == static_cast<double>(static_cast<std::uint32_t>(scaled)) ? 0U : 1U;
      unequal += static_cast<double>(f[i]) == d[i] ? 0U : 1U;
      largest = std::max(largest, d[i]);
      smallest = std::min(smallest, d[i]);
    }
  }
  CHECK(outside == 0);
  CHECK(too_fine == 0);
  CHECK(unequal == 0);
  CHECK(largest > 0.9999);
  CHECK(smallest < 0.0001);
}

TEST_CASE("no two of pixel, sample, bounce and purpose share their random numbers") {
  std::vector<std::array<double, 4>> blocks;
  for (std::uint32_t pixel = 0; pixel < 1000; ++pixel) {
    for (std::uint32_t sample = 0; sample < 10; ++sample) {
      const SampleRandom random(1, pixel, sample);
      for (std::uint32_t bounce = 0; bounce < 10; ++bounce) {
        for (const Purpose purpose : purposes) blocks.push_back(numbers(random, bounce, purpose));
      }
    }
  }
  REQUIRE(blocks.size() == 300'000);
  CHECK(repeats(blocks) == 0);
}

TEST_CASE("addresses at the ends of their ranges do not collide") {
  std::vector<std::array<double, 4>> blocks;
  for (const std::uint64_t seed : {0ULL, 1ULL, 1ULL << 32, (1ULL << 32) + 1, ~0ULL}) {
    for (const std::uint32_t pixel : {0U, 1U, 1U << 26, 0xFFFFFFFFU}) {
      for (const std::uint32_t sample : {0U, 1U, 1U << 24, 0xFFFFFFFFU}) {
        for (const std::uint32_t bounce : {0U, 1U, 255U, 256U, 1U << 20, (1U << 24) - 1}) {
          for (const Purpose purpose : purposes) {
            blocks.push_back(numbers(SampleRandom(seed, pixel, sample), bounce, purpose));
          }
        }
      }
    }
  }
  CHECK(repeats(blocks) == 0);
  auto twice = blocks;  // the check itself must see a repetition
  twice.push_back(blocks[blocks.size() / 2]);
  CHECK(repeats(twice) == 1);
}

TEST_CASE("random numbers are uniform and uncorrelated along every part of their address") {
  constexpr std::size_t bins = 64;
  std::array<std::vector<double>, 4> counts;
  counts.fill(std::vector<double>(bins));
  Correlation next_pixel;
  Correlation next_sample;
  Correlation next_bounce;
  Correlation next_purpose;
  Correlation next_seed;
  Correlation within;
  for (std::uint32_t i = 0; i < 200'000; ++i) {
    const std::uint32_t pixel = i % 500;
    const std::uint32_t sample = i / 500;
    const auto here = numbers(SampleRandom(1, pixel, sample), 0, Purpose::scatter);
    for (std::size_t k = 0; k < 4; ++k) counts[k][test::bin_of(here[k], bins)] += 1;
    within.add(here[0], here[1]);
    const auto other = [&](std::uint64_t seed, std::uint32_t p, std::uint32_t s, std::uint32_t b,
                           Purpose purpose) {
      return numbers(SampleRandom(seed, p, s), b, purpose)[0];
    };
    next_pixel.add(here[0], other(1, pixel + 1, sample, 0, Purpose::scatter));
    next_sample.add(here[0], other(1, pixel, sample + 1, 0, Purpose::scatter));
    next_bounce.add(here[0], other(1, pixel, sample, 1, Purpose::scatter));
    next_purpose.add(here[0], other(1, pixel, sample, 0, Purpose::fuzz));
    next_seed.add(here[0], other(2, pixel, sample, 0, Purpose::scatter));
  }
  for (const auto& channel : counts) CHECK(std::abs(test::chi_square_z(channel)) < z_limit);
  for (const Correlation& correlation :
       {next_pixel, next_sample, next_bounce, next_purpose, next_seed, within}) {
    CHECK(std::abs(correlation.z()) < z_limit);
  }
}

}  // namespace parray

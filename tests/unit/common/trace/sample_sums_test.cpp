#include "common/trace/integrator/sample_sums.h"

#include <doctest/doctest.h>

#include <limits>
#include <memory>
#include <vector>

#include "common/trace/integrator/path_tracer.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"

namespace parray::test {
namespace {

constexpr std::uint32_t run_width = 40;

/// As a kernel writes it.
double shifted(double value) { return value + RadianceScale::shift; }

double any_value(Dice& dice) {
  switch (dice.below(8)) {
    case 0: return 0;
    case 1: return RadianceScale::one;
    case 2: return RadianceScale::one - 1;
    case 3: return dice.one_in(4) ? std::numeric_limits<double>::quiet_NaN() : 1;
    default: return static_cast<double>(dice.below(std::uint64_t{1} << 32));
  }
}

struct Batch {
  SampleBatch samples;
  BatchRadiance radiance;
};

/// Runs of one to many samples of a pixel, one after the other.
std::unique_ptr<Batch> batch(Dice& dice) {
  auto made = std::make_unique<Batch>();
  SampleBatch& samples = made->samples;
  std::uint32_t x = 0;
  std::uint32_t sample = dice.below32(9);
  while (samples.count < SampleBatch::most && x < run_width) {
    const std::uint32_t i = samples.count++;
    samples.column[i] = x;
    samples.sample[i] = sample++;
    for (double& channel : made->radiance.of[i]) channel = shifted(any_value(dice));
    made->radiance.of[i][3] = shifted(0);
    x += dice.one_in(20) ? 1 : 0;
  }
  return made;
}

TEST_CASE("samples added side by side make the sums that they make one by one") {
  Dice dice(3);
  std::vector<PixelSums> sums(run_width);
  std::vector<PixelSums> expected(run_width);
  TraceCounts counts;
  TraceCounts expected_counts;
  for (int round = 0; round < 200; ++round) {
    const auto made = batch(dice);
    add_samples(made->samples, made->radiance, sums.data(), counts);
    for (std::uint32_t i = 0; i < made->samples.count; ++i) {
      const double* of = made->radiance.of[i];
      add_fixed({of[0], of[1], of[2]}, made->samples.sample[i], expected[made->samples.column[i]],
                expected_counts);
    }
  }
  CHECK(sums == expected);
  CHECK(counts == expected_counts);
  CHECK(counts.nonfinite > 0);
}

}  // namespace
}  // namespace parray::test

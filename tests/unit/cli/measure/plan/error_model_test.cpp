#include "cli/measure/plan/error_model.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "common/adaptive/passes.h"
#include "common/image/radiance_scale.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using doctest::Approx;

ErrorModel law_of(double deviation, std::vector<MeasuredError> measured, ExponentPrior prior) {
  return {ModelError::uniform(deviation), measured, prior};
}

/// Two halves: in one every sample is 0.5, in the other three quarters of the samples are 1 and the
/// rest 0, or the other way round.
struct HalfNoisy {
  HalfNoisy(std::uint32_t side, std::uint32_t samples)
      : pixels(std::size_t{side} * side), counts(pixels.size(), samples) {
    const RadianceScale scale(1);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const bool noisy = i >= pixels.size() / 2;
      for (std::uint32_t sample = 0; sample < samples; ++sample) {
        // Half of the pixels have more ones among their odd samples, half among their even ones.
        const bool one = (sample + i) % 2 == 0 ? sample % 4 < 3 : sample % 4 == 3;
        const std::uint64_t value = scale.to_fixed(noisy ? (one ? 1 : 0) : 0.5);
        pixels[i].add({value, value, value}, sample);
      }
    }
    state = {side, side, pixels, counts, 1};
  }
  std::vector<PixelSums> pixels;
  std::vector<std::uint32_t> counts;
  FramebufferView state;
};

TEST_CASE(
    "independent samples: the error is the standard deviation divided by the root of their "
    "number") {
  const ModelError model = ModelError::uniform(0.2);
  CHECK(model.at(1) == Approx(0.2));
  CHECK(model.at(100) == Approx(0.02));
  CHECK(model.samples_for(0.02) == Approx(100));
  CHECK(model.samples_for(0.4) == Approx(0.25));
}

TEST_CASE("with a known exponent of 0 the law contains the single measurement") {
  const ErrorModel law = law_of(0.2, {{16, 0.04, 0.01}}, {0, 0});
  CHECK(law.at(16) == Approx(0.04));
  CHECK(law.at(64) == Approx(0.02));
  CHECK(law.samples_for(0.01) == Approx(256));
  CHECK(law.relative_at(1 << 20) == Approx(0.01));
}

TEST_CASE("with a very weak prior, exact measurements determine the exponent") {
  // E = 0.3 n^-0.7
  std::vector<MeasuredError> measured;
  for (const double n : {8.0, 32.0, 128.0}) measured.push_back({n, 0.3 * std::pow(n, -0.7), 0.01});
  const ErrorModel law = law_of(1, measured, {0, 100});
  CHECK(law.exponent() == Approx(0.2));
  CHECK(law.at(1000) == Approx(0.3 * std::pow(1000, -0.7)));
  CHECK(law.samples_for(0.3 * std::pow(5000, -0.7)) == Approx(5000));
}

TEST_CASE("measurements and prior are weighted by their variances") {
  // Two measurements as good as each other would say d = 0.2; by hand, with x = -+ ln(2) and the
  // doubt of the first one octave pair away left out by a large standard error of both:
  // precision of the data 2 ln(2)^2 / r^2, of the prior 1 / s^2.
  const double r = 10;
  const double x = std::log(2.0);
  const double s = r / (std::sqrt(2.0) * x);  // as much as the data's
  const std::vector<MeasuredError> measured = {{4, std::pow(4, -0.7), r},
                                               {16, std::pow(16, -0.7), r}};
  const ErrorModel law = law_of(1, measured, {0.1, s});
  CHECK(law.exponent() == Approx(0.15).epsilon(1e-4));
  // At the last measurement its own doubt; beyond, the exponent's comes in: s^2 / 2 its variance.
  CHECK(law.relative_at(16) == Approx(r));
  const double away = std::log(1024.0 / 16);
  CHECK(law.relative_at(1024) == Approx(std::sqrt(r * r + s * s / 2 * away * away)).epsilon(1e-4));
}

TEST_CASE("the law interpolates measurements, and follows its exponent beyond them") {
  const ErrorModel law = law_of(1, {{4, 0.6, 0.001}, {64, 0.1, 0.001}}, {0.1, 0.001});
  CHECK(law.at(4) == Approx(0.6));
  CHECK(law.at(64) == Approx(0.1));
  // Gains are 1.2 and 0.8; half way between, in logarithms, at 16.
  CHECK(law.at(16) == Approx(std::sqrt(1.2 * 0.8) / 4));
  CHECK(law.exponent() == Approx(0.1).epsilon(0.01));
  CHECK(law.at(1024) == Approx(0.1 / 4 * std::pow(16, -law.exponent())));
  CHECK(law.at(1) == Approx(0.6 * 2 * std::pow(4, law.exponent())));
}

TEST_CASE("if the exponent is known, a measurement of more samples has more weight") {
  const ErrorModel law = law_of(1, {{4, 0.6, 0.001}, {256, 0.06, 0.001}}, {0, 0});
  // Gains 1.2 at 4 samples, 0.96 at 256.
  CHECK(law.at(256) < 0.0615);
  CHECK(law.at(256) > 0.06);
  CHECK(law.at(1024) == Approx(law.at(256) / 2));
}

TEST_CASE("Sobol points are worth most at powers of two, with a period of two octaves") {
  for (const double power : {1.0, 4.0, 16.0, 1024.0}) {
    CHECK(even_points(power) == Approx(power));
    CHECK(even_points(2 * power) == Approx(2 * power * std::exp(-0.214)));
    CHECK(even_points(1.5 * power) == Approx(1.5 * power * std::exp(-0.45)));
    CHECK(even_points(3.9999 * power) == Approx(4 * power).epsilon(1e-3));
  }
}

TEST_CASE("a law of Sobol points predicts the error at numbers that were not measured") {
  const double d = 0.2;
  const auto error = [&](double n) { return 0.3 / std::sqrt(n) * std::pow(even_points(n), -d); };
  std::vector<MeasuredError> measured;
  for (const double n : {4.0, 8.0, 12.0, 24.0, 32.0, 48.0}) measured.push_back({n, error(n), 0.01});
  const ErrorModel law(ModelError::uniform(1), measured, {0.1, 10}, Spread::points);
  CHECK(law.exponent() == Approx(d));
  for (const double n : {6.0, 48.0, 64.0, 72.0, 88.0, 128.0, 176.0, 1000.0}) {
    CHECK(law.at(n) == Approx(error(n)).epsilon(0.01));
  }
  // A smooth law is too sure between the powers of two.
  const ErrorModel smooth(ModelError::uniform(1), measured, {0.1, 10});
  CHECK(smooth.at(88) < 0.97 * error(88));
}

TEST_CASE("adaptive passes leave out pixels without noise") {
  const HalfNoisy picture(64, 32);
  const ModelError model = ModelError::adaptive(picture.state, 0.1);
  CHECK(model.at(32) == Approx(0.1));
  // As many samples again, all of them where the noise is: three times as many there.
  CHECK(model.at(64) == Approx(0.1 / std::sqrt(3.0)).epsilon(0.05));
  // In the long run half of all samples would be wasted by equal counts.
  CHECK(model.at(32 * 1024) == Approx(0.1 / std::sqrt(2 * 1024.0)).epsilon(0.05));
}

Forecast forecast_with(const ErrorModel& law, double target, double most_samples = 1e6,
                       UpperBound stated = {}, Sampler sampler = Sampler::independent) {
  return forecast_target({law, law, stated, stated, sampler}, target, most_samples);
}

TEST_CASE("a picture whose first samples meet the target stops there") {
  const ErrorModel law = law_of(0.1, {{32, 0.1 / std::sqrt(32.0), 0.01}}, {0, 0});
  const Forecast forecast = forecast_with(law, 0.1);
  CHECK(forecast.samples == first_samples);
  CHECK(forecast.passes == 1);
  CHECK(forecast.decisions == 0);
  CHECK(forecast.rmse == Approx(0.1 / std::sqrt(8.0)));
}

TEST_CASE("a target that needs little more than the pilot takes two more passes, 1 % beyond it") {
  const ErrorModel law = law_of(1, {{32, 1 / std::sqrt(32.0), 0.01}}, {0, 0});
  const Forecast forecast = forecast_with(law, 1 / std::sqrt(64.0));
  CHECK(forecast.passes == 3);  // 8, 32, the rest
  CHECK(forecast.decisions == 1);
  CHECK(forecast.samples == Approx(32 + 1.01 * 32).epsilon(1e-4));
  CHECK(forecast.rmse < 1 / std::sqrt(64.0));
}

TEST_CASE(
    "passes that do not place samples follow the law for equal numbers and add whole samples") {
  const ErrorModel even = law_of(1, {{32, 1 / std::sqrt(32.0), 0.01}}, {0, 0});
  const ErrorModel better = law_of(1, {{32, 0.5 / std::sqrt(32.0), 0.01}}, {0, 0});
  const auto forecast = [&](double target, bool pays) {
    return forecast_target({even, better, {}, {}, Sampler::independent, pays}, target, 1e6);
  };
  // Where placing never pays, and where a pass lacks too few samples to place them.
  for (const Forecast& one :
       {forecast(1 / std::sqrt(200.0), false), forecast(1 / std::sqrt(40.0), true)}) {
    CHECK(one.decisions == 0);
    CHECK(one.samples == std::floor(one.samples));
    CHECK(one.rmse == Approx(1 / std::sqrt(one.samples)));
  }
  const Forecast placed = forecast(1 / std::sqrt(200.0), true);
  CHECK(placed.decisions > 0);
  CHECK(placed.samples < 100);
}

TEST_CASE("passes to a distant target grow like those of a render, and end just beyond it") {
  const ErrorModel law = law_of(1, {{32, 1 / std::sqrt(32.0), 0.01}}, {0, 0});
  const Forecast forecast = forecast_with(law, 0.01);
  // 8, 32, 128, 512, 2048 (lacking 9488, more than 7 * 512); then 7952 lack: 2048 more, then all.
  CHECK(forecast.samples == Approx(4096 + 1.01 * (10000 - 4096)).epsilon(1e-3));
  CHECK(forecast.passes == 7);
  CHECK(forecast.decisions == 5);
}

TEST_CASE("passes of Sobol points end near a target, not far beyond it") {
  for (const double exponent : {0.0, 0.1, 0.25}) {
    CAPTURE(exponent);
    const ErrorModel law = law_of(1, {{32, 1 / std::sqrt(32.0), 0.01}}, {exponent, 0});
    for (double target = 0.1; target > 0.002; target *= 0.9) {
      const Forecast forecast = forecast_with(law, target, 1e9, {}, Sampler::sobol);
      CHECK(forecast.rmse <= target);
      CHECK(forecast.rmse > 0.97 * target);
      CHECK(forecast.decisions <= 9);
    }
  }
}

TEST_CASE("the stated interval must meet the target, not only the error") {
  const ErrorModel law = law_of(1, {{32, 1 / std::sqrt(32.0), 0.01}}, {0, 0});
  const UpperBound stated{1.21, 0};
  CHECK(stated.of(0.1, 100) == Approx(0.11));
  const Forecast forecast = forecast_with(law, 0.011, 1e6, stated);
  CHECK(stated.of(forecast.rmse, forecast.samples) <= 0.011);
  CHECK(forecast.rmse == Approx(0.01).epsilon(0.02));
}

TEST_CASE("passes end at the largest number of samples") {
  const ErrorModel law = law_of(1, {{32, 1 / std::sqrt(32.0), 0.01}}, {0, 0});
  const Forecast forecast = forecast_with(law, 1e-4, 5000);
  CHECK(forecast.samples == Approx(5000));
  CHECK(forecast.rmse > 1e-4);
}

TEST_CASE("a time limit: a pass takes at most half of the remaining time, unless little is left") {
  // The pilot takes 32 of 96 seconds and 1 for itself. Of 63 left half, 31.5; then of 30.5, of
  // 14.25, of 6.125; then 2.0625 is less than a 32nd of what is traced.
  const Forecast forecast = forecast_time({1, 1, 1}, 96, 1e6);
  CHECK(forecast.passes == 5);
  CHECK(forecast.samples == Approx(32 + 31.5 + 15.25 + 7.125 + 3.0625).epsilon(1e-5));
}

TEST_CASE("a time limit that is too short for the pilot ends it early, with at least two samples") {
  const Forecast forecast = forecast_time({1, 1, 1}, 5, 1e6);
  CHECK(forecast.passes == 1);
  CHECK(forecast.samples == 4);
  CHECK(forecast_time({1, 1, 1}, 1, 1e6).samples == 2);
}

}  // namespace
}  // namespace parray

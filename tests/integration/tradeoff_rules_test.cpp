#include <doctest/doctest.h>

#include <cmath>
#include <set>

#include "cli/measure/tradeoff/answer.h"
#include "cli/measure/tradeoff/measurement_log.h"
#include "cli/measure/tradeoff/reference.h"
#include "cli/measure/tradeoff/tradeoff_results.h"
#include "cli/output/processor.h"
#include "common/scene/limits.h"
#include "common/scene/settings.h"
#include "tests/support/rooms.h"

namespace parray::tradeoff {
namespace {

using doctest::Approx;

RenderSettings base_settings() {
  RenderSettings settings;
  settings.width = 100;
  settings.height = 50;
  settings.samples_per_pixel = 64;
  settings.sampler = Sampler::independent;
  settings.precision = Precision::f32;
  settings.accelerator = AcceleratorKind::bvh;
  return settings;
}

RenderSettings sampled(Sampler sampler, std::uint32_t samples) {
  RenderSettings settings = base_settings();
  settings.sampler = sampler;
  settings.samples_per_pixel = samples;
  return settings;
}

Row row(const RenderSettings& settings, double seconds, double rmse,
        VariedSetting varied = VariedSetting::spp) {
  Row one;
  one.varied = varied;
  one.settings = settings;
  one.options = options_of(settings);
  one.runs = 4;
  one.seconds = {seconds, seconds, seconds};
  one.samples = settings.samples_per_pixel;
  one.mse = rmse * rmse;
  one.rmse = rmse;
  one.budget.monte_carlo = rmse;
  return one;
}

/// Independent samples of variance 1 that take 1 ms each; sobol's error falls as 1 / samples.
std::vector<Row> known_rows() {
  std::vector<Row> rows;
  for (const std::uint32_t samples : {16U, 64U, 256U, 1024U}) {
    rows.push_back(
        row(sampled(Sampler::independent, samples), 1e-3 * samples, 1 / std::sqrt(samples)));
    rows.push_back(row(sampled(Sampler::sobol, samples), 1.25e-3 * samples, 2.0 / samples));
  }
  return rows;
}

TEST_CASE("trade: the Pareto front has the settings that are not dominated") {
  std::vector<Row> rows = {row(sampled(Sampler::independent, 16), 1, 4),
                           row(sampled(Sampler::independent, 32), 2, 3),
                           row(sampled(Sampler::independent, 64), 3, 3),   // as accurate, slower
                           row(sampled(Sampler::independent, 128), 2, 5),  // beaten by both first
                           row(sampled(Sampler::independent, 256), 9, 1)};
  rows.push_back(row(sampled(Sampler::sobol, 256), 9, 1));  // the same as the one before
  mark_front(rows);
  CHECK(rows[0].on_front);
  CHECK(rows[1].on_front);
  CHECK_FALSE(rows[2].on_front);
  CHECK(rows[2].dominated_by == rows[1].options);
  CHECK_FALSE(rows[3].on_front);
  CHECK(rows[3].dominated_by == rows[0].options);  // the fastest of those
  CHECK(rows[4].on_front);
  CHECK(rows[5].on_front);
}

TEST_CASE("trade: a power law is fitted, with its scatter") {
  const auto law = fit_power_law({{1, 8}, {2, 4}, {8, 1}});
  REQUIRE(law.has_value());
  CHECK(law->slope == Approx(-1));
  CHECK(law->slope_error == Approx(0).epsilon(1e-12));
  CHECK(law->at(4) == Approx(2));
  // By hand: x = 0, 1, 2 and y = 0, 0, 3 in logarithms; slope 3/2, residuals 1/2, -1, 1/2.
  const double e = std::exp(1.0);
  const auto rough = fit_power_law({{1, 1}, {e, 1}, {e * e, e * e * e}});
  REQUIRE(rough.has_value());
  CHECK(rough->slope == Approx(1.5));
  CHECK(rough->slope_error == Approx(std::sqrt(1.5 / 1 / 2)));
  CHECK_FALSE(fit_power_law({{1, 1}}).has_value());
  CHECK_FALSE(fit_power_law({{1, 1}, {1, 2}}).has_value());
  CHECK_FALSE(fit_power_law({{1, 1}, {2, 0}}).has_value());
}

TEST_CASE("trade: a curve goes through its points and is linear in the logarithms elsewhere") {
  const LogCurve curve({{100, 1}, {1, 100}, {10, 10}, {0, 5}, {1000, 1}});
  REQUIRE(curve.known());
  CHECK(curve.at(1) == Approx(100));
  CHECK(curve.at(10) == Approx(10));
  CHECK(curve.at(31.6227766) == Approx(3.16227766));
  CHECK(curve.at(0.01) == Approx(10000));
  CHECK(curve.at(1e6) == Approx(1));  // as the last two go: level
  CHECK_FALSE(LogCurve({{1, 1}, {2, -1}}).known());
  CHECK(LogCurve({{10, 5}}, -2).at(100) == Approx(0.05));
}

TEST_CASE("trade: the budget is the root of the squares of its parts") {
  const Budget budget{0.03, 0.04, 0.12, 0.84};
  CHECK(budget.predicted() == Approx(0.13));
  CHECK(budget.predicted_8bit() == Approx(0.85));
}

TEST_CASE("trade: quartiles interpolate between ranks") {
  const Quartiles quartiles = quartiles_of({4, 1, 3, 2});
  CHECK(quartiles.q1 == 1.75);
  CHECK(quartiles.median == 2.5);
  CHECK(quartiles.q3 == 3.25);
  CHECK(quartiles_of({7}).q3 == 7);
}

TEST_CASE("trade: a row is the mean of its runs, and counts how often stated errors hold") {
  const Variant variant{VariedSetting::spp, base_settings(), 2};
  Run run;
  run.options = options_of(variant.settings);
  run.seconds = 1;
  run.cpu_seconds = 4;
  run.mse = 0.01;
  run.claimed = 0.1;
  run.claims = {0, 1, 1, 1, 1};
  run.coverage = {0.5, 0.75, 0.9, 0.95, 1};
  Run other = run;
  other.seconds = 3;
  other.mse = 0.03;
  other.claims[3] = 0;
  const std::vector<const Run*> runs = {&run, &other};
  const Row calm = row_of(variant, runs, {false, 2});
  CHECK(calm.mse == Approx(0.02));
  CHECK(calm.mse_deviation == Approx(std::sqrt(2.0) * 0.01));
  CHECK(calm.rmse == Approx(std::sqrt(0.02)));
  CHECK(calm.claims == ByLevel{0, 1, 1, 0.5, 1});
  CHECK(calm.coverage == ByLevel{0.5, 0.75, 0.9, 0.95, 1});
  CHECK(calm.seconds.median == 2);
  CHECK(calm.ratio() == Approx(std::sqrt(0.5)));
  CHECK(row_of(variant, runs, {true, 2}).seconds.median == 2);  // 4 of both threads
}

TEST_CASE("trade: a stated error holds within its interval plus the error of the reference") {
  Run run;
  run.claimed = 0.1;
  const auto holds = [&](double rmse) {
    run.mse = rmse * rmse;
    return claim_holds(run, 0.09, 0.11, stated_level);
  };
  CHECK(holds(0.0901));
  CHECK(holds(0.1099));
  CHECK_FALSE(holds(0.0899));
  CHECK_FALSE(holds(0.1101));
  run.mse_scatter = 0.02;  // the reference is no better
  CHECK(holds(0.15));
}

TEST_CASE("trade: a machine is busy when threads do not get the processors that they ask for") {
  Run run;
  run.seconds = 1;
  run.cpu_seconds = 1.9;
  CHECK_FALSE(timing_of({run}, 2).busy);
  run.cpu_seconds = 1.2;
  CHECK(timing_of({run}, 2).busy);
}

TEST_CASE("trade: a paired bias is the square of the mean difference without the noise's own") {
  PairedDifference differences;
  // Two pixels: the first differs by 1 and 3, the second by noise alone, +2 and -2.
  differences.add({1, 1, 1, 2, 2, 2}, {0, 0, 0, 0, 0, 0});
  differences.add({3, 3, 3, 0, 0, 0}, {0, 0, 0, 2, 2, 2});
  const PairedBias bias = differences.bias();
  CHECK(bias.mean == Approx(1));       // (2 + 0) / 2
  CHECK(bias.square == Approx(-0.5));  // products 1 x 3 and 2 x -2
  CHECK(bias.rms() == 0);
  CHECK(PairedBias{0.04, 0.001, 0}.rms() == Approx(0.2));
  CHECK(PairedBias{0.04, 0.03, 0}.rms() == 0);
}

TEST_CASE("trade: the cheapest settings for an error, sampler by sampler") {
  // 0.02: independent takes 2500 samples and 2.5 s, sobol 100 and 0.125 s.
  const auto candidates = candidates_for(0.02, known_rows(), base_settings(), {});
  REQUIRE(candidates.size() == 2);
  CHECK(candidates[0].settings->sampler == Sampler::sobol);
  CHECK(candidates[0].settings->samples_per_pixel == 100);
  CHECK(candidates[0].seconds == Approx(0.125));
  CHECK(candidates[1].settings->samples_per_pixel == 2500);
  CHECK(candidates[1].seconds == Approx(2.5));
  const auto own = own_for(0.02, known_rows(), base_settings());
  REQUIRE(own.has_value());
  CHECK(own->settings->samples_per_pixel == 2500);
  CHECK(candidates_for(0.02, {}, base_settings(), {}).empty());
}

TEST_CASE(
    "trade: another depth is chosen if it is clearly faster, or the scene's own cannot suffice") {
  std::vector<Row> rows = known_rows();
  RenderSettings other = sampled(Sampler::independent, 64);
  other.max_depth = 5;
  rows.push_back(row(other, 0.032, 0.125, VariedSetting::depth));  // half the time
  PairedBiases biases;
  biases.depth[5] = {1e-6, 1e-9, 0};  // RMSE 0.001
  const auto depth_for = [&](double error) {
    return candidates_for(error, rows, base_settings(), biases)[0].settings->max_depth;
  };
  CHECK(depth_for(0.02) == 5);
  CHECK(depth_for(0.002) == 10);  // a quarter of the mean square
  rows.back() = row(other, 0.062, 0.125, VariedSetting::depth);
  CHECK(depth_for(0.02) == 10);
  other.max_depth = 20;
  rows.back() = row(other, 0.1, 0.125, VariedSetting::depth);
  CHECK(depth_for(0.005) == 10);
  biases.depth[10] = {1e-4, 1e-9, 0};  // RMSE 0.01
  CHECK(depth_for(0.005) == 20);
}

TEST_CASE("trade: a target is rounded down, so that the error stays within the goal") {
  std::vector<Row> rows;
  for (const double target : {0.1, 0.05, 0.025}) {
    RenderSettings settings = base_settings();
    settings.adaptive = true;
    settings.target_error = target;
    rows.push_back(row(settings, 1e-3 / (target * target), 0.97 * target, VariedSetting::target));
  }
  const auto candidates = candidates_for(0.0123456, rows, base_settings(), {});
  REQUIRE(candidates.size() == 1);
  CHECK(options_against(candidates[0].settings, base_settings()) ==
        "--sampler independent --target-error 0.0123");
  CHECK(candidates[0].seconds == Approx(1e-3 / (0.0123 * 0.0123)));
}

TEST_CASE(
    "trade: the search for a target has no limit on samples, whatever the scene's settings are") {
  std::vector<Row> rows;
  for (const double target : {0.1, 0.05, 0.025}) {
    const RenderSettings settings = with_target(base_settings(), Sampler::sobol, target);
    rows.push_back(row(settings, 1e-3 / (target * target), 0.97 * target, VariedSetting::target));
  }
  const auto candidates = candidates_for(0.001, rows, base_settings(), {});
  REQUIRE(candidates.size() == 1);
  CHECK(candidates[0].settings->samples_per_pixel == limits::max_samples_per_pixel);
  CHECK(candidates[0].settings->adaptive);
  CHECK(candidates[0].settings->target_error == 0.001);
}

TEST_CASE(
    "trade: samples of a setting that missed its error are corrected by the square of the ratio") {
  Row missed = row(sampled(Sampler::sobol, 100), 1, 0.03);
  const auto better = corrected(missed, 0.02);
  REQUIRE(better.has_value());
  CHECK(better->settings->samples_per_pixel == 226);  // 225, in pairs
  CHECK(better->seconds == Approx(2.25));
  CHECK_FALSE(corrected(row(sampled(Sampler::sobol, 100), 1, 0.0199), 0.02).has_value());
  CHECK_FALSE(corrected(row(sampled(Sampler::sobol, 100), 1, 0), 0.02).has_value());
}

TEST_CASE(
    "trade: the sentence names settings, time, error and the time of the scene's own settings") {
  Answer answer;
  answer.error = 0.01;
  answer.asked = true;
  answer.scene = base_settings();
  answer.scene->width = 1000;
  answer.scene->height = 500;
  answer.pick = row(sampled(Sampler::sobol, 38), 0.42, 0.0099);
  answer.pick.rmse_deviation = 0.0003;
  answer.own_seconds = 2.142;
  answer.own_options = "--sampler independent --spp 190";
  CHECK(sentence_of(answer) ==
        "For an RMSE of 0.01: --sampler sobol --spp 38 (0.42 s at 100 x 50 on this machine, about "
        "42 s at the scene's 1000 x 500; measured RMSE 0.0099 +- 0.0003); the scene's own settings "
        "reach it with --sampler independent --spp 190 and take 5.1 x as long.");
}

TEST_CASE("trade: the sentence says so where the scene's own settings are the answer") {
  Answer answer;
  answer.error = 0.005;
  answer.asked = true;
  answer.scene = base_settings();
  answer.pick = row(sampled(Sampler::independent, 78), 0.42, 0.0049);
  answer.pick.rmse_deviation = 0.0001;
  answer.own = same_but_samples(answer.pick.settings, base_settings());
  answer.own_options = "--sampler independent --spp 76";  // what was foreseen
  answer.own_seconds = 0.41;
  CHECK(sentence_of(answer) ==
        "For an RMSE of 0.005: --sampler independent --spp 78, the scene's own settings with 78 "
        "samples per pixel (0.42 s at 100 x 50 on this machine; measured RMSE 0.0049 +- 0.0001); "
        "no other measured settings are faster.");
  answer.pick = row(sampled(Sampler::sobol, 38), 0.42, 0.0049);
  CHECK_FALSE(same_but_samples(answer.pick.settings, base_settings()));
  answer.own = false;
  CHECK(sentence_of(answer).ends_with(
      "the scene's own settings reach it with --sampler independent --spp 76 and take about as "
      "long."));
}

TEST_CASE(
    "trade: the sweep tries every varied setting once, and leaves out those that take too long") {
  Pilot pilot;
  pilot.samples_per_second = 1e6;
  pilot.error = 0.1;
  pilot.other_speeds[AcceleratorKind::octree] = 1e4;
  RenderSettings slow = base_settings();
  slow.accelerator = AcceleratorKind::octree;
  slow.samples_per_pixel = 100;
  const auto sweep = plan_sweep(base_settings(), {slow}, pilot, 50);
  std::set<std::string> options;
  std::set<VariedSetting> tried;
  for (const Variant& variant : sweep.variants) {
    CHECK(options.insert(options_of(variant.settings)).second);
    tried.insert(variant.varied);
    CHECK(variant.runs >= 2);
    CHECK(variant.runs <= 16);
    // parray render counts the denoised picture where it has a target
    CHECK_FALSE((variant.settings->replicates && variant.settings->target_error > 0));
  }
  for (const VariedSetting varied :
       {VariedSetting::scene, VariedSetting::also, VariedSetting::spp, VariedSetting::target,
        VariedSetting::denoise, VariedSetting::depth, VariedSetting::precision}) {
    CHECK(tried.count(varied) == 1);
  }
  CHECK(tried.count(VariedSetting::accelerator) == 0);  // 8 s a render
  CHECK(sweep.left_out.size() >= 1);
  CHECK(std::set<std::string>(sweep.left_out.begin(), sweep.left_out.end()).size() ==
        sweep.left_out.size());
}

TEST_CASE(
    "trade: seeds of references, pairs and runs differ; settings with the same noise share them") {
  std::set<std::uint64_t> seeds;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    seeds.insert(seed_of(sampled(Sampler::sobol, 16), 1, i));
    seeds.insert(seed_of(sampled(Sampler::sobol, 32), 1, i));
    seeds.insert(reference_seed(1, i));
    seeds.insert(paired_seed(1, i));
  }
  CHECK(seeds.size() == 4000);
  RenderSettings deep = sampled(Sampler::sobol, 16);
  deep.max_depth = 50;
  deep.accelerator = AcceleratorKind::octree;
  CHECK(seed_of(deep, 1, 3) == seed_of(sampled(Sampler::sobol, 16), 1, 3));
}

TEST_CASE("trade: pictures shrink to fit the time, and keep their shape") {
  RenderSettings scene = base_settings();
  scene.width = 1200;
  scene.height = 800;
  scene.samples_per_pixel = 100;
  CHECK(with_size(scene, 0, 0, 120).width == 300);
  CHECK(with_size(scene, 0, 0, 120).height == 200);
  CHECK(with_size(scene, 600, 0, 120).height == 400);
  CHECK(with_size(scene, 0, 80, 120).width == 120);
  CHECK(with_size(scene, 10, 20, 120).width == 10);
  scene.samples_per_pixel = 10000;
  const RenderSettings small = with_size(scene, 0, 0, 240);  // 6000 pixels
  CHECK(small.width == 95);
  CHECK(small.height == 63);
}

TEST_CASE("trade: 8 bits round to the nearest code of sRGB and clamp") {
  CHECK(through_8bit(-1) == 0);
  CHECK(through_8bit(0) == 0);
  CHECK(through_8bit(2) == 1);
  CHECK(through_8bit(1) == 1);
  CHECK(through_8bit(0.2140) == Approx(0.2122).epsilon(1e-3));  // code 127 of 127.4
  CHECK(through_8bit(0.0002) == Approx(1 / (255 * 12.92)));     // code 0.66, rounded up
}

TEST_CASE("trade: a run is read back from its line, and a damaged line is not") {
  Run run;
  run.options = "--sampler sobol --spp 16";
  run.seed = 18446744073709551615U;
  run.seconds = 0.125;
  run.mse = -1e-9;
  run.coverage = {0.5, 0.8, 0.9, 0.95, 0.99};
  const std::string line = csv_line(run);
  CHECK(csv_line(run_of_csv(line)) == line);
  CHECK(run_of_csv(line).seed == run.seed);
  CHECK(run_of_csv(line).mse == -1e-9);
  CHECK_THROWS(run_of_csv(line.substr(0, line.rfind(','))));
  CHECK_THROWS(run_of_csv(line + ",1"));
  CHECK_THROWS(run_of_csv(line + "x"));
}

TEST_CASE(
    "trade: denoised pictures are few, have Sobol samples, and come from renders of raw ones") {
  Pilot pilot;
  pilot.samples_per_second = 1e6;
  pilot.error = 0.1;
  const auto denoised = [&](double seconds_of_filter) {
    pilot.denoise = seconds_of_filter;
    std::vector<Variant> found = plan_sweep(base_settings(), {}, pilot, 50).variants;
    std::erase_if(found,
                  [](const Variant& variant) { return variant.varied != VariedSetting::denoise; });
    return found;
  };
  const std::vector<Variant> quick = denoised(0.01);
  CHECK(quick.size() >= 2);
  for (const Variant& variant : quick) {
    CHECK(variant.settings->replicates);
    CHECK(variant.settings->sampler == Sampler::sobol);
    CHECK(variant.runs <= 4);
    const RenderSettings raw = with_denoise(variant.settings, false);
    CHECK(options_of(variant.settings) == options_of(raw) + " --denoise");
    CHECK(seed_of(variant.settings, 1, 3) == seed_of(raw, 1, 3));
  }
  const std::vector<Variant> slow = denoised(100);  // the first is tried all the same
  REQUIRE(slow.size() == 1);
  CHECK(slow[0].runs == 2);
}

TEST_CASE("trade: an answer may be denoised, with the samples that its own errors need") {
  // 1 s of filter, whatever the samples; an error of 0.5 / sqrt(samples).
  std::vector<Row> rows;
  for (const std::uint32_t samples : {16U, 64U, 256U}) {
    const RenderSettings settings = with_denoise(sampled(Sampler::sobol, samples), true);
    rows.push_back(
        row(settings, 1 + 1e-3 * samples, 0.5 / std::sqrt(samples), VariedSetting::denoise));
    rows.push_back(row(sampled(Sampler::sobol, samples), 0.1 * samples, 1 / std::sqrt(samples)));
  }
  const auto candidates = candidates_for(0.05, rows, base_settings(), {});
  REQUIRE(candidates.size() == 2);
  CHECK(options_against(candidates[0].settings, base_settings()) ==
        "--sampler sobol --spp 100 --denoise");
  CHECK(candidates[1].settings->samples_per_pixel == 400);
}

TEST_CASE("trade: denoised pictures count for pictures' calibration, and not for pixels'") {
  Row raw = row(sampled(Sampler::sobol, 64), 1, 0.1);
  raw.coverage = {0.4, 0.8, 0.9, 0.95, 0.99};
  raw.claims = {0.5, 0.75, 1, 1, 1};
  Row clean = row(with_denoise(raw.settings, true), 1, 0.1, VariedSetting::denoise);
  clean.claims = {0.25, 1, 1, 1, 1};
  Row turned = raw;  // the same random numbers again
  turned.varied = VariedSetting::precision;
  turned.claims = {};
  const auto found = calibration_of({raw, clean, turned});
  REQUIRE(found.size() == 3);
  CHECK(found[0].name == "all");
  CHECK(found[0].pixels == raw.coverage);
  CHECK(found[0].pictures == raw.claims);
  CHECK(found[2].name == "sobol, denoised");
  CHECK(found[2].pixel_runs == 0);
  CHECK(found[2].pictures == clean.claims);
}

TEST_CASE("trade: more workers divide the tracing, but not the denoising of one machine") {
  Row raw = row(sampled(Sampler::sobol, 64), 2, 0.1);
  Row clean = row(with_denoise(raw.settings, true), 6, 0.05, VariedSetting::denoise);
  clean.denoise_seconds = 4;
  RenderSettings scene = base_settings();
  scene.width *= 10;
  scene.height *= 10;
  const auto fronts = farm_fronts_of({raw, clean, row(raw.settings, 1, 0)}, scene, 2);
  REQUIRE(fronts.size() == 4);
  for (const FarmFront& front : fronts) {
    REQUIRE(front.points.size() == 2);  // without an error there is no point
    const double traced = 200.0 / front.workers;
    CHECK(front.points[0].seconds == Approx(traced).epsilon(0.02));
    CHECK(front.points[1].seconds == Approx(traced + 400).epsilon(0.02));
    CHECK(front.points[1].on_front);
  }
  CHECK(fronts[3].workers == 64);
}

TEST_CASE("trade: a caption names scene, machine, version and date in one line") {
  TradeoffResults results;
  results.scene_file = "/somewhere/it's \"here\".json";
  results.spheres = 484;
  results.base = base_settings();
  results.timing.threads = 2;
  results.environment = {"AMD EPYC 9V74 80-Core Processor", "avx512", "2026-11-22"};
  CHECK(caption_of(results) ==
        "it's \"here\", 484 spheres, 100 x 50 pixels; AMD EPYC 9V74, 2 threads, avx512; "
        "ParRay " PARRAY_VERSION ", 2026-11-22");
}

TEST_CASE("trade: a processor's name is shortened") {
  CHECK(short_processor("AMD EPYC 9V74 80-Core Processor") == "AMD EPYC 9V74");
  CHECK(short_processor("Intel(R) Xeon(R) Platinum 8375C CPU @ 2.90GHz") ==
        "Intel Xeon Platinum 8375C");
  CHECK(short_processor("unknown processor") == "unknown processor");
  CHECK(short_processor("Processor") == "Processor");
}

}  // namespace
}  // namespace parray::tradeoff

#include "cli/measure/tradeoff/session.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "cli/measure/tradeoff/answer.h"
#include "cli/measure/tradeoff/reference.h"
#include "cli/measure/tradeoff/variant.h"
#include "cli/output/processor.h"
#include "cli/output/text.h"
#include "common/adaptive/error_estimate.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/scene/settings.h"
#include "common/trace/isa.h"
#include "proto/clock.h"

namespace parray::tradeoff {
namespace {

using nlohmann::json;

// Shares of the time for each part of the session.
constexpr double reference_share = 0.3;
constexpr double sweep_share = 0.45;
constexpr double paired_share = 0.1;
constexpr double answer_share = 0.15;

/// Largest number of renders for each candidate of the answer.
constexpr std::uint32_t answer_runs = 8;
/// Largest error of the reference, relative to the smallest measured error.
constexpr double reference_to_smallest = 0.2;

std::string date_text(std::chrono::system_clock::time_point when) {
  const std::chrono::year_month_day date{std::chrono::floor<std::chrono::days>(when)};
  return formatted("%04d-%02u-%02u", static_cast<int>(date.year()),
                   static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()));
}

json to_json(const Pilot& pilot) {
  json speeds = json::object();
  for (const auto& [kind, speed] : pilot.other_speeds) speeds[std::string(name_of(kind))] = speed;
  return {{"samples_per_second", pilot.samples_per_second},
          {"other_speeds", speeds},
          {"overhead", pilot.overhead},
          {"denoise", pilot.denoise},
          {"error", pilot.error}};
}

Pilot pilot_from(const json& map) {
  Pilot pilot;
  pilot.samples_per_second = map.at("samples_per_second").get<double>();
  pilot.overhead = map.at("overhead").get<double>();
  pilot.error = map.at("error").get<double>();
  pilot.denoise = map.at("denoise").get<double>();
  for (const auto& [name, speed] : map.at("other_speeds").items()) {
    pilot.other_speeds[accelerator_from(name)] = speed.get<double>();
  }
  return pilot;
}

/// Returns an even number of samples per pixel that take about `seconds`.
std::uint32_t even_samples(double seconds, double samples_per_second, double pixels,
                           std::uint32_t most) {
  const double samples = seconds * samples_per_second / pixels;
  return 2 * static_cast<std::uint32_t>(std::clamp(samples / 2, 1.0, most / 2.0));
}

/// Makes the measurements of a session. Skips those that the log already has.
class Session {
 public:
  /// The arguments must outlive this object.
  Session(const Request& request, Bench& bench, MeasurementLog& log,
          const std::function<void(double)>& show)
      : request_(request),
        bench_(bench),
        log_(log),
        show_(show),
        reference_(request.base->width, request.base->height) {}

  TradeoffResults measure() {
    json& state = log_.state();
    try {
      if (!state.contains("pilot")) {
        state["pilot"] = to_json(pilot());
        log_.keep_state();
      }
      pilot_ = pilot_from(state["pilot"]);
      make_reference();
      sweep();
      if (!state.contains("biases")) {
        measure_biases();
        log_.keep_state();
      }
      biases_ = paired_biases_from(state["biases"]);
    } catch (const json::exception&) {
      throw InputError(printable(log_.file("state.json").string(), 4096) +
                       ": is damaged: start again with --restart");
    }
    TradeoffResults results;
    results.scene = request_.scene;
    results.base = request_.base;
    results.biases = biases_;
    results.reference_samples = reference_.samples();
    results.reference_rmse = reference_.rmse();
    refresh(results);
    find_answer(results);
    results.farms = farm_fronts_of(results.rows, request_.scene, bench_.threads());
    results.environment = environment();
    add_notes(results);
    return results;
  }

 private:
  /// A part of the session, for the progress bar.
  struct Stage {
    double from = 0;
    double share = 0;
  };
  void show(const Stage& stage, double done) const {
    show_(stage.from + stage.share * std::clamp(done, 0.0, 1.0));
  }

  /// Returns machine and date. The date is that of the last measurement.
  [[nodiscard]] Environment environment() {
    json& state = log_.state();
    const std::size_t runs = log_.runs().size();
    if (state.value("dated_runs", std::size_t{0}) != runs) {
      state["dated_runs"] = runs;
      state["date"] = date_text(std::chrono::system_clock::now());
      log_.keep_state();
    }
    const Isa isa = request_.base->isa == Isa::automatic ? best_isa() : request_.base->isa;
    return {processor_model(), std::string(name_of(isa)), state.value("date", "")};
  }

  // ---- Pilot ------------------------------------------------------------------------------------

  /// Returns the samples per second of the faster of two renders.
  double speed_of(const RenderSettings& settings, std::uint32_t samples) const {
    RenderSettings trial = settings;
    trial.samples_per_pixel = samples;
    double best = 0;
    for (std::uint32_t i = 0; i < 2; ++i) {
      trial.seed = paired_seed(settings.seed, 1000 + i);
      const DirectRender render = bench_.render(trial);
      best = std::max(best, pixels_of(trial) * samples / std::max(render.seconds, 1e-6));
    }
    return best;
  }

  Pilot pilot() {
    const RenderSettings& base = request_.base;
    Pilot pilot;
    pilot.samples_per_second = speed_of(base, Pilot::samples);  // also builds the accelerator
    RenderSettings trial = base;
    trial.samples_per_pixel = Pilot::samples;
    trial.seed = paired_seed(base.seed, 1000);
    const Time began = clock_.now();
    const DirectRender render = bench_.render(trial);
    pilot.overhead = to_seconds(clock_.now() - began) - render.seconds;
    pilot.error = std::max(estimate_rmse(render.state()).rmse, 0.0);
    pilot.denoise = bench_.denoise(trial, render).effort.wall;
    const std::size_t spheres = bench_.scene().spheres.size();
    for (const auto& [kind, most] : {std::pair{AcceleratorKind::linear, most_linear},
                                     {AcceleratorKind::bvh, std::size_t{SIZE_MAX}},
                                     {AcceleratorKind::octree, most_octree}}) {
      if (kind == base.accelerator || spheres > most || spheres == 0) continue;
      trial = base;
      trial.accelerator = kind;
      pilot.other_speeds[kind] = speed_of(trial, 1);
    }
    return pilot;
  }

  // ---- Reference --------------------------------------------------------------------------------

  void make_reference() {
    const Stage stage{0, reference_share};
    const RenderSettings& base = request_.base;
    if (std::filesystem::exists(log_.reference())) reference_.load(log_.reference());
    if (log_.state().value("reference_done", false)) {
      if (!reference_.balanced()) {
        throw InputError(printable(log_.reference().string(), 4096) +
                         ": is missing: start again with --restart");
      }
      return;
    }
    const double limit = reference_share * request_.seconds;
    const double pixels = pixels_of(base);
    RenderSettings settings = Reference::settings_of(base);
    settings.samples_per_pixel =
        even_samples(std::min(1.0, limit / 10), pilot_.samples_per_second / 1.5, pixels, 4096);
    // The largest number of samples that fits into the sweep. The target assumes that a sampler
    // makes them as good as four times as many independent samples.
    const double most = std::clamp(
        sweep_share * request_.seconds * pilot_.samples_per_second / (48 * pixels), 16.0, 4096.0);
    const double target =
        reference_to_smallest * pilot_.error * std::sqrt(Pilot::samples / (most * 4));
    const Time began = clock_.now();
    Time kept = began;
    for (;;) {
      const double took = to_seconds(clock_.now() - began);
      const bool enough = reference_.balanced() && (took > limit || reference_.rmse() <= target);
      if (enough || (reference_.balanced() && clock_.now() - kept > seconds(5))) {
        reference_.save(log_.reference());
        kept = clock_.now();
      }
      if (enough) break;
      settings.seed = reference_seed(base.seed, reference_.chunks());
      reference_.add(bench_.render(settings));
      show(stage, took / limit);
    }
    // The file has rounded values. Loads them, so that a later run works with the same values.
    reference_.load(log_.reference());
    log_.state()["reference_done"] = true;
    log_.keep_state();
  }

  // ---- Sweep ------------------------------------------------------------------------------------

  /// Returns whether the sweep measures these settings in this run.
  bool planned(const RenderSettings& settings, std::uint32_t run) const {
    return std::ranges::any_of(sweep_.variants, [&](const Variant& variant) {
      return run < variant.runs && options_of(variant.settings) == options_of(settings);
    });
  }

  /// Completes a run that has errors and times, and appends it to the log.
  void keep(Run measured, const RenderSettings& settings, const DirectRender& render) {
    const TraceCounts& counts = render.framebuffer.counts();
    const auto samples = static_cast<double>(std::max<std::uint64_t>(counts.samples, 1));
    measured.options = options_of(settings);
    measured.seed = settings.seed;
    measured.seconds += render.seconds;
    measured.cpu_seconds += render.cpu_seconds;
    measured.samples = render.samples_per_pixel();
    measured.rays = static_cast<double>(counts.rays) / samples;
    measured.truncation = static_cast<double>(counts.lost) * TraceCounts::lost_unit / samples *
                          render.largest_radiance;
    measured.passes = std::max(static_cast<double>(render.passes.size()), 1.0);
    log_.append(measured);
  }

  /// Measures one run. If the picture is needed with and without denoising, renders it only once.
  void measure_run(const RenderSettings& settings, std::uint32_t run) {
    RenderSettings seeded = settings;
    seeded.seed = seed_of(settings, request_.base->seed, run);
    if (log_.has(options_of(settings), seeded.seed)) return;
    const DirectRender render = bench_.render(seeded);
    const auto wanted = [&](bool denoised) {
      const RenderSettings twin = with_denoise(settings, denoised);
      return !log_.has(options_of(twin), seeded.seed) &&
             (denoised == settings.replicates || planned(twin, run));
    };
    if (wanted(false)) keep(reference_.compare(render), with_denoise(seeded, false), render);
    if (!wanted(true)) return;
    const DenoisedRender denoised = bench_.denoise(seeded, render);
    Run measured = reference_.compare(denoised.picture);
    measured.seconds = measured.denoise_seconds = denoised.effort.wall;
    measured.cpu_seconds = denoised.effort.cpu;
    keep(measured, with_denoise(seeded, true), render);
  }

  void sweep() {
    const Stage stage{reference_share, sweep_share};
    sweep_ = plan_sweep(request_.base, request_.also, pilot_, sweep_share * request_.seconds);
    std::size_t planned = 0;
    std::uint32_t rounds = 0;
    for (const Variant& variant : sweep_.variants) {
      planned += variant.runs;
      rounds = std::max(rounds, variant.runs);
    }
    const Time began = clock_.now();
    std::size_t done = 0;
    // Takes the variants in turn, so that a drift of the machine's speed affects all of them.
    for (std::uint32_t round = 0; round < rounds; ++round) {
      for (const Variant& variant : sweep_.variants) {
        if (variant.runs <= round) continue;
        const double took = to_seconds(clock_.now() - began) / (sweep_share * request_.seconds);
        if (took > 1.5 || (took > 1 && round >= 2)) {
          runs_missing_ = planned - done;
          return;
        }
        measure_run(variant.settings, round);
        ++done;
        show(stage, static_cast<double>(done) / static_cast<double>(planned));
      }
    }
  }

  void measure_biases() {
    const Stage stage{reference_share + sweep_share, paired_share};
    const RenderSettings& base = request_.base;
    // Divides by 1.2, because renders with a greater depth or in f64 take longer.
    const double each = paired_share * request_.seconds / static_cast<double>(paired_renders(base));
    const std::uint32_t samples =
        even_samples(each, pilot_.samples_per_second / 1.2, pixels_of(base), 256);
    log_.state()["biases"] = tradeoff::to_json(
        measure_pairs(bench_, base, samples, [&](double done) { show(stage, done); }));
    log_.state()["biases"]["samples_per_pixel"] = samples;
  }

  // ---- Answer -----------------------------------------------------------------------------------

  void refresh(TradeoffResults& results) const {
    results.timing = timing_of(log_.runs(), bench_.threads());
    results.rows = rows_of(sweep_.variants, log_.runs(), biases_, results.timing);
    results.convergence = convergence_of(results.rows, request_.base);
    results.calibration = calibration_of(results.rows);
    results.spheres = bench_.scene().spheres.size();
  }

  /// Measures settings of the answer if there is time. Returns their row, or null.
  const Row* measured(const RenderSettings& settings, TradeoffResults& results) {
    if (const Row* known = row_with(results.rows, settings)) return known;
    const Stage stage{1 - answer_share, answer_share};
    const double limit = answer_share * request_.seconds / 3;
    const Time began = clock_.now();
    for (std::uint32_t run = 0; run < answer_runs; ++run) {
      const double took = to_seconds(clock_.now() - began);
      if (run >= 4 && took > limit) break;
      measure_run(settings, run);
      if (run == 0 && to_seconds(clock_.now() - began) > limit) break;  // a single run must suffice
      show(stage, took / limit);
    }
    sweep_.variants.push_back({VariedSetting::answer, settings, answer_runs});
    refresh(results);
    return row_with(results.rows, settings);
  }

  void find_answer(TradeoffResults& results) {
    const auto own = std::ranges::find(results.rows, VariedSetting::scene, &Row::varied);
    if (own == results.rows.end()) {
      throw RunError("the scene's own settings were not measured: use a longer --time-budget");
    }
    const Row scene_row = *own;
    Answer answer;
    answer.asked = request_.error.has_value();
    answer.error = request_.error.value_or(scene_row.rmse);
    answer.scene = request_.scene;
    const auto candidates = candidates_for(answer.error, results.rows, request_.base, biases_);
    // Measures the candidates that should be fastest, because the answer must be a measured row.
    const double affordable = answer_share * request_.seconds / 2;
    for (std::size_t i = 0; i < std::min<std::size_t>(candidates.size(), 2); ++i) {
      std::optional<Candidate> next = candidates[i];
      for (int attempt = 0; next && next->seconds < affordable && attempt < 3; ++attempt) {
        const Row* row = measured(next->settings, results);
        next = row == nullptr ? std::nullopt : corrected(*row, answer.error);
      }
    }
    const Row* pick = fastest_within(answer.error, results.rows);
    if (!answer.asked) {
      answer.own_seconds = scene_row.seconds.median;
      answer.own_options = options_against(scene_row.settings, request_.scene);
    } else if (const auto equal = own_for(answer.error, results.rows, request_.base)) {
      answer.own_seconds = equal->seconds;
      answer.own_options = options_against(equal->settings, request_.scene);
    }
    json& facts = results.answer_facts;
    facts = {{"error", answer.error},
             {"asked", answer.asked},
             {"measured", pick != nullptr},
             {"own_options", answer.own_options},
             {"own_seconds", answer.own_seconds}};
    if (pick != nullptr) {
      answer.pick = *pick;
      answer.own = same_but_samples(pick->settings, request_.base);
      results.answer = sentence_of(answer);
      facts["options"] = options_against(pick->settings, request_.scene);
      facts["seconds"] = pick->seconds.median;
      facts["rmse"] = pick->rmse;
      facts["rmse_sd"] = pick->rmse_deviation;
      return;
    }
    results.answer =
        "For an RMSE of " + formatted("%.3g", answer.error) + ", no measured settings suffice; ";
    if (candidates.empty()) {
      const double systematic = std::hypot(scene_row.budget.depth, scene_row.budget.precision);
      results.answer +=
          systematic >= answer.error
              ? "path depth and precision of the scene's own settings cause an RMSE of " +
                    formatted("%.2g", systematic) +
                    " with any number of samples: allow a larger --error, or measure deeper paths "
                    "with --also '--max-depth N --precision f64'."
              : "use a longer --time-budget to measure more.";
      return;
    }
    const Candidate& best = candidates.front();
    facts["options"] = options_against(best.settings, request_.scene);
    facts["seconds"] = best.seconds;
    results.answer += options_against(best.settings, request_.scene) +
                      " should suffice, in about " + duration_text(best.seconds) + " at " +
                      std::to_string(request_.base->width) + " x " +
                      std::to_string(request_.base->height) +
                      " (extrapolated; use a longer --time-budget to measure it).";
  }

  void add_notes(TradeoffResults& results) const {
    double smallest = 0;
    double farthest = 0;
    for (const Row& row : results.rows) {
      if (row.rmse > 0 && (smallest == 0 || row.rmse < smallest)) smallest = row.rmse;
      const double ratio = row.ratio();
      if (ratio > 0 &&
          std::abs(std::log(ratio)) > std::abs(std::log(farthest > 0 ? farthest : 1))) {
        farthest = ratio;
      }
    }
    if (smallest > 0 && results.reference_rmse > reference_to_smallest * smallest) {
      results.notes.push_back("the reference's own RMSE is " +
                              formatted("%.2g", results.reference_rmse / smallest) +
                              " times the smallest measured one. It is subtracted, but makes small "
                              "errors less certain: use a longer --time-budget");
    }
    if (farthest > 1.1 || (farthest > 0 && farthest < 1 / 1.1)) {
      results.notes.push_back("in the worst row, the predicted error is " +
                              formatted("%.2f", farthest) +
                              " times the measured one (column predicted_to_rmse)");
    }
    if (runs_missing_ > 0) {
      results.notes.push_back("the time is used up: " + counted(runs_missing_, "render") +
                              " left out; the same command continues");
    }
    if (results.calibration.empty()) {
      results.notes.push_back(
          "no calibration of intervals: in all rows more than a fifth of the error is systematic, "
          "because of --max-depth or --precision");
    }
    results.left_out = sweep_.left_out;
    if (!sweep_.left_out.empty()) {
      results.notes.push_back(
          "settings whose renders would take too long are left out (" +
          std::to_string(sweep_.left_out.size()) +
          "; tradeoff.json lists them): use a longer --time-budget to measure them");
    }
    if (results.timing.busy) {
      results.notes.push_back(
          "the threads got less than 85 % of their processor time, as on a busy machine: seconds "
          "are processor time divided by threads");
    }
  }

  const Request& request_;
  Bench& bench_;
  MeasurementLog& log_;
  const std::function<void(double)>& show_;
  const SteadyClock clock_;
  Reference reference_;
  Pilot pilot_;
  Sweep sweep_;
  PairedBiases biases_;
  std::size_t runs_missing_ = 0;
};

}  // namespace

TradeoffResults measure_tradeoff(const Request& request, Bench& bench, MeasurementLog& log,
                                 const std::function<void(double)>& show) {
  return Session(request, bench, log, show).measure();
}

}  // namespace parray::tradeoff

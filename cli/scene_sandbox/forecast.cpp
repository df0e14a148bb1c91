#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>
#include <vector>

#include "cli/measure/plan/plan.h"
#include "cli/measure/plan/probe.h"
#include "cli/scene_sandbox/upload_jobs.h"
#include "common/adaptive/noise_model.h"
#include "common/scene/settings.h"
#include "common/trace/isa.h"

namespace parray::scene_sandbox {
namespace {

using nlohmann::json;

/// The farm's threads may be faster or slower than the thread of this process, by up to this factor
/// either way.
constexpr double doubt_of_machines = 1.5;

/// A forecast of one picture.
struct PictureForecast {
  Expected seconds;  ///< on the farm
  Expected samples;  ///< per pixel
  Expected error;    ///< value 0: unknown
  double thread_seconds = 0;
};

Expected widened(const Expected& expected, double factor) {
  return {expected.value, expected.low / factor, expected.high * factor};
}

json json_of(const Expected& expected) {
  return {{"low", expected.low}, {"expected", expected.value}, {"high", expected.high}};
}

/// Makes all times those of the processor: this process runs at low priority, beside others.
void use_processor_time(Probe& probe) {
  for (Effort* effort : {&probe.fixed, &probe.collect, &probe.pass, &probe.overheads}) {
    effort->wall = effort->cpu;
  }
  for (SamplerProbe& sampler : probe.samplers) {
    sampler.uniform_sample.wall = sampler.uniform_sample.cpu;
    sampler.adaptive_sample.wall = sampler.adaptive_sample.cpu;
  }
}

/// Returns a model of the farm with so many threads. Many threads count as fewer, faster ones, so
/// that the model stays cheap.
FarmModel farm_of(const RenderSettings& settings, std::size_t threads) {
  constexpr std::size_t most = 128;
  const std::size_t workers = std::clamp<std::size_t>(threads, 1, most);
  const double speed = std::max(1.0, static_cast<double>(threads) / static_cast<double>(workers));
  return {settings, std::vector<double>(workers, speed), 1};
}

/// Returns the samples per pixel of a picture without target and time limit. 0: it has one.
double counted_samples(const RenderSettings& settings) {
  if (!settings.passes.empty()) {
    const auto total =
        std::accumulate(settings.passes.begin(), settings.passes.end(), std::uint64_t{0});
    return static_cast<double>(total) / static_cast<double>(pixel_count(settings));
  }
  const bool limited =
      settings.target_error > 0 || settings.target_half_width > 0 || settings.time_limit > 0;
  return limited ? 0 : settings.samples_per_pixel;
}

/// Forecasts a picture with a known number of samples.
PictureForecast of_samples(const Probe& probe, const FarmModel& farm,
                           const RenderSettings& settings, double samples) {
  const SamplerProbe& law = probe.samplers.front();
  const double pixels = static_cast<double>(pixel_count(settings));
  const double rest = probe.fixed.cpu + probe.collect.cpu + probe.overheads.cpu;
  PictureForecast forecast;
  forecast.thread_seconds = samples * pixels * law.uniform_sample.cpu + rest;
  const double seconds = farm.seconds(forecast.thread_seconds - rest, samples, 1) + rest;
  const double doubt = std::exp(normal_95 * std::hypot(probe.timing_doubt, 0.05));
  forecast.seconds = widened({seconds, seconds, seconds}, doubt_of_machines * doubt);
  forecast.samples = {samples, samples, samples};
  if (samples >= 2) {
    const double rmse = law.uniform.at(samples);
    const double relative =
        std::exp(normal_95 * std::hypot(law.uniform.relative_at(samples), 0.04));
    forecast.error = widened({rmse, rmse, rmse}, relative);
  }
  return forecast;
}

/// Forecasts a picture that ends at its target error or time limit, whichever comes first.
PictureForecast of_goal(const Probe& probe, const FarmModel& farm, const RenderSettings& settings) {
  const auto best = [&](const PlanGoal& goal) {
    const std::vector<Choice> all = choices(probe, settings, goal, {}, farm);
    const auto adaptive = std::ranges::find_if(all, [](const Choice& c) { return c.adaptive; });
    const Choice& choice = adaptive == all.end() ? all.front() : *adaptive;
    return PictureForecast{choice.seconds, choice.samples, choice.error, choice.cpu_seconds};
  };
  const PlanGoal limit{.seconds = settings.time_limit, .seconds_option = "--time-limit"};
  if (settings.target_error <= 0) return best(limit);
  PictureForecast forecast =
      best({.error = settings.target_error, .error_option = "--target-error"});
  if (limit.seconds > 0 && forecast.seconds.value > limit.seconds) return best(limit);
  forecast.seconds = widened(forecast.seconds, doubt_of_machines);
  if (limit.seconds > 0) forecast.seconds.high = std::min(forecast.seconds.high, limit.seconds);
  return forecast;
}

bool can_forecast(const RenderSettings& settings) {
  return counted_samples(settings) > 0 || settings.target_error > 0 || settings.time_limit > 0;
}

/// Returns whether the time limit alone decides how long the picture takes.
bool ends_by_time(const RenderSettings& settings) {
  return counted_samples(settings) == 0 && settings.time_limit > 0 && settings.target_error <= 0;
}

std::vector<std::string> notes_of(const UploadRequest& request, const Submission& job,
                                  std::size_t threads) {
  const RenderSettings& settings = job.settings;
  std::vector<std::string> notes;
  if (can_forecast(settings)) {
    notes.emplace_back(
        "One thread of the server traced a part of the picture. The forecast assumes that the "
        "processors of the workers are free.");
    if (threads > 0 && !ends_by_time(settings)) {
      notes.emplace_back(
          "The interval of the time allows for threads of workers that are up to 1.5 times faster "
          "or slower than the server's thread, if no time limit ends the picture.");
    }
  }
  if (threads == 0) notes.emplace_back("No workers are connected.");
  if (settings.target_half_width > 0) {
    notes.emplace_back(settings.target_error > 0 || settings.time_limit > 0
                           ? "The forecast ignores the target half-width."
                           : "A target half-width alone cannot be forecast.");
  }
  if (job.denoise) notes.emplace_back("The error is that of the picture before denoising.");
  if (request.frames) {
    notes.emplace_back("The forecast assumes that all frames are like the first one.");
  }
  return notes;
}

/// Traces a part of the picture.
Probe probe_of(const Submission& job) {
  ProbeRequest request;
  request.scene = job.scene.get();
  request.settings = job.settings;
  if (!runs_on_this_machine(request.settings->isa)) request.settings->isa = best_isa();
  request.samplers = {job.settings->sampler};
  request.threads = 1;
  request.seconds = 2;
  request.error = job.settings->target_error;
  request.goal_seconds = job.settings->time_limit;
  if (request.error <= 0 && request.goal_seconds <= 0) request.goal_seconds = 60;
  request.image = "plan.exr";
  const std::atomic<bool> never_stopped = false;
  Probe probed = *probe(request, never_stopped);
  use_processor_time(probed);
  return probed;
}

/// Returns `forecast` for several pictures.
PictureForecast repeated(PictureForecast forecast, double times) {
  for (double* value : {&forecast.seconds.value, &forecast.seconds.low, &forecast.seconds.high}) {
    *value *= times;
  }
  forecast.thread_seconds *= times;
  return forecast;
}

}  // namespace

void write_forecast(const UploadRequest& request, std::size_t threads,
                    const ChildResources& resources) {
  confine(resources, resources.memory);
  // The probe writes a picture to the directory for temporary files.
  // NOLINTNEXTLINE(concurrency-mt-unsafe): there is one thread
  setenv("TMPDIR", enclosure_of(0).directory.c_str(), 1);
  std::size_t frames = 1;
  const Submission job = first_submission(request, frames);
  const RenderSettings& settings = job.settings;
  const double samples = counted_samples(settings);
  json answer = {{"threads", threads}, {"notes", notes_of(request, job, threads)},
                 {"seconds", nullptr}, {"samples_per_pixel", nullptr},
                 {"error", nullptr},   {"thread_seconds", nullptr}};
  if (can_forecast(settings)) {
    const Probe probed = probe_of(job);
    const FarmModel farm = farm_of(settings, threads);
    const PictureForecast forecast = repeated(
        samples > 0 ? of_samples(probed, farm, settings, samples) : of_goal(probed, farm, settings),
        static_cast<double>(frames));
    if (threads > 0) answer["seconds"] = json_of(forecast.seconds);
    answer["samples_per_pixel"] = forecast.samples.value;
    answer["thread_seconds"] = forecast.thread_seconds;
    if (forecast.error.value > 0) {
      answer["error"] = {{"rmse", forecast.error.value},
                         {"low", forecast.error.low},
                         {"high", forecast.error.high}};
    }
  }
  keep_bytes("../forecast", answer.dump());
}

}  // namespace parray::scene_sandbox

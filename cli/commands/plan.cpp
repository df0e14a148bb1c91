#include "cli/measure/plan/plan.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/commands/commands.h"
#include "cli/commands/loading.h"
#include "cli/commands/options.h"
#include "cli/commands/prepare.h"
#include "cli/commands/printing.h"
#include "cli/farm/direct_render.h"
#include "cli/output/picture/image_file.h"
#include "cli/output/text.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/base/text.h"
#include "common/process/stop_signal.h"
#include "common/scene/limits.h"
#include "common/scene/requirements.h"
#include "common/scene/settings.h"

namespace parray::commands {
namespace {

using nlohmann::json;

struct PlanCommand {
  std::string scene;
  RenderOptions render;
  PlanGoal goal;
  double probe_seconds = 3;
  std::string image;
  std::optional<std::uint32_t> threads;
  std::optional<std::uint32_t> workers;
  std::vector<double> speeds;  ///< speed of each worker, relative to this machine; empty: 1 each
  bool as_json = false;
  std::vector<std::string> given;  ///< given options that the render command repeats, as words
};

struct Plan {
  RenderSettings settings;
  Probe probe;
  std::vector<Choice> choices;
  Effort load;  ///< of reading the scene
  int threads = 1;
  FarmModel farm;
};

/// Returns the best choice with a fixed number of samples. Null: none.
const Choice* counted_choice(const Plan& plan) {
  const auto found = std::ranges::find_if(
      plan.choices, [](const Choice& choice) { return choice.samples_per_pixel > 0; });
  return found == plan.choices.end() ? nullptr : &*found;
}

/// Returns whether the probe took longer than the render will take.
bool rendering_is_cheaper(const Plan& plan) {
  return plan.farm.here() && plan.choices.front().seconds.value < plan.probe.seconds;
}

std::vector<std::string> words_of(const PlanCommand& command, const Choice& choice) {
  std::vector<std::string> words = {"parray", command.workers ? "submit" : "render", command.scene};
  if (command.workers) words.emplace_back("--wait");
  words.insert(words.end(), {"-o", command.image});
  words.insert(words.end(), command.given.begin(), command.given.end());
  words.insert(words.end(), {"--sampler", std::string(name_of(choice.sampler))});
  if (choice.samples_per_pixel > 0) {
    words.insert(words.end(), {"--spp", std::to_string(choice.samples_per_pixel)});
  } else if (choice.time_limit > 0) {
    words.insert(words.end(), {"--time-limit", formatted("%.4g", choice.time_limit)});
  } else {
    words.insert(words.end(), {"--target-error", formatted("%.12g", choice.target_error)});
  }
  return words;
}

// ---- JSON ------------------------------------------------------------------------------------

json json_of(const Expected& expected) {
  return {{"value", expected.value}, {"low", expected.low}, {"high", expected.high}};
}

json json_of(const PlanCommand& command, const Choice& choice) {
  const std::vector<std::string> words = words_of(command, choice);
  return {{"command", words},
          {"command_line", shell_line(words)},
          {"sampler", name_of(choice.sampler)},
          {"adaptive", choice.adaptive},
          {"samples_per_pixel", json_of(choice.samples)},
          {"error", json_of(choice.error)},
          {"seconds", json_of(choice.seconds)},
          {"cpu_seconds", choice.cpu_seconds},
          {"keeps_goal", choice.keeps}};
}

json document(const PlanCommand& command, const Plan& plan) {
  json all = json::array();
  for (const Choice& choice : plan.choices) all.push_back(json_of(command, choice));
  const Choice* const alternative = counted_choice(plan);
  const Probe& probe = plan.probe;
  json samplers = json::object();
  for (const SamplerProbe& one : probe.samplers) {
    samplers[std::string(name_of(one.sampler))] = {
        {"uniform_exponent", 0.5 + one.uniform.exponent()},
        {"adaptive_exponent", 0.5 + one.adaptive.exponent()},
        {"uniform_samples_per_second", 1 / one.uniform_sample.wall},
        {"adaptive_samples_per_second", 1 / one.adaptive_sample.wall}};
  }
  const auto or_null = [](double value) { return value > 0 ? json(value) : json(); };
  return {{"version", PARRAY_VERSION},
          {"scene", command.scene},
          {"width", plan.settings.width},
          {"height", plan.settings.height},
          {"threads", plan.threads},
          {"workers", plan.farm.speeds()},
          {"goal",
           {{"error", or_null(command.goal.error)},
            {"seconds", or_null(command.goal.seconds)},
            {"confidence", command.goal.confidence}}},
          {"recommended", all.front()},
          {"alternative", alternative == nullptr ? json() : json_of(command, *alternative)},
          {"rendering_is_cheaper", rendering_is_cheaper(plan)},
          {"choices", all},
          {"probe",
           {{"seconds", probe.seconds},
            {"pixels", probe.pixels},
            {"samples", probe.samples},
            {"samplers", samplers},
            {"costs",
             {{"load", plan.load.wall},
              {"once", probe.fixed.wall},
              {"collect", probe.collect.wall},
              {"pass", probe.pass.wall},
              {"finish", probe.overheads.wall}}}}}};
}

// ---- Text ------------------------------------------------------------------------------------

std::string error_text(double error) { return formatted("%.3g", error); }

std::string with_interval(const Expected& expected, std::string (*text)(double)) {
  return text(expected.value) + " (" + text(expected.low) + " to " + text(expected.high) + ")";
}

/// Returns a share in percent, rounded down, so that the text never promises too much.
std::string percent_text(double share) {
  const double steps = share < 0.99 ? 1000 : 10000;
  return formatted("%.4g %%", std::floor(std::min(share, 0.9999) * steps + 1e-3) * 100 / steps);
}

/// Returns the probability of keeping the goal, with a remark if it is lower than requested.
std::string probability_text(const PlanCommand& command, const Choice& choice) {
  const bool sure = choice.keeps >= command.goal.confidence - 1e-6;
  const std::string goal = command.goal.error > 0
                               ? "the error is at most " + number_cell(command.goal.error)
                               : "the time is at most " + duration_text(command.goal.seconds);
  return percent_text(choice.keeps) + " that " + goal +
         (sure ? "" : "; no command reaches " + percent_text(command.goal.confidence));
}

std::string samples_text(double samples) {
  return formatted(samples < 1000 ? "%.1f" : "%.0f", samples);
}

std::string way_text(const Choice& choice) {
  if (!choice.adaptive) return "uniform";
  return choice.time_limit > 0 ? "adaptive, time limit" : "adaptive";
}

std::string workers_text(const Plan& plan) {
  std::string threads = counted(static_cast<std::uint64_t>(plan.threads), "thread");
  if (plan.farm.here()) return threads;
  const std::vector<double>& speeds = plan.farm.speeds();
  const double power = std::accumulate(speeds.begin(), speeds.end(), 0.0);
  return counted(speeds.size(), "worker") + ", together as fast as " + number_cell(power) +
         " of this machine with " + threads + " (times exclude the network and sending the scene)";
}

void print_text(const PlanCommand& command, const Plan& plan) {
  const Choice& best = plan.choices.front();
  const std::string goal = command.goal.error > 0
                               ? "an error of " + number_cell(command.goal.error)
                               : "the smallest error in " + duration_text(command.goal.seconds);
  std::cout << "for " << goal << ", " << plan.settings.width << " x " << plan.settings.height
            << " pixels, " << workers_text(plan) << ":\n\n  " << shell_line(words_of(command, best))
            << "\n\n"
            << list_text({{"time", with_interval(best.seconds, duration_text)},
                          {"error", with_interval(best.error, error_text) + " RMSE"},
                          {"samples", with_interval(best.samples, samples_text) + " a pixel"},
                          {"probability", probability_text(command, best)}})
            << "\n";
  if (const Choice* const other = counted_choice(plan); other != nullptr && other != &best) {
    std::cout << "or, with a fixed number of samples (probability "
              << probability_text(command, *other) << "):\n\n  "
              << shell_line(words_of(command, *other)) << "\n\n";
  }
  std::vector<std::vector<std::string>> rows;
  for (const Choice& choice : plan.choices) {
    rows.push_back({std::string(name_of(choice.sampler)), way_text(choice),
                    samples_text(choice.samples.value), error_text(choice.error.value),
                    duration_text(choice.seconds.value), percent_text(choice.keeps)});
  }
  std::cout << table_text({"sampler", "samples", "per pixel", "error", "time", "probability"}, rows)
            << "\nprobed for " << duration_text(plan.probe.seconds) << ": "
            << counted(plan.probe.samples, "sample") << " in "
            << counted(plan.probe.pixels, "pixel") << "; intervals are 95 % confidence intervals\n"
            << (rendering_is_cheaper(plan) ? "rendering takes less time than this plan took\n"
                                           : "");
}

// ---- The command -----------------------------------------------------------------------------

std::vector<Sampler> candidates(const PlanCommand& command) {
  if (const auto asked = command.render.sampler()) return {*asked};
  return {Sampler::independent, Sampler::sobol};
}

void check_goal(const PlanCommand& command) {
  if ((command.goal.error > 0) == (command.goal.seconds > 0)) {
    throw InputError("plan needs --error or --time, not both");
  }
}

void check_workers(PlanCommand& command) {
  if (command.speeds.empty()) return;
  if (!command.workers) command.workers = static_cast<std::uint32_t>(command.speeds.size());
  if (*command.workers != command.speeds.size()) {
    throw InputError("--speeds has " + counted(command.speeds.size(), "speed") + " for " +
                     counted(*command.workers, "worker") + ": give one speed for each worker");
  }
}

FarmModel farm_of(const PlanCommand& command, const Plan& plan) {
  if (!command.workers) return {};
  std::vector<double> speeds = command.speeds;
  speeds.resize(*command.workers, 1);
  return {plan.settings, std::move(speeds), static_cast<std::uint32_t>(plan.threads)};
}

std::optional<Plan> make_plan(const PlanCommand& command) {
  const Effort began = effort_now();
  const SceneFile file = load_scene(command.scene, command.render);
  Plan plan;
  plan.settings =
      resolve_settings(requirements_of(file.scene, usable_cpus()), file.settings).settings;
  check_isa(plan.settings.isa);
  check_image_size(command.image, plan.settings.width, plan.settings.height);
  plan.load = effort_now() - began;
  plan.threads = static_cast<int>(command.threads.value_or(usable_cpus()));
  const DeferredInterrupts deferred;
  const StopPoller watch(interrupt_noted);
  ProbeRequest request;
  request.scene = &file.scene;
  request.settings = plan.settings;
  request.samplers = candidates(command);
  request.threads = plan.threads;
  request.seconds = command.probe_seconds;
  request.error = command.goal.error;
  request.goal_seconds = command.goal.seconds;
  request.image = command.image;
  auto probed = probe(request, watch.stop());
  if (!probed) return std::nullopt;
  plan.probe = std::move(*probed);
  plan.farm = farm_of(command, plan);
  plan.choices = choices(plan.probe, plan.settings, command.goal, plan.load, plan.farm);
  return plan;
}

int make_and_print(PlanCommand command) {
  check_goal(command);
  check_workers(command);
  if (command.image.empty()) command.image = default_picture(command.scene);
  check_image_path(command.image);
  const auto plan = make_plan(command);
  if (!plan) throw Interrupted();
  command.as_json ? print_json(document(command, *plan)) : print_text(command, *plan);
  return 0;
}

/// Returns the given options that the render command repeats, except the sampler. `farm`: a farm
/// renders.
std::vector<std::string> given_options(const Command& command, bool farm) {
  std::vector<std::string> words;
  for (const GivenOption& option : command.given_options()) {
    const bool of_rendering = option.group == settings_group || option.group == work_group ||
                              option.group == particles_group || option.name == "--transparent";
    const bool of_workers = farm && option.name == "--threads";  // each worker has its own
    if (of_rendering && !of_workers && option.name != "--sampler") {
      words.push_back(option.name);
      if (!option.value.empty()) words.push_back(option.value);
    }
  }
  return words;
}

std::vector<double> speeds_from(const std::string& text) {
  constexpr NumberRange range{1e-3, 1e3};
  std::vector<double> speeds;
  for (const std::string_view part : split_at(',', text)) {
    speeds.push_back(real_number(part, range));
  }
  return speeds;
}

}  // namespace

void add_plan(CommandLine& line) {
  Command command = line.command("plan",
                                 "Probe a scene briefly, and print the render command that is "
                                 "fastest for a given error, or most accurate for a given time");
  const auto options = std::make_shared<PlanCommand>();
  add_scene(command, options->scene);
  add_real_number(command, "--error", ranges::target_error, options->goal.error,
                  "Largest RMSE that the picture may have, in linear radiance");
  add_real_number(command, "--time", ranges::time_limit, options->goal.seconds,
                  "Seconds that the whole render may take");
  constexpr NumberRange confidence_range{0.5, 0.9999};
  add_real_number(
      command, "--confidence", confidence_range, options->goal.confidence,
      "Required probability that the command keeps the error, or the time (default: 0.95)");
  constexpr NumberRange probe_range{0.1, 3600};
  add_real_number(
      command, "--probe-seconds", probe_range, options->probe_seconds,
      "Longest time of the probe, in seconds of wall-clock time. A longer probe predicts better "
      "(default: 3). The probe takes at most half of the render's time, or 1 s if that is more");
  add_file(command, "-o,--output", options->image,
           "Picture that the render will write (default: the scene's name "
           "with .exr). The plan itself writes no picture")
      .type_name("IMAGE")
      .group(output_group);
  add_json(command, options->as_json);
  options->render.add_without_samples_to(command);
  add_threads(command, options->threads).group(work_group);
  constexpr std::uint32_t most_workers = 10000;
  add_whole_number(
      command, "--workers", 1, most_workers, options->workers,
      "Plan for a farm of N workers that are as fast as this machine. The coordinator runs here");
  command
      .option(
          "--speeds", [options](const std::string& text) { options->speeds = speeds_from(text); },
          "Speeds of the workers relative to this machine, such as 1,0.5,2")
      .type_name("S,S...");
  command.example("parray plan scenes/glass.json --error 0.01",
                  "prints the render command that reaches this error (RMSE, linear radiance) "
                  "fastest, and how long it takes");
  command.example("parray plan scenes/glass.json --time 60 --workers 8",
                  "finds the smallest error in a minute of eight workers like this machine");
  command.runs([options, command] {
    options->given = given_options(command, options->workers || !options->speeds.empty());
    return make_and_print(*options);
  });
}

}  // namespace parray::commands

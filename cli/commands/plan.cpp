#include "cli/plan/plan.h"

#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/commands/commands.h"
#include "cli/commands/loading.h"
#include "cli/commands/options.h"
#include "cli/commands/printing.h"
#include "cli/commands/rendering.h"
#include "cli/farm/direct_render.h"
#include "cli/output/text.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/image/image_file.h"
#include "common/process/stop_signal.h"
#include "common/scene/requirements.h"
#include "common/scene/scene_ranges.h"

namespace parray {
namespace {

using nlohmann::json;

struct PlanCommand {
  std::string scene;
  RenderOptions render;
  PlanGoal goal;
  double probe_seconds = 3;
  std::string image;
  std::optional<std::uint32_t> threads;
  bool as_json = false;
  std::vector<std::string> given;  ///< options that rendering takes, too, as words
};

/// What is said: about the scene, the probe, and each choice.
struct Plan {
  RenderSettings settings;
  Probe probe;
  std::vector<Choice> choices;
  Effort load;
  int threads = 1;
};

/// A word as a shell reads it.
std::string quoted(const std::string& word) {
  constexpr std::string_view plain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=,+:@%";
  if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) return word;
  std::string text = "'";
  for (const char c : word) {
    text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  }
  return text + "'";
}

/// The words of the command that renders what `choice` says.
std::vector<std::string> words_of(const PlanCommand& command, const Choice& choice) {
  std::vector<std::string> words = {"parray", "render", command.scene, "-o", command.image};
  words.insert(words.end(), command.given.begin(), command.given.end());
  words.insert(words.end(), {"--sampler", std::string(name_of(choice.sampler))});
  if (choice.samples_per_pixel > 0) {
    words.insert(words.end(), {"--spp", std::to_string(choice.samples_per_pixel)});
  } else if (choice.time_limit > 0) {
    words.insert(words.end(), {"--time-limit", formatted("%.4g", choice.time_limit)});
  } else {
    words.insert(words.end(), {"--target-error", formatted("%.12g", command.goal.error)});
  }
  return words;
}

std::string command_line(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) {
    line += (line.empty() ? "" : " ") + quoted(word);
  }
  return line;
}

// ---- JSON ------------------------------------------------------------------------------------

json json_of(const Expected& expected) {
  return {{"value", expected.value}, {"low", expected.low}, {"high", expected.high}};
}

json json_of(const PlanCommand& command, const Choice& choice) {
  const std::vector<std::string> words = words_of(command, choice);
  return {{"command", words},
          {"command_line", command_line(words)},
          {"sampler", name_of(choice.sampler)},
          {"adaptive", choice.adaptive},
          {"samples_per_pixel", json_of(choice.samples)},
          {"error", json_of(choice.error)},
          {"seconds", json_of(choice.seconds)},
          {"cpu_seconds", choice.cpu_seconds}};
}

json document(const PlanCommand& command, const Plan& plan) {
  json all = json::array();
  for (const Choice& choice : plan.choices) all.push_back(json_of(command, choice));
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
          {"goal",
           {{"error", or_null(command.goal.error)}, {"seconds", or_null(command.goal.seconds)}}},
          {"recommended", all.front()},
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
              {"finish", probe.finish.wall}}}}}};
}

// ---- Text ------------------------------------------------------------------------------------

std::string error_text(double error) { return formatted("%.3g", error); }

std::string with_interval(const Expected& expected, std::string (*text)(double)) {
  return text(expected.value) + " (" + text(expected.low) + " to " + text(expected.high) + ")";
}

std::string samples_text(double samples) {
  return formatted(samples < 1000 ? "%.1f" : "%.0f", samples);
}

std::string way_text(const Choice& choice) {
  if (!choice.adaptive) return "uniform";
  return choice.time_limit > 0 ? "adaptive, time limit" : "adaptive";
}

void print_text(const PlanCommand& command, const Plan& plan) {
  const Choice& best = plan.choices.front();
  const std::string goal = command.goal.error > 0
                               ? "an error of " + number_cell(command.goal.error)
                               : "the least error in " + duration_text(command.goal.seconds);
  std::cout << "for " << goal << " in " << plan.settings.width << " x " << plan.settings.height
            << " pixels, " << counted(static_cast<std::uint64_t>(plan.threads), "thread")
            << ":\n\n  " << command_line(words_of(command, best)) << "\n\n"
            << list_text({{"time", with_interval(best.seconds, duration_text)},
                          {"error", with_interval(best.error, error_text) + " RMSE"},
                          {"samples", with_interval(best.samples, samples_text) + " a pixel"}})
            << "\n";
  std::vector<std::vector<std::string>> rows;
  for (const Choice& choice : plan.choices) {
    rows.push_back({std::string(name_of(choice.sampler)), way_text(choice),
                    samples_text(choice.samples.value), error_text(choice.error.value),
                    duration_text(choice.seconds.value)});
  }
  std::cout << table_text({"sampler", "samples", "a pixel", "error", "time"}, rows)
            << "\nprobed for " << duration_text(plan.probe.seconds) << ": "
            << counted(plan.probe.samples, "sample") << " in "
            << counted(plan.probe.pixels, "pixel")
            << "; intervals are meant to hold 95 % of the time\n";
}

// ---- The command -----------------------------------------------------------------------------

std::string default_image(const std::string& scene) {
  return std::filesystem::path(scene).stem().string() + ".exr";
}

std::vector<Sampler> candidates(const PlanCommand& command) {
  if (const auto asked = command.render.sampler()) return {*asked};
  return {Sampler::independent, Sampler::sobol};
}

void check_goal(const PlanCommand& command) {
  if ((command.goal.error > 0) == (command.goal.seconds > 0)) {
    throw InputError("plan needs --error or --time, and not both");
  }
}

std::optional<Plan> make_plan(const PlanCommand& command) {
  const Effort began = effort_now();
  const SceneFile file = load_scene(command.scene, command.render);
  Plan plan;
  plan.settings = resolve_settings(requirements_of(file.scene), file.settings).settings;
  check_isa(plan.settings.isa);
  plan.load = effort_now() - began;
  plan.threads = static_cast<int>(command.threads.value_or(usable_cpus()));
  const DeferredInterrupts deferred;
  const StopWatch watch(interrupt_noted);
  ProbeRequest request;
  request.scene = &file.scene;
  request.settings = plan.settings;
  request.samplers = candidates(command);
  request.threads = plan.threads;
  request.seconds = command.probe_seconds;
  request.error = command.goal.error;
  request.image = command.image;
  auto probed = probe(request, watch.stop());
  if (!probed) return std::nullopt;
  plan.probe = std::move(*probed);
  plan.choices = choices(plan.probe, plan.settings, command.goal, plan.load);
  return plan;
}

int make_and_print(PlanCommand command) {
  check_goal(command);
  if (command.image.empty()) command.image = default_image(command.scene);
  check_image_path(command.image);
  const auto plan = make_plan(command);
  if (!plan) throw Interrupted();
  if (command.as_json) {
    print_json(document(command, *plan));
  } else {
    print_text(command, *plan);
  }
  return 0;
}

/// Options of the command line that rendering takes as well, but for the sampler.
std::vector<std::string> given_options(const Command& command) {
  std::vector<std::string> words;
  for (const GivenOption& option : command.given_options()) {
    const bool of_rendering = option.group == settings_group || option.group == work_group;
    if (of_rendering && option.name != "--sampler") {
      words.push_back(option.name);
      words.push_back(option.value);
    }
  }
  return words;
}

}  // namespace

void add_plan(CommandLine& line, Action& chosen) {
  Command command = line.command(
      "plan",
      "Say how to reach an error, or use a time, and what it will take, after a short probe");
  const auto options = std::make_shared<PlanCommand>();
  add_scene(command, options->scene);
  add_real_number(command, "--error", ranges::target_error, options->goal.error,
                  "RMSE that the picture may have, in linear radiance");
  add_real_number(command, "--time", ranges::time_limit, options->goal.seconds,
                  "Seconds that the render may take in all");
  constexpr NumberRange probe_range{0.1, 3600};
  add_real_number(command, "--probe-seconds", probe_range, options->probe_seconds,
                  "Seconds of tracing to predict from, about: more predict better (default: 3)");
  command
      .option("-o,--output", options->image,
              "Picture that the render will write (default: the scene's name "
              "with .exr); the plan writes none")
      .type_name("IMAGE")
      .forbid_empty();
  add_json(command, options->as_json);
  options->render.add_without_samples_to(command);
  constexpr std::uint32_t most_threads = 4096;  // the protocol's
  add_whole_number(
      command, "--threads", 1, most_threads,
      [options](std::uint64_t value) { options->threads = static_cast<std::uint32_t>(value); },
      "Threads to trace with (default: every processor that may be used)")
      .group(work_group);
  command.on_chosen([options, command, &chosen] {
    options->given = given_options(command);
    chosen = [options] { return make_and_print(*options); };
  });
}

}  // namespace parray

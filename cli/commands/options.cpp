#include "cli/commands/options.h"

#include <charconv>
#include <limits>
#include <string_view>
#include <utility>

#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/scene/limits.h"

namespace parray {
namespace {

std::uint64_t whole_number(const std::string& option, const std::string& text, std::uint64_t least,
                           std::uint64_t most) {
  std::uint64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || value < least || value > most) {
    throw CLI::ValidationError(option, "'" + printable(text) + "' is not a whole number from " +
                                           std::to_string(least) + " to " + std::to_string(most));
  }
  return value;
}

constexpr const char* settings_group = "Settings of the picture (default: the scene's)";

/// An option with a few known words. `read` throws InputError for any other.
template <typename Value>
void add_choice(CLI::App& command, const std::string& name, const std::string& words,
                Value (*read)(std::string_view), std::optional<Value>& target,
                const std::string& description, const std::string& group) {
  command
      .add_option_function<std::string>(
          name,
          [name, read, &target](const std::string& text) {
            try {
              target = read(text);
            } catch (const InputError& error) {
              throw CLI::ValidationError(name, error.what());
            }
          },
          description)
      ->type_name(words)
      ->take_last()
      ->group(group);
}

/// An empty value would read as "not given".
void forbid_empty(CLI::Option& option) {
  option.check([name = option.get_name()](const std::string& text) {
    return text.empty() ? std::string("the name is empty") : std::string();
  });
}

}  // namespace

CLI::Option* add_whole_number(CLI::App& command, const std::string& names, std::uint64_t least,
                              std::uint64_t most, std::function<void(std::uint64_t)> set,
                              const std::string& description) {
  return command
      .add_option_function<std::string>(
          names,
          [names, least, most, set = std::move(set)](const std::string& text) {
            set(whole_number(names, text, least, most));
          },
          description)
      ->type_name("N")
      ->take_last();
}

void add_scene(CLI::App& command, std::string& scene, const char* name) {
  auto* option =
      command
          .add_option(name, scene,
                      "Scene file (JSON), or a file of particles: PLY, CSV, XYZ, LAMMPS dump, PDB "
                      "or mmCIF")
          ->required();
  forbid_empty(*option->type_name(""));
}

double real_number(const std::string& option, const std::string& text, NumberRange range) {
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || !(value >= range.least && value <= range.most)) {
    throw CLI::ValidationError(option, "'" + printable(text) + "' is not a number from " +
                                           number_text(range.least) + " to " +
                                           number_text(range.most));
  }
  return value;
}

void add_job(CLI::App& command, std::uint64_t& job) {
  add_whole_number(
      command, "JOB", 0, std::numeric_limits<std::uint64_t>::max(),
      [&job](std::uint64_t value) { job = value; }, "Number of the job, as submit prints it")
      ->required()
      ->type_name("")
      ->multi_option_policy(CLI::MultiOptionPolicy::Throw);
}

void RenderOptions::add_to(CLI::App& command) {
  const auto number = [&](const char* name, std::uint32_t most,
                          std::optional<std::uint32_t>& target, const char* description) {
    add_whole_number(
        command, name, 1, most,
        [&target](std::uint64_t value) { target = static_cast<std::uint32_t>(value); }, description)
        ->group(settings_group);
  };
  number("--width", limits::max_image_side, width_, "Pixels across");
  number("--height", limits::max_image_side, height_, "Pixels down");
  number("--spp", limits::max_samples_per_pixel, samples_per_pixel_,
         "Samples per pixel: four times as many take four times as long and halve the noise");
  number("--max-depth", limits::max_depth, max_depth_, "Longest path, in ray segments");
  add_whole_number(
      command, "--seed", 0, std::numeric_limits<std::uint64_t>::max(),
      [this](std::uint64_t value) { seed_ = value; }, "Another seed gives other noise")
      ->group(settings_group);
  add_choice(command, "--sampler", "independent|sobol", sampler_from, sampler_,
             "Random numbers of a pixel's samples: independent of each other, or evenly spread "
             "(Owen-scrambled Sobol)",
             settings_group);
  add_choice(
      command, "--precision", "auto|f32|mixed|f64", precision_from, precision_,
      "Arithmetic of the tracing; auto goes by the scene's sizes; mixed: spheres stored in 32 "
      "bits, computed with in 64",
      settings_group);
  add_choice(command, "--accelerator", "auto|linear|bvh|octree", accelerator_from, accelerator_,
             "How spheres are searched; octree: as the seed program did, to compare with",
             work_group);
  add_choice(command, "--isa", "auto|scalar|avx2|avx512", isa_from, isa_,
             "Instruction set to trace with; auto: the best that a machine has", work_group);
  add_choice(command, "--schedule", "static|guided|factoring|weighted", schedule_from, schedule_,
             "How rows are dealt out to workers (default: weighted)", work_group);
  add_choice(command, "--row-order", "auto|sequential|interleaved", row_order_from, row_order_,
             "In which order; auto: interleaved with weighted", work_group);
}

RenderSettings RenderOptions::over(const RenderSettings& of_scene) const {
  RenderSettings settings = of_scene;
  settings.width = width_.value_or(settings.width);
  settings.height = height_.value_or(settings.height);
  settings.samples_per_pixel = samples_per_pixel_.value_or(settings.samples_per_pixel);
  settings.max_depth = max_depth_.value_or(settings.max_depth);
  settings.seed = seed_.value_or(settings.seed);
  settings.sampler = sampler_.value_or(settings.sampler);
  settings.precision = precision_.value_or(settings.precision);
  settings.accelerator = accelerator_.value_or(settings.accelerator);
  settings.isa = isa_.value_or(settings.isa);
  settings.schedule = schedule_.value_or(settings.schedule);
  settings.row_order = row_order_.value_or(settings.row_order);
  try {
    check_settings(settings);
  } catch (const InputError& error) {
    // Each option is in its range, so it is width and height together.
    throw InputError(std::string("--width, --height: ") + error.what());
  }
  return settings;
}

void OutputOptions::add_to(CLI::App& command, bool image_required) {
  image_option_ = command
                      .add_option("-o,--output", image_,
                                  "Picture to write: .exr (float, linear) or .png (8 bit, sRGB)")
                      ->type_name("IMAGE")
                      ->required(image_required);
  report_option_ =
      command.add_option("--report", report_, "Write what was done, how fast and with which bits")
          ->type_name("FILE.json");
  forbid_empty(*image_option_);
  forbid_empty(*report_option_);
}

void add_quiet(CLI::App& command, bool& quiet) {
  command.add_flag("-q,--quiet", quiet, "Show no progress");
}

void add_json(CLI::App& command, bool& as_json) {
  command.add_flag("--json", as_json, "Print JSON");
}

}  // namespace parray

#include "cli/commands/options.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cli/commands/setting_options.h"
#include "cli/input/select/expression.h"
#include "common/adaptive/passes.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/base/text.h"
#include "common/scene/limits.h"
#include "common/scene/settings_fields.h"

namespace parray::commands {
namespace {

/// Replaces the two characters \n by a new line, which is awkward to type in a shell.
std::string with_new_lines(const std::string& text) {
  std::string lines;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool escaped = text.compare(i, 2, "\\n") == 0;
    lines += escaped ? '\n' : text[i];
    i += escaped ? 1 : 0;
  }
  return lines;
}

/// Returns a function that declares the option of a setting under `heading`, or under its usual
/// heading if that is null. An option that is given sets the setting and adds its key to `given`.
auto declarer(Command& command, std::set<std::string_view>& given, const char* heading = nullptr) {
  return [&command, &given, heading](const Setting& setting, const auto& rule, auto& value) {
    if (setting.help == nullptr) return;
    const auto note = [&given, key = setting.key] { given.insert(key); };
    const char* const own = setting.is(traits::accuracy) ? limits_group
                            : setting.is(traits::speed)  ? work_group
                                                         : settings_group;
    Option option = add_setting(command, setting, rule, value, note);
    option.group(heading != nullptr ? heading : own);
    if (rarely_needed(setting)) option.special();
  };
}

}  // namespace

void describe_values(HiddenClasses /*rule*/, Option& option) {
  std::vector<std::string> classes(selection_classes().begin(), selection_classes().end());
  classes.emplace_back("none");
  option.words(classes, true);
}

bool value_of(OnOff /*rule*/, const std::string& text) {
  if (text == "on" || text == "off") return text == "on";
  throw InputError("'" + printable(text) + "' is neither on nor off");
}
std::vector<std::uint64_t> value_of(Passes /*rule*/, const std::string& text) {
  std::vector<std::uint64_t> numbers;
  for (const std::string_view part : split_at(',', text)) {
    numbers.push_back(whole_number(part, 1, std::numeric_limits<std::int64_t>::max()));
  }
  return numbers;
}
std::string value_of(LabelText rule, const std::string& text) {
  const std::string problem = problem_with_label_text(text, rule.longest);
  if (!problem.empty()) throw InputError(problem);
  return with_new_lines(text);
}

std::uint64_t whole_number(std::string_view text, std::uint64_t least, std::uint64_t most) {
  const std::optional<std::uint64_t> value = parsed_between(text, least, most);
  if (!value) {
    throw InputError("'" + printable(text) + "' is not a whole number from " +
                     std::to_string(least) + " to " + std::to_string(most));
  }
  return *value;
}

Option add_file(Command& command, const std::string& names, std::string& target,
                const std::string& description) {
  return command.option(names, target, description).completes(Completes::files).forbid_empty();
}

Option add_camera_path(Command& command, std::string& file) {
  return add_file(
             command, "--camera-path", file,
             "Cameras at some frames: {\"cameras\": [{\"frame\": N, ...}, ...]}. Each camera "
             "has the keys of a scene's camera. A smooth curve joins them. All frames must lie "
             "between the first and the last camera")
      .type_name("FILE.json");
}

Option add_priority(Command& command, std::uint32_t& priority) {
  return add_whole_number(
      command, "--priority", 0, 100, priority,
      "Among your jobs, those with a higher priority are rendered first (default: 50)");
}

Option add_threads(Command& command, std::optional<std::uint32_t>& threads) {
  return add_whole_number(command, "--threads", 1, most_threads, threads,
                          "Number of threads that trace (default: all available processors)");
}

void add_scene(Command& command, std::string& scene, const char* name) {
  add_file(command, name, scene,
           "Scene file (JSON), or a file of particles: PLY, CSV, XYZ, LAMMPS, PDB, PDBQT, PQR, "
           "GRO, SDF, MOL2, CIF, Tinker, POSCAR, GSD, DCD, XTC, TRR, AMBER NetCDF or AMBER "
           "restart. It may be compressed by gzip, bzip2, xz or zstd. - is the standard input")
      .required();
}

double real_number(std::string_view text, NumberRange range) {
  const std::optional<double> value = parsed_between(text, range.least, range.most);
  if (!value) {
    throw InputError("'" + printable(text) + "' is not a number from " + number_text(range.least) +
                     " to " + number_text(range.most));
  }
  return *value;
}

Option add_real_number(Command& command, const std::string& name, NumberRange range, double& target,
                       const std::string& description) {
  return command
      .option(
          name, [range, &target](const std::string& text) { target = real_number(text, range); },
          description)
      .type_name("X");
}

void add_job(Command& command, std::uint64_t& job) {
  add_whole_number(command, "JOB", 0, std::numeric_limits<std::uint64_t>::max(), job,
                   "Number of the job, as submit prints it")
      .required()
      .type_name("JOB")
      .completes(Completes::jobs)
      .only_once();
}

void RenderOptions::add_to(Command& command) {
  can_stop_ = true;
  settings_fields(declarer(command, keys_), *given_);
  add_looks_to(command);
  auto_scene_.add_background_to(command);
}

void RenderOptions::add_without_samples_to(Command& command) {
  picture_fields(declarer(command, keys_), *given_);
  work_fields(declarer(command, keys_), *given_);
  add_looks_to(command);
  auto_scene_.add_background_to(command);
}

void RenderOptions::add_looks_to(Command& command) {
  particles_.add_to(command);
  auto_scene_.add_to(command, particles_);
  command
      .on_off("--transparent", transparent_,
              "Make the background transparent. Alpha is the share of a pixel's camera rays that "
              "hit something, glass included (default: as the scene says, else off)")
      .group(output_group);
  command.renamed("--opaque", "--transparent off");
}

void RenderOptions::add_quality_to(Command& command) {
  std::vector<std::string> names;
  names.reserve(qualities.size());
  for (const Quality& quality : qualities) names.emplace_back(quality.name);
  command
      .option(
          "--quality",
          [this](const std::string& text) {
            std::array<std::string_view, qualities.size()> known{};
            std::ranges::transform(qualities, known.begin(), &Quality::name);
            quality_ = &qualities.at(known_place("quality", text, known));
          },
          "Size and error for a purpose. draft: half as wide and high, error 0.05, denoised; good: "
          "error 0.02; print: twice as wide and high, error 0.005. Other options win over it")
      .words(names)
      .type_name("NAME")
      .group(settings_group);
}

void RenderOptions::add_scene_to(Command& command) {
  add_looks_to(command);
  size_fields(declarer(command, keys_, particles_group), *given_);
}

void RenderOptions::add_like_to(Command& command) {
  add_file(command, "--like", like_,
           "Reproduce PICTURE bit for bit, using the settings stored in it. Excludes all other "
           "options under the headings Picture and Accuracy")
      .type_name("PICTURE")
      .group(settings_group);
  command_ = command;
}

std::string RenderOptions::as_given() const {
  std::string text;
  for (const GivenOption& given : command_->given_options()) {
    const bool decides = given.group == settings_group || given.group == limits_group ||
                         given.group == particles_group || given.group == labels_group;
    text += decides ? given.name + "=" + given.value + "\n" : "";
  }
  if (print_width_) text += "width in print=" + std::to_string(*print_width_) + "\n";
  return text;
}

void RenderOptions::check_like() const {
  if (like_.empty()) return;
  for (const GivenOption& given : command_->given_options()) {
    const bool decides = given.group == settings_group || given.group == limits_group;
    if (decides && given.name != "--like") {
      throw UsageError(given.name +
                       " and --like exclude each other: --like determines this setting, too");
    }
  }
}

void RenderOptions::follow(const RenderSettings& settings, bool transparent) {
  followed_ = settings;
  followed_transparent_ = transparent;
}

std::optional<Sampler> RenderOptions::sampler() const {
  return keys_.contains("sampler") ? std::optional(given_->sampler) : std::nullopt;
}

bool RenderOptions::says_when_to_stop() const {
  constexpr std::array<std::string_view, 5> stops{"samples_per_pixel", "target_error",
                                                  "target_half_width", "time_limit", "passes"};
  return std::ranges::any_of(stops, [this](std::string_view key) { return keys_.contains(key); });
}

Boxed<RenderSettings> RenderOptions::over(const RenderSettings& of_scene) const {
  RenderSettings settings = of_scene;
  if (quality_ != nullptr) {
    const auto sized = [this](std::uint32_t side) {
      return static_cast<std::uint32_t>(
          std::clamp<double>(std::round(side * quality_->size), 1, limits::max_image_side));
    };
    settings.width = sized(settings.width);
    settings.height = sized(settings.height);
    settings.target_error = quality_->error;
  }
  if (settings.target_error == 0) settings.target_error = usual_error_;
  if (says_when_to_stop()) settings.target_error = 0;
  if (print_width_ && !has_size()) {
    const double share = static_cast<double>(*print_width_) / settings.width;
    settings.height = static_cast<std::uint32_t>(
        std::clamp<double>(std::round(share * settings.height), 1, limits::max_image_side));
  }
  settings.width = print_width_.value_or(settings.width);
  settings_fields(
      [this](const Setting& setting, const auto& /*rule*/, auto& to, const auto& from) {
        if (keys_.contains(setting.key)) to = from;
      },
      settings, *given_);
  const bool limited =
      settings.target_error > 0 || settings.target_half_width > 0 || settings.time_limit > 0;
  if (!keys_.contains("adaptive")) settings.adaptive = limited || !settings.passes.empty();
  if (limited && !keys_.contains("samples_per_pixel")) {  // only the limit stops the render
    settings.samples_per_pixel = limits::max_samples_per_pixel;
  }
  if (followed_) {
    static_cast<PictureSettings&>(settings) = (*followed_)->picture();
    static_cast<StopSettings&>(settings) = (*followed_)->stop();
  }
  try {
    check_settings(settings);
  } catch (const InputError& error) {
    // Each option is in its range, so their combination is wrong.
    throw InputError(std::string(given_->passes.empty() ? "--width, --height: "
                                                        : "--width, --height, --passes: ") +
                     error.what());
  }
  if (const std::string problem = problem_with_first_passes(settings); !problem.empty()) {
    throw InputError("--passes: " + problem +
                     ": copy the numbers from `passes` of a report. They count the samples of all "
                     "pixels together (" +
                     std::to_string(pixel_count(settings)) + ": one per pixel)");
  }
  return settings;
}

void OutputOptions::add_to(Command& command, bool image_required) {
  image_option_ = add_file(
      command, "-o,--output", image_,
      "Picture to write: .exr (float, linear), or .png, .tif, .jpg or .jp2 (8 bits, sRGB)");
  image_option_.type_name("IMAGE").group(output_group).required(image_required);
  report_option_ = add_file(command, "--report", report_,
                            "Write a report as JSON: settings, samples, times, errors and hashes");
  report_option_.type_name("FILE.json").group(output_group);
}

void OutputOptions::add_aov_to(Command& command, bool scene) {
  const std::string traced =
      "depth, normal, albedo: means at the first hits of the pixel's first 16 samples; sphere: "
      "number of the sphere or capsule that its first sample hits; cost: mean number of ray "
      "segments of these 16 samples; ";
  std::vector<std::string> words = {"samples", "half-width"};
  if (scene) words.insert(words.begin(), {"depth", "normal", "albedo", "sphere", "cost"});
  command
      .option(
          "--aov", [this](const std::string& names) { aovs_ = aovs_from(names); },
          "Extra channels of an EXR picture, separated by commas. " + (scene ? traced : "") +
              "samples: samples per pixel; half-width: of the pixel's 95 % confidence interval")
      .words(words, true)
      .group(output_group)
      .needs(image_option_);
  add_file(command, "--error-map", error_map_,
           "Write a picture of the error: colours show the half-width of each pixel's 95 % "
           "confidence interval, with a legend")
      .type_name("FILE.png")
      .group(output_group)
      .needs(image_option_)
      .special();
}

void OutputOptions::add_denoise_to(Command& command, bool alone) {
  Option denoise =
      command.flag("--denoise", denoise_,
                   "Denoise the picture, and estimate its remaining RMSE. An EXR file also stores "
                   "the picture before denoising, in the channels raw.R, raw.G, raw.B");
  denoise.group(output_group);
  if (!alone) denoise.needs(image_option_);
}

void add_quiet(Command& command, bool& quiet) {
  command.flag("-q,--quiet", quiet, "Show no progress").group(output_group);
}

std::array<Option, 3> add_following(Command& command, ProgressOptions& following) {
  add_quiet(command, following.quiet);
  command
      .option("--progress", following.progress,
              "Form of the progress on stderr: a bar, lines for logs, or JSON lines for programs "
              "(default: a bar on a terminal, otherwise lines)")
      .group(output_group)
      .one_of({"bar", "lines", "json"})
      .special();
  Option preview = add_file(
      command, "--preview", following.preview,
      "Keep FILE updated with the unfinished picture. At the end it is a copy of the result");
  preview.type_name("FILE").group(output_group).special();
  Option display = command.option(
      "--display", following.display,
      "Show the unfinished picture in the viewer tev, or in another that uses its protocol. "
      "tev's port is 14158");
  display.type_name("HOST:PORT").group(output_group).forbid_empty().special();
  Option on_end = command.option(
      "--on-end", following.on_end,
      "Run this shell command when the job has ended, with PARRAY_JOB, PARRAY_STATE, "
      "PARRAY_REASON and PARRAY_IMAGE in its environment");
  on_end.type_name("COMMAND").group(output_group).forbid_empty().special();
  return {preview, display, on_end};
}

void add_json(Command& command, bool& as_json) {
  command.flag("--json", as_json, "Print JSON").group(output_group);
}

}  // namespace parray::commands

#include "cli/commands/options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "common/adaptive/passes.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/scene/limits.h"
#include "common/scene/scene_ranges.h"

namespace parray {
namespace {

std::uint64_t whole_number(const std::string& text, std::uint64_t least, std::uint64_t most) {
  std::uint64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || value < least || value > most) {
    throw InputError("'" + printable(text) + "' is not a whole number from " +
                     std::to_string(least) + " to " + std::to_string(most));
  }
  return value;
}

/// Numbers with commas between them.
std::vector<std::uint64_t> whole_numbers(const std::string& text) {
  std::vector<std::uint64_t> numbers;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    numbers.push_back(
        whole_number(text.substr(begin, end - begin), 1, std::numeric_limits<std::int64_t>::max()));
    begin = end + 1;
  }
  return numbers;
}

/// An option with a few known words. `read` throws InputError for any other.
template <typename Value>
Option add_choice(Command& command, const std::string& name, const std::vector<std::string>& words,
                  Value (*read)(std::string_view), std::optional<Value>& target,
                  const std::string& description, const std::string& group) {
  return command
      .option(
          name, [read, &target](const std::string& text) { target = read(text); }, description)
      .words(words)
      .group(group);
}

}  // namespace

Option add_whole_number(Command& command, const std::string& names, std::uint64_t least,
                        std::uint64_t most, std::function<void(std::uint64_t)> set,
                        const std::string& description) {
  return command
      .option(
          names,
          [least, most, set = std::move(set)](const std::string& text) {
            set(whole_number(text, least, most));
          },
          description)
      .type_name("N");
}

void add_scene(Command& command, std::string& scene, const char* name) {
  command
      .option(
          name, scene,
          "Scene file (JSON), or a file of particles: PLY, CSV, XYZ, LAMMPS, PDB, PDBQT, PQR, "
          "GRO, SDF, MOL2, CIF, DCD, XTC, TRR or AMBER NetCDF, also packed by gzip, bzip2, xz or "
          "zstd; - is the standard input")
      .required()
      .completes(Completes::files)
      .forbid_empty();
}

double real_number(const std::string& text, NumberRange range) {
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || !(value >= range.least && value <= range.most)) {
    throw InputError("'" + printable(text) + "' is not a number from " + number_text(range.least) +
                     " to " + number_text(range.most));
  }
  return value;
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
  add_whole_number(
      command, "JOB", 0, std::numeric_limits<std::uint64_t>::max(),
      [&job](std::uint64_t value) { job = value; }, "Number of the job, as submit prints it")
      .required()
      .type_name("JOB")
      .completes(Completes::jobs)
      .only_once();
}

void RenderOptions::add_to(Command& command) {
  add_picture_to(command);
  add_whole_number(
      command, "--spp", 1, limits::max_samples_per_pixel,
      [this](std::uint64_t value) { samples_per_pixel_ = static_cast<std::uint32_t>(value); },
      "Samples per pixel: four times as many take four times as long and halve the noise")
      .group(settings_group);
  add_limits_to(command);
  add_work_to(command);
  particles_.add_to(command);
  portrait_.add_to(command);
  view_.add_to(command);
}

/// An option whose value is a whole number from 1 to `most`.
static Option add_count(Command& command, const char* name, std::uint32_t most,
                        std::optional<std::uint32_t>& target, const char* description) {
  return add_whole_number(
      command, name, 1, most,
      [&target](std::uint64_t value) { target = static_cast<std::uint32_t>(value); }, description);
}

void RenderOptions::add_size_to(Command& command, const std::string& group) {
  add_count(command, "--width", limits::max_image_side, width_, "Pixels across").group(group);
  add_count(command, "--height", limits::max_image_side, height_, "Pixels down").group(group);
}

void RenderOptions::add_without_samples_to(Command& command) {
  add_picture_to(command);
  add_work_to(command);
  particles_.add_to(command);
  portrait_.add_to(command);
  view_.add_to(command);
}

void RenderOptions::add_picture_to(Command& command) {
  add_size_to(command, settings_group);
  add_count(command, "--max-depth", limits::max_depth, max_depth_, "Longest path, in ray segments")
      .group(settings_group);
  add_whole_number(
      command, "--seed", 0, std::numeric_limits<std::uint64_t>::max(),
      [this](std::uint64_t value) { seed_ = value; }, "Another seed gives other noise")
      .group(settings_group);
  add_choice(command, "--sampler", {"independent", "sobol"}, sampler_from, sampler_,
             "Random numbers of a pixel's samples: independent of each other, or evenly spread "
             "(Owen-scrambled Sobol)",
             settings_group);
  add_choice(
      command, "--precision", {"auto", "f32", "mixed", "f64"}, precision_from, precision_,
      "Arithmetic of the tracing; auto goes by the scene's sizes; mixed: spheres stored in 32 "
      "bits, computed with in 64",
      settings_group);
}

void RenderOptions::add_work_to(Command& command) {
  add_choice(
      command, "--accelerator", {"auto", "linear", "bvh", "octree"}, accelerator_from, accelerator_,
      "How spheres are searched; octree is a slow historical method, for comparison", work_group)
      .special();
  add_choice(command, "--isa", {"auto", "scalar", "avx2", "avx512", "neon"}, isa_from, isa_,
             "Instruction set to trace with; auto: the best that a machine has", work_group)
      .special();
  add_choice(command, "--schedule", {"static", "guided", "factoring", "weighted"}, schedule_from,
             schedule_, "How rows are dealt out to workers (default: weighted)", work_group)
      .special();
  add_choice(command, "--row-order", {"auto", "sequential", "interleaved"}, row_order_from,
             row_order_, "In which order rows are dealt out; auto: interleaved with weighted",
             work_group)
      .special();
}

void RenderOptions::add_limits_to(Command& command) {
  const auto limit = [&](const char* name, NumberRange range, double& target,
                         const char* description) {
    add_real_number(command, name, range, target, description).group(limits_group);
  };
  limit("--target-error", ranges::target_error, target_error_,
        "Stop when the estimated RMSE of the picture, denoised or not, is at most X, in linear "
        "radiance");
  limit("--target-half-width", ranges::target_error, target_half_width_,
        "Stop when 99 % of all pixel values (each channel) are known to within +-X, with 95 % "
        "confidence");
  limit("--time-limit", ranges::time_limit, time_limit_,
        "The best picture that X seconds allow, from start to end, writing included; the report's "
        "`passes` repeat it");
  command
      .on_off("--adaptive", adaptive_,
              "More samples where there is more noise (default: on with one of the limits above, "
              "off without)")
      .group(limits_group);
  command
      .option(
          "--passes", [this](const std::string& text) { passes_ = whole_numbers(text); },
          "Repeat a time-limited render: the list `passes` from its report")
      .type_name("N,N...")
      .special()
      .group(limits_group);
}

void RenderOptions::add_like_to(Command& command) {
  command
      .option("--like", like_,
              "Reproduce PICTURE bit for bit, using the settings stored in it. Excludes all other "
              "options of this group and the next")
      .type_name("PICTURE")
      .completes(Completes::files)
      .group(settings_group)
      .forbid_empty();
  command_ = command;
}

std::string RenderOptions::as_given() const {
  std::string text;
  for (const GivenOption& given : command_->given_options()) {
    const bool decides = given.group == settings_group || given.group == limits_group ||
                         given.group == particles_group;
    text += decides ? given.name + "=" + given.value + "\n" : "";
  }
  return text;
}

void RenderOptions::check_like() const {
  if (like_.empty()) return;
  for (const GivenOption& given : command_->given_options()) {
    const bool decides = given.group == settings_group || given.group == limits_group;
    if (decides && given.name != "--like") {
      throw UsageError(given.name + " and --like, which decides it, too: leave one of them out");
    }
  }
}

/// A limit without --spp goes as far as it has to.
void RenderOptions::lay_limits_over(RenderSettings& settings) const {
  settings.target_error = target_error_;
  settings.target_half_width = target_half_width_;
  settings.time_limit = time_limit_;
  settings.passes = passes_;
  const bool limited = target_error_ > 0 || target_half_width_ > 0 || time_limit_ > 0;
  settings.adaptive = adaptive_.value_or(limited || !passes_.empty());
  if (limited && !samples_per_pixel_) {
    settings.samples_per_pixel = limits::max_samples_per_pixel;
  }
}

/// Passes of less than two samples a pixel, as they are made up by hand, are no picture's.
static void check_first_passes(const RenderSettings& settings) {
  const std::uint64_t pixels = std::uint64_t{settings.width} * settings.height;
  std::uint64_t traced = 0;
  for (const std::uint64_t samples : settings.passes) {
    if (traced + samples >= 2 * pixels) return;
    std::uint64_t whole = (traced + samples) % pixels == 0 ? samples : 0;
    for (const Stage& stage : lattices_of_pass(settings.width, settings.height, traced, samples)) {
      whole += whole == samples ? 0 : stage.lattice.pixels(settings.width, settings.height);
    }
    if (whole != samples) {
      throw InputError("--passes: no picture of " + std::to_string(settings.width) + " x " +
                       std::to_string(settings.height) + " pixels has a pass of " +
                       std::to_string(samples) + " samples after " + std::to_string(traced) +
                       ": give samples of all pixels together, as a report's passes has them (" +
                       std::to_string(pixels) + ": one of each pixel)");
    }
    traced += samples;
  }
}

RenderSettings RenderOptions::over(const RenderSettings& of_scene) const {
  RenderSettings settings = of_scene;
  if (print_width_ && !width_ && !height_) {
    const double share = static_cast<double>(*print_width_) / settings.width;
    settings.height = static_cast<std::uint32_t>(
        std::clamp<double>(std::round(share * settings.height), 1, limits::max_image_side));
  }
  settings.width = width_.value_or(print_width_.value_or(settings.width));
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
  lay_limits_over(settings);
  if (followed_) {
    static_cast<PictureSettings&>(settings) = followed_->picture();
    static_cast<StopSettings&>(settings) = followed_->stop();
  }
  try {
    check_settings(settings);
  } catch (const InputError& error) {
    // Each option is in its range, so it is some of them together.
    throw InputError(
        std::string(passes_.empty() ? "--width, --height: " : "--width, --height, --passes: ") +
        error.what());
  }
  check_first_passes(settings);
  return settings;
}

void OutputOptions::add_to(Command& command, bool image_required) {
  image_option_ =
      command
          .option(
              "-o,--output", image_,
              "Picture to write: .exr (float, linear), or .png, .tif, .jpg or .jp2 (8 bit, sRGB)")
          .type_name("IMAGE")
          .completes(Completes::files)
          .group(output_group)
          .required(image_required);
  report_option_ =
      command.option("--report", report_, "Write what was done, how fast and with which bits")
          .type_name("FILE.json")
          .completes(Completes::files)
          .group(output_group);
  image_option_.forbid_empty();
  report_option_.forbid_empty();
}

void OutputOptions::add_aov_to(Command& command) {
  command
      .option(
          "--aov", [this](const std::string& names) { aovs_ = aovs_from(names); },
          "Extra channels of an EXR picture, separated by commas: depth, normal, albedo and sphere "
          "of what is first seen; cost in ray segments a sample; samples of each pixel; half-width "
          "of its 95 % interval")
      .words({"depth", "normal", "albedo", "sphere", "cost", "samples", "half-width"}, true)
      .group(output_group)
      .needs(image_option_);
  command
      .option("--error-map", error_map_,
              "Where the error is: the half-width of each pixel's 95 % interval as colours, with a "
              "legend")
      .type_name("FILE.png")
      .completes(Completes::files)
      .group(output_group)
      .forbid_empty()
      .needs(image_option_);
}

void OutputOptions::add_denoise_to(Command& command) {
  command
      .flag("--denoise", denoise_,
            "Denoise the picture, and state the remaining error; an EXR file keeps the picture as "
            "traced in channels raw.R, raw.G, raw.B")
      .group(output_group)
      .needs(image_option_);
}

void add_quiet(Command& command, bool& quiet) {
  command.flag("-q,--quiet", quiet, "Show no progress").group(output_group);
}

void add_following(Command& command, ProgressOptions& following) {
  add_quiet(command, following.quiet);
  command
      .option("--progress", following.progress,
              "How progress is shown on stderr: a bar, lines for logs, or JSON lines for programs "
              "(default: what suits stderr)")
      .group(output_group)
      .one_of({"bar", "lines", "json"});
  command
      .option(
          "--preview", following.preview,
          "Keep FILE updated with the unfinished picture; at the end it is a copy of the result")
      .type_name("FILE")
      .completes(Completes::files)
      .group(output_group)
      .forbid_empty();
  command
      .option(
          "--display", following.display,
          "Show the picture as it grows in the viewer tev, or another that speaks its protocol; "
          "tev's port is 14158")
      .type_name("HOST:PORT")
      .group(output_group)
      .forbid_empty();
  command
      .option("--on-end", following.on_end,
              "Run this by the shell when the job has ended, with PARRAY_JOB, PARRAY_STATE, "
              "PARRAY_REASON and PARRAY_IMAGE in its environment")
      .type_name("COMMAND")
      .group(output_group)
      .forbid_empty();
}

void add_json(Command& command, bool& as_json) {
  command.flag("--json", as_json, "Print JSON").group(output_group);
}

}  // namespace parray

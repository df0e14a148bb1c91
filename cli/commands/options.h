#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "cli/commands/finishing_options.h"
#include "cli/commands/particle_options.h"
#include "cli/output/preview.h"
#include "cli/output/write_outputs.h"
#include "common/process/command_line.h"
#include "common/scene/limits.h"
#include "common/scene/setting_choices.h"
#include "common/scene/settings_fwd.h"

/// Options that several commands share. A wrong value ends the parsing with a UsageError that names
/// the option, before any work. The objects keep the values; they must not move while the command
/// line is parsed.
namespace parray::commands {

/// Parses a whole number from `least` to `most` in plain decimal digits. Throws InputError for
/// other texts. (CLI11 itself reads -1 as 18446744073709551615 and 010 as 8.)
std::uint64_t whole_number(std::string_view text, std::uint64_t least, std::uint64_t most);

/// Declares an option whose value is a whole_number(). If the option is repeated, the last value
/// counts. `target`: an integer, or an optional one.
template <typename Target>
Option add_whole_number(Command& command, const std::string& names, std::uint64_t least,
                        std::uint64_t most, Target& target, const std::string& description) {
  const auto set = [least, most, &target](const std::string& text) {
    const std::uint64_t number = whole_number(text, least, most);
    if constexpr (std::is_integral_v<Target>) {
      target = static_cast<Target>(number);
    } else {
      target = static_cast<typename Target::value_type>(number);
    }
  };
  return command.option(names, set, description).type_name("N");
}

/// The largest number of threads of a command or a rank. PROTOCOL.md has the same limit for
/// workers.
inline constexpr std::uint32_t most_threads = 4096;

/// Declares an option whose value is the name of a file.
Option add_file(Command& command, const std::string& names, std::string& target,
                const std::string& description);

/// Declares --camera-path, whose value is the name of a file.
Option add_camera_path(Command& command, std::string& file);

/// Declares --priority, the priority of a job.
Option add_priority(Command& command, std::uint32_t& priority);

/// Declares --threads, the number of threads that trace.
Option add_threads(Command& command, std::optional<std::uint32_t>& threads);

/// Declares the argument for the scene: a scene file or a file of particles.
void add_scene(Command& command, std::string& scene, const char* name = "SCENE");

/// Parses a finite number in `range`. The ends of the range are allowed. Throws InputError for
/// other texts.
double real_number(std::string_view text, NumberRange range);

/// Declares an option whose value is a finite number in `range`.
Option add_real_number(Command& command, const std::string& name, NumberRange range, double& target,
                       const std::string& description);

/// Declares the argument for the number of a job, as `submit` prints it.
void add_job(Command& command, std::uint64_t& job);

/// Heading in a command's help for options that determine the picture.
inline constexpr const char* settings_group = "Picture (default: the scene's)";
/// Heading for limits of the tracing.
inline constexpr const char* limits_group =
    "Accuracy (rendering stops at the first limit that is reached)";
/// Heading for options that change how fast samples are traced, but not their values.
inline constexpr const char* work_group = "Speed (the same samples give the same picture)";
inline constexpr const char* output_group = "Output";
/// Heading for postprocessing.
inline constexpr const char* postprocess_group =
    "Postprocessing, not in EXR files (default: the scene's)";
inline constexpr const char* farm_group = "Farm";
/// Heading for options that need a file of particles.
inline constexpr const char* particles_group = "For files of particles";

/// A size and an error for a purpose, of --quality.
struct Quality {
  std::string_view name;
  double size;           ///< width and height relative to those of the scene
  double error;          ///< target error: RMSE in linear radiance
  bool denoise = false;  ///< denoise the picture if the command can do that
};
inline constexpr std::array<Quality, 3> qualities{
    {{"draft", 0.5, 0.05, true}, {"good", 1, 0.02}, {"print", 2, 0.005}}};

/// How a scene is rendered. An option that is absent leaves the scene's value, except as over()
/// says.
class RenderOptions {
 public:
  /// Declares all options except --quality and --like.
  void add_to(Command& command);
  /// Declares only the options that decide an automatic scene and can be stored in a scene file,
  /// except those for labels: without --background.
  void add_scene_to(Command& command);
  /// Sets the width in pixels that follows from the size in print; empty: none follows. over() uses
  /// this width if --width is absent. If --height is absent, too, over() scales the height in
  /// proportion.
  void print_width(std::optional<std::uint32_t> width) { print_width_ = width; }
  /// Declares the options of add_to() except those that say when a render stops, such as --spp and
  /// --target-error: for commands that choose them.
  void add_without_samples_to(Command& command);
  /// Declares --quality, for commands that render.
  void add_quality_to(Command& command);
  /// Returns the quality that is given. Null: none.
  [[nodiscard]] const Quality* quality() const { return quality_; }
  /// Returns whether the command has options that say when a render stops: add_to() was called.
  [[nodiscard]] bool can_stop() const { return can_stop_; }
  /// Returns whether an option gives the target error.
  [[nodiscard]] bool has_target_error() const { return keys_.contains("target_error"); }
  /// Makes over() use this target error if neither the scene nor --quality has one, and no option
  /// says when to stop. The number of samples in a scene file then does not count.
  void aim_at(double error) { usual_error_ = error; }
  /// Declares --like, after add_to(), for commands that render.
  void add_like_to(Command& command);
  /// Returns the picture of --like. Empty: none.
  [[nodiscard]] const std::string& like() const { return like_; }
  /// Throws UsageError if --like is given with another option under settings_group or limits_group.
  /// Call while the command line exists.
  void check_like() const;
  /// Makes over() and transparent() take everything that determines the picture from these values
  /// instead of from the scene.
  void follow(const RenderSettings& settings, bool transparent);
  [[nodiscard]] const ParticleOptions& particles() const { return particles_; }
  [[nodiscard]] const AutoSceneOptions& auto_scene() const { return auto_scene_; }
  [[nodiscard]] AutoSceneOptions& auto_scene() { return auto_scene_; }
  /// Returns whether the background is transparent: the value of --transparent, else that of
  /// follow(), else `of_scene`, the scene's value.
  [[nodiscard]] bool transparent(bool of_scene) const {
    return transparent_.value_or(followed_ ? followed_transparent_ : of_scene);
  }
  /// Returns the sampler of --sampler. Empty: the scene's.
  [[nodiscard]] std::optional<Sampler> sampler() const;

  /// Returns the options that the user gave under settings_group, limits_group, particles_group and
  /// labels_group (an automatic camera makes room for labels), and the width of print_width(), as a
  /// text. Two commands with the same such options have equal texts, if those under particles_group
  /// have the same order. Call after add_like_to(), while the command line exists.
  [[nodiscard]] std::string as_given() const;
  /// Returns the scene's settings, replaced by the options that are given. With a target or a time
  /// limit and without --spp, samples_per_pixel is the largest possible number, so that it does not
  /// end the render. An option that says when to stop replaces the target error of `of_scene` and
  /// --quality. Without --adaptive, the picture is adaptive if it has a target, a time limit or a
  /// list of passes. Throws InputError, which names the options, if the result is impossible.
  [[nodiscard]] Boxed<RenderSettings> over(const RenderSettings& of_scene) const;

 private:
  void add_looks_to(Command& command);
  [[nodiscard]] bool has_size() const {
    return keys_.contains("width") || keys_.contains("height");
  }
  [[nodiscard]] bool says_when_to_stop() const;

  std::string like_;
  std::optional<Command> command_;  ///< the command that has --like
  std::optional<bool> transparent_;
  std::optional<Boxed<RenderSettings>> followed_;
  bool followed_transparent_ = false;
  std::optional<std::uint32_t> print_width_;
  Boxed<RenderSettings> given_;
  std::set<std::string_view> keys_;  ///< keys of the given settings
  const Quality* quality_ = nullptr;
  bool can_stop_ = false;
  double usual_error_ = 0;  ///< 0: none
  ParticleOptions particles_;
  AutoSceneOptions auto_scene_;
};

/// The options for output files and for changes to the picture after tracing.
class OutputOptions {
 public:
  /// Declares -o and --report. `image_required`: the command needs -o.
  void add_to(Command& command, bool image_required);
  /// Declares --aov and --error-map, for commands that have the statistics of a picture. `scene`:
  /// the command has the scene, too, and so offers the channels that are traced from it.
  void add_aov_to(Command& command, bool scene = true);
  /// Declares --denoise, for commands that also have the scene. `alone`: it is allowed without -o.
  void add_denoise_to(Command& command, bool alone = false);
  /// Declares postprocessing and labels, for commands that have the scene.
  void add_labels_to(Command& command, RenderOptions& render) {
    postprocessing_.add_to(command, &image_option_);
    labels_.add_to(command, &image_option_, render);
  }
  [[nodiscard]] const PostprocessOptions& postprocessing() const { return postprocessing_; }
  [[nodiscard]] const LabelOptions& labels() const { return labels_; }
  /// Return the options -o and --report, so that a command can make them need another option.
  [[nodiscard]] Option image_option() const { return image_option_; }
  [[nodiscard]] Option report_option() const { return report_option_; }

  /// Returns the output files, including the preview of `following`.
  [[nodiscard]] OutputPaths paths(const ProgressOptions& following = {}) const {
    return {.image = image_,
            .report = report_,
            .aovs = aovs_,
            .denoise = denoise_,
            .error_map = error_map_,
            .preview = following.preview};
  }

 private:
  std::string image_;
  std::string report_;
  Aovs aovs_;
  bool denoise_ = false;
  std::string error_map_;
  PostprocessOptions postprocessing_;
  LabelOptions labels_;
  Option image_option_;
  Option report_option_;
};

/// Declares --quiet.
void add_quiet(Command& command, bool& quiet);
/// Declares --quiet, --progress, --preview, --display and --on-end. Returns the last three, in this
/// order.
std::array<Option, 3> add_following(Command& command, ProgressOptions& following);
/// Declares --json.
void add_json(Command& command, bool& as_json);

}  // namespace parray::commands

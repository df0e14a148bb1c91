#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "cli/commands/auto_scene_options.h"
#include "cli/commands/finish_options.h"
#include "cli/commands/label_options.h"
#include "cli/commands/particle_options.h"
#include "cli/commands/view_options.h"
#include "cli/output/preview.h"
#include "cli/output/write_outputs.h"
#include "common/process/command_line.h"
#include "common/scene/number_range.h"
#include "common/scene/settings.h"

/// Options that several commands share, declared once. What an option cannot take ends the parsing
/// with a UsageError, which names it, before any work is done. The objects keep what was
/// given; they must stay where they are while the command line is parsed.
namespace parray::commands {

/// An option whose value is a whole number from `least` to `most`, in plain decimal digits. (The
/// library's own reading of numbers takes -1 for 18446744073709551615 and 010 for 8.) Given twice,
/// the last counts, so that a script can lay its own values over others.
Option add_whole_number(Command& command, const std::string& names, std::uint64_t least,
                        std::uint64_t most, std::function<void(std::uint64_t)> set,
                        const std::string& description);

/// The scene to work on: a scene file or a file of particles.
void add_scene(Command& command, std::string& scene, const char* name = "SCENE");

/// The finite number that `text` is, in `range`. Throws InputError.
double real_number(std::string_view text, NumberRange range);

/// An option whose value is a finite number in `range`.
Option add_real_number(Command& command, const std::string& name, NumberRange range, double& target,
                       const std::string& description);

/// The number of a job, as `submit` prints it.
void add_job(Command& command, std::uint64_t& job);

/// Headings, in a command's help. Of options that decide the picture:
inline constexpr const char* settings_group = "Picture (default: the scene's)";
/// Of those that say when it is good enough.
inline constexpr const char* limits_group = "Accuracy (whichever is reached first ends it)";
/// Of those that change how the work is done but not the picture.
inline constexpr const char* work_group = "Speed (never changes the picture)";
inline constexpr const char* output_group = "Output";
/// Of those that say what is done to a picture after it was traced.
inline constexpr const char* finish_group = "Finishing, of a PNG picture (default: the scene's)";
inline constexpr const char* farm_group = "Farm";
/// Of those that say what is shown of a file of particles.
inline constexpr const char* particles_group = "When it is a file of particles";

/// How a scene is rendered. What is not given stays as the scene has it.
class RenderOptions {
 public:
  void add_to(Command& command);
  /// --width and --height alone, under that heading.
  void add_size_to(Command& command, const std::string& group);
  [[nodiscard]] bool has_size() const {
    return keys_.contains("width") || keys_.contains("height");
  }
  /// The picture's width where --width is not given, its height in proportion where --height is
  /// not.
  void print_width(std::optional<std::uint32_t> width) { print_width_ = width; }
  /// All but how many samples to take: for a command that finds out.
  void add_without_samples_to(Command& command);
  /// --like, after add_to(): for commands that render.
  void add_like_to(Command& command);
  /// The picture of --like; empty: none.
  [[nodiscard]] const std::string& like() const { return like_; }
  /// Throws UsageError where --like stands beside an option that decides the picture. Only as long
  /// as the command line is there.
  void check_like() const;
  /// over() takes all that decides the picture from these settings instead of the scene's, and
  /// view() whether it is transparent.
  void follow(const RenderSettings& settings, bool transparent) {
    followed_ = settings;
    view_.follow(transparent);
  }
  [[nodiscard]] const ParticleOptions& particles() const { return particles_; }
  [[nodiscard]] const ViewOptions& view() const { return view_; }
  [[nodiscard]] const AutoSceneOptions& auto_scene() const { return auto_scene_; }
  [[nodiscard]] AutoSceneOptions& auto_scene() { return auto_scene_; }
  /// Empty: the scene's.
  [[nodiscard]] std::optional<Sampler> sampler() const {
    return keys_.contains("sampler") ? std::optional(given_.sampler) : std::nullopt;
  }

  /// Those that decide the picture, as they were given: equal for equal commands.
  [[nodiscard]] std::string as_given() const;
  /// The scene's settings with the options laid over them. Throws InputError, naming the options,
  /// when the whole is not possible.
  [[nodiscard]] RenderSettings over(const RenderSettings& of_scene) const;

 private:
  void add_looks_to(Command& command);

  ViewOptions view_;
  std::string like_;
  std::optional<Command> command_;  ///< that has --like
  std::optional<RenderSettings> followed_;
  std::optional<std::uint32_t> print_width_;
  RenderSettings given_;
  std::set<std::string_view> keys_;  ///< of the settings that were given
  ParticleOptions particles_;
  AutoSceneOptions auto_scene_;
};

/// Where the picture and the report go, and whether progress is shown.
class OutputOptions {
 public:
  /// `image_required`: without -o the command makes no sense.
  void add_to(Command& command, bool image_required);
  /// --aov and --error-map, for commands that have a picture's statistics at hand.
  void add_aov_to(Command& command);
  /// --denoise, for those that have the scene, too.
  void add_denoise_to(Command& command);
  /// What is done to the picture and drawn on it, for those that have the scene.
  void add_labels_to(Command& command, RenderOptions& render) {
    finish_.add_to(command, image_option_);
    labels_.add_to(command, image_option_, render);
  }
  [[nodiscard]] const FinishOptions& finish() const { return finish_; }
  [[nodiscard]] const LabelOptions& labels() const { return labels_; }
  /// -o and --report; for commands that need another option to make them meaningful.
  [[nodiscard]] Option image_option() const { return image_option_; }
  [[nodiscard]] Option report_option() const { return report_option_; }

  /// With the preview of `following`.
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
  FinishOptions finish_;
  LabelOptions labels_;
  Option image_option_;
  Option report_option_;
};

void add_quiet(Command& command, bool& quiet);
/// --quiet, --progress, --preview, --display and --on-end: what is shown of a job until it has
/// ended, and done then.
void add_following(Command& command, ProgressOptions& following);
void add_json(Command& command, bool& as_json);

}  // namespace parray::commands

#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/input/scene_file/particle_source.h"
#include "cli/input/scene_file/scene_file.h"
#include "cli/input/view/surroundings.h"
#include "common/process/command_line.h"

/// The options for files of particles.
namespace parray::commands {

/// Options that select, colour and scale the particles of a file.
class ParticleOptions {
 public:
  /// Declares the options. The object must not move while the command line is parsed.
  void add_to(Command& command);
  /// Sets the style of the particles or, after --show, that of the last representation.
  void set_style(ParticleStyle style) { given_.look.style = style; }
  /// Call for a scene that is not a particle file. Throws InputError if any of the options is
  /// given. `file`: the scene's name in the message.
  void check_unused(const std::string& file) const;
  /// Returns the source that the options describe, without a file. Throws InputError if options
  /// exclude each other.
  [[nodiscard]] ParticleSource source() const;
  /// Returns the file of --topology. Empty: none.
  [[nodiscard]] const std::string& topology() const { return given_.topology; }

 private:
  void begin_representation(const std::string& select);

  ParticleSource given_;                ///< its look collects the options after the last --show
  ParticleLook base_;                   ///< the options before the first --show
  std::vector<std::string_view> keys_;  ///< keys of the options given
};

/// Returns all words that --view accepts: names of views and of axes.
std::vector<std::string> view_words();

/// The options for view, style, camera and background of an automatic scene: the scene that ParRay
/// makes from a particle file. Part of RenderOptions.
class AutoSceneOptions {
 public:
  /// Declares all options except --background. The object must not move while the command line is
  /// parsed. --style also sets the style of `particles`. Ends the section of `command`: see
  /// Command::section().
  void add_to(Command& command, ParticleOptions& particles);
  /// Declares --background, for commands that make pictures.
  void add_background_to(Command& command);
  /// Call for a scene that is not a particle file. Throws InputError if any of the options is
  /// given, --background included. `file`: the scene's name in the message.
  void check_unused(const std::string& file) const;
  /// Returns view, style and camera as the options say. Throws InputError if options exclude each
  /// other.
  [[nodiscard]] Viewing viewing() const;
  /// Returns the colour of the background in linear RGB. Not given: that of the style.
  [[nodiscard]] const std::optional<Vec3d>& background() const { return background_; }

  /// Returns whether --view is given, or look_from() was called.
  [[nodiscard]] bool has_view() const { return view_.has_value(); }
  /// Sets the view, as --view does.
  void look_from(View view) { view_ = view; }
  /// Parses a word of view_words(), but does not set the view. If the word is an axis, viewing()
  /// does not allow --up. Throws InputError for another word.
  View named_view(std::string_view name);
  /// Keeps a reference to `wanted`, which must outlive this object. viewing() reads there whether
  /// the picture must contain the whole cell of the particles (the periodic box of a simulation).
  void frame_cell(const bool& wanted) { whole_cell_ = &wanted; }
  /// Sets a function that returns which places labels cover (Viewing::labels). The camera keeps the
  /// particles of the scene away from these places.
  void keep_free(std::function<LabelPlaces(const SceneFile&)> labels) {
    labels_ = std::move(labels);
  }

 private:
  void add_style_to(Command& command, ParticleOptions& particles);
  void add_camera_to(Command& command);

  std::optional<View> view_;
  bool names_axis_ = false;  ///< a view is named by an axis
  std::optional<Style> style_;
  bool styles_particles_ = false;
  std::optional<Projection> projection_;
  Turning turning_;
  std::optional<double> zoom_;
  std::optional<Vec3d> background_;
  std::function<LabelPlaces(const SceneFile&)> labels_;
  const bool* whole_cell_ = nullptr;
};

}  // namespace parray::commands

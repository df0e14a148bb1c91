#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/commands/loading.h"
#include "cli/commands/options.h"
#include "cli/input/particles/fixed_looks.h"
#include "cli/input/particles/selected_particles.h"
#include "cli/input/scene_file/camera_path.h"
#include "cli/input/scene_file/scene_file.h"
#include "cli/input/view/surroundings.h"
#include "cli/input/view/view.h"
#include "cli/output/frame_names.h"

/// The scenes of the frames of films and series.
namespace parray::commands {

/// Loads the scenes of the frames of a film, or of a series by HTTP. The frames are those of a
/// trajectory (a file of particles, or named by a scene file), or numbered files (#### in the
/// name), or all show the same scene (a still). The number of a frame is its place in the
/// trajectory, from 0, or the number in the name of its file. Each numbered scene file keeps its
/// own camera, colours and radii. All other frames have one camera, and a colour or a radius means
/// the same in all frames that fix() reads. All functions that read files throw InputError.
class FrameScenes {
 public:
  /// `options` must outlive this object. `first`: number of the first frame, if the files are
  /// numbered.
  FrameScenes(std::string file, const RenderOptions& options, NamedFiles named,
              std::uint32_t first = 0);

  /// Returns whether all frames are equal: the file is not numbered, and either there is no
  /// trajectory, or the scene or the option --frame chooses one of its frames.
  [[nodiscard]] bool is_still() const;
  /// Returns whether the file is a scene file. ParRay does not choose the camera of such a file.
  [[nodiscard]] bool is_scene() const { return is_scene_; }
  /// Counts the frames of the trajectory. Throws InputError if the scene names no trajectory, or
  /// chooses a frame itself.
  [[nodiscard]] std::uint64_t count() const;
  /// Gives the frames one camera, and their colours and radii the same meaning. Numbered scene
  /// files stay as they are. Call it before at(): otherwise at() calls it for its frame only.
  /// `frames`: their numbers, at least one. `turns`: the camera will turn around an automatic
  /// scene. `still`: all frames show the same scene, and `frames` does not matter.
  ///
  /// Reads each frame if there are several, or if an automatic scene turns. Reads several frames of
  /// automatic scenes a second time if the common ranges of radii or lengths may change the sizes
  /// of shapes. A series by HTTP passes only its first frame: then all frames have the camera of
  /// this frame, but each has its own ranges of colours and radii.
  void fix(const std::vector<std::uint32_t>& frames, bool turns = false, bool still = false);
  /// A function of the number of frames that fix() has read and of the number that it will read in
  /// all. Frames that are read twice count twice.
  using OnRead = std::function<void(std::size_t read, std::size_t all)>;
  /// Sets a function that fix() calls after each frame that it reads.
  void report_reading(OnRead on_read) { on_read_ = std::move(on_read); }
  /// Returns the scene of a frame. Ascending frames are fastest.
  SceneFile at(std::uint32_t frame);
  /// Returns the axis of a turntable, after fix(). Numbered scene files have none.
  [[nodiscard]] TurnAxis axis() const { return axis_; }
  /// Returns all files that determine the frames. The caller can check whether they change.
  [[nodiscard]] std::vector<std::string> files(const std::vector<std::uint32_t>& frames) const;

  [[nodiscard]] const std::string& file() const { return file_; }

 private:
  [[nodiscard]] std::string file_of(std::uint32_t frame) const;
  [[nodiscard]] ParticleSource given_source() const;
  void fix_scene(const std::vector<std::uint32_t>& frames);
  void fix_particles(const std::vector<std::uint32_t>& frames, bool turns);
  SceneFile with_particles(std::uint32_t frame);
  /// Does the same as with_particles(). Errors name the frame.
  SceneFile read(std::uint32_t frame);
  /// Reads the frames, calls `on_scene` for each, and makes `viewing` include all of them.
  void include_all(const std::vector<std::uint32_t>& frames, Viewing& viewing,
                   const std::function<void(const SceneFile&)>& on_scene);
  void note_read(std::size_t all);

  const std::string file_;
  const RenderOptions& options_;
  const NamedFiles named_;
  const std::uint32_t first_;
  const bool numbered_;
  bool is_scene_ = false;  ///< the file is a scene, not a file of particles
  bool still_ = false;
  std::optional<SceneFile> shared_;  ///< the scene without its particles
  std::optional<SceneFile> only_;    ///< the scene of a still
  TurnAxis axis_{};
  OpenTrajectories open_;
  std::size_t read_ = 0;  ///< frames that fix() has read
  OnRead on_read_;
};

/// Returns the particle files and topologies that a scene file names. Throws InputError.
std::vector<std::string> files_named_in(const std::string& scene_file, NamedFiles named);

/// Turns the camera around the axis, as turned() does (view.h). In an automatic scene, the
/// scenery (ground or wall, light blocker) turns with the camera.
void turn(SceneFile& scene, const TurnAxis& axis, double degrees);

/// The options that determine the frames of a film.
struct FilmCourse {
  std::string scene;                     ///< with #### if each frame has its own file
  std::optional<ChosenFrames> frames{};  ///< of --frames
  std::optional<std::uint32_t> count{};  ///< of --count: number of frames if the scene has one
  double turntable = 0;                  ///< degrees over the film; 0: the camera does not turn
  std::string camera_path{};             ///< file of --camera-path; empty: none
};

/// The frames of a film.
class FilmFrames {
 public:
  using OnRead = FrameScenes::OnRead;

  /// Decides which frames the film has. FrameScenes::fix() gives the frames one camera, and
  /// their colours and radii the same meaning. Numbered scene files stay as they are. `course` and
  /// `options` must outlive this object. Calls `on_read`, if set, after each frame that it reads.
  /// Throws InputError.
  FilmFrames(const FilmCourse& course, const RenderOptions& options, const OnRead& on_read = {});

  /// Returns the numbers of the frames, ascending.
  [[nodiscard]] const std::vector<std::uint32_t>& numbers() const { return numbers_; }
  [[nodiscard]] std::uint32_t count() const { return static_cast<std::uint32_t>(numbers_.size()); }
  /// Returns the place in the film, from 0, of a frame in numbers().
  [[nodiscard]] std::uint32_t place_of(std::uint32_t frame) const;
  /// Returns the names of all files from which the frames are made: scenes, particles, camera path.
  [[nodiscard]] std::vector<std::string> files() const;
  /// Moves the camera of a loaded frame as the course says.
  void move_camera(std::uint32_t frame, SceneFile& scene) const;
  [[nodiscard]] FrameScenes& scenes() { return *scenes_; }

 private:
  std::vector<std::uint32_t> chosen();
  [[nodiscard]] std::vector<std::uint32_t> of_still() const;
  [[nodiscard]] std::vector<std::uint32_t> of_trajectory(std::uint64_t there) const;

  const FilmCourse& course_;
  std::unique_ptr<FrameScenes> scenes_;
  std::optional<CameraPath> path_;
  bool still_ = false;
  std::vector<std::uint32_t> numbers_;
};

/// Returns the angle of the camera in degrees at a place of a film of `count` frames. The frame
/// after the last one would have the angle `turntable`, so that a film of a whole turn can be
/// repeated.
double angle_at(double turntable, std::uint32_t place, std::uint32_t count);

}  // namespace parray::commands

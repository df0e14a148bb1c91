#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/commands/frame_scenes.h"
#include "cli/input/scene_file/camera_path.h"
#include "cli/output/frame_names.h"

namespace parray::commands {

/// What changes from frame to frame of a film.
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
  /// Returns all files that determine the frames.
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

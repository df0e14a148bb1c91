#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "common/scene/limits.h"
#include "common/scene/settings_fwd.h"

namespace parray::proto {

/// Longest texts on the wire, in bytes: names, lines for people, and JobHead::drawing.
inline constexpr std::size_t max_name = 128;
inline constexpr std::size_t max_line = 2000;
inline constexpr std::size_t max_drawing = 12000;

/// The properties of a job that a client states. The client's submission, the message `submit` and
/// the stored record contain them.
struct JobHead {
  std::string name;                ///< name for people: that of the scene file
  std::uint32_t priority = 50;     ///< 0 to 100; of a user's jobs the one with the highest is first
  Boxed<RenderSettings> settings;  ///< resolved: no value is `automatic`, except perhaps `isa`
  std::string precision_reason;    ///< why the settings have this precision, for people
  double load_seconds = 0;         ///< time in which the client loaded the scene
  /// Seconds of the time limit that the client itself needs, for example for loading and writing.
  /// The coordinator ends the job this much before the time limit.
  double reserved_seconds = 0;
  std::uint64_t duplicates_removed = 0;  ///< repeated spheres of its file that the scene leaves out
  /// Number of different machines that must fail at the same cells before the job fails. 0: the
  /// coordinator's --max-failures.
  std::uint32_t max_failures = 0;
  /// For a frame of a series: the series' token (at most 64 bytes), the frame's number and the
  /// number of frames that the series will have. The client chooses the frame's number, such as its
  /// place in a trajectory; the first frame may have any number. Empty and 0 for a single job.
  std::string series{};
  std::uint32_t frame = 0;
  std::uint32_t frames = 0;
  /// Number of the job or series of which this job is the quick look (a small, fast picture, shown
  /// until the other job has samples, and deleted with it); 0: of none.
  std::uint64_t preview_of = 0;
  /// Pictures of the finished job are denoised when they are written. The denoiser needs
  /// WorkSettings::replicates, and the scene, which the coordinator keeps.
  bool denoise = false;
  /// What is drawn on 8-bit pictures of the finished job: JSON that only clients read
  /// (cli/commands/drawing.h). Empty: nothing. The coordinator keeps the scene for this, too.
  std::string drawing{};

  /// Returns whether pictures of the finished job need its scene.
  [[nodiscard]] bool keeps_scene() const { return denoise || !drawing.empty(); }
};

/// Describes the head for messages (ControlWriter, ControlReader) and for records.
void head_fields(auto& f, JobHead& head) {
  f.text("name", head.name, max_name, 1);
  f.number("priority", head.priority, 0U, 100U);
  f.settings("settings", head.settings);
  f.text("precision_reason", head.precision_reason, max_line);
  f.duration("load_seconds", head.load_seconds);
  f.duration("reserved_seconds", head.reserved_seconds);
  f.number("duplicates_removed", head.duplicates_removed);
  f.number("max_failures", head.max_failures, 0U, 1000U);
  f.text("series", head.series, 64);
  f.number("frame", head.frame, 0U, limits::max_frame);
  f.number("frames", head.frames, 0U, limits::max_frames);
  f.number_if_there("preview_of", head.preview_of);
  f.flag_if_there("denoise", head.denoise);
  f.text_if_there("drawing", head.drawing, max_drawing);
}

}  // namespace parray::proto

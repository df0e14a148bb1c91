#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "cli/commands/loading.h"
#include "cli/commands/options.h"
#include "cli/farm/client.h"
#include "cli/output/extra_channels.h"
#include "cli/output/write_outputs.h"

/// The steps of a render before its submission as a job.
namespace parray::commands {

/// How a command renders pictures.
enum class RenderMode : std::uint8_t {
  render,  ///< one picture, in this process
  mpi,     ///< one picture, by the ranks of one mpirun
  wait,    ///< one picture, by a farm; this process writes the file
  submit,  ///< one picture, by a farm; no file here
  sheet,   ///< several views in one picture, in this process
  series,  ///< frames, by a farm
  http,    ///< one picture or a series, submitted by HTTP
  fetch,   ///< a picture from a farm, without its scene
  film     ///< frames, in this process or by a farm; this process writes the files
};

/// Features that some modes lack.
enum class Feature : std::uint8_t {
  denoising,
  denoised_target,  ///< a target error of the denoised picture
  transparency,
  background,  ///< --background
  labels,
  postprocessing,  ///< outlines, depth cue
  preview,         ///< --preview, --display
  end_command,     ///< --on-end
  error_map,
  exr_file,         ///< an EXR picture
  like,             ///< --like
  view,             ///< --view
  traced_channels,  ///< extra channels that need the scene
  standard_input    ///< the scene comes from there
};

/// Returns whether `mode` supports `feature`.
[[nodiscard]] bool can_have(RenderMode mode, Feature feature);

/// Throws InputError, with a remedy, if `mode` does not support `feature`. `name`: the option or
/// setting that asks for it, such as "--denoise".
void require(RenderMode mode, Feature feature, const std::string& name);

/// A loaded scene, ready for submission.
struct LoadedSubmission {
  Submission submission;
  /// The contents of the scene file without the scene, which is in `submission`. Only the camera
  /// remains in `rest.scene`.
  SceneFile rest;
  std::string original_sha256;     ///< image_sha256 of the picture of --like; empty: no --like
  bool original_denoised = false;  ///< the picture of --like is denoised
};

/// Loads a scene, lays the options over its settings and resolves automatic settings. In
/// RenderMode::http the scene may only name files in its own folder. Throws InputError.
LoadedSubmission load_submission(RenderMode mode, const std::string& scene_file,
                                 const RenderOptions& options, std::uint32_t priority,
                                 const FrameChange& change = {});

class FrameScenes;
/// Does what load_submission() does, for a frame that `scenes` loads. Calls `change`, if set, on
/// the loaded scene.
LoadedSubmission load_frame(RenderMode mode, FrameScenes& scenes, std::uint32_t frame,
                            std::uint32_t priority,
                            const std::function<void(SceneFile&)>& change = {});

/// Changes the settings of a picture that will be denoised: keeps replicates, which the denoiser
/// needs, and applies a target error to the denoised picture. `usual`: no option gives the target
/// error. It then remains the target of the picture before denoising if the mode lacks
/// denoised_target. Throws InputError if the target cannot apply to the denoised picture.
void ask_for_denoising(RenderSettings& settings, RenderMode mode, bool usual);

/// The request of a command line. The objects behind the references must outlive it.
struct RenderRequest {
  RenderMode mode;
  const std::string& scene;
  const RenderOptions& render;
  const OutputOptions& output;
  const ProgressOptions& following;
  std::uint32_t threads;        ///< threads of this process that trace pictures or extra channels
  std::uint32_t priority = 50;  ///< of the job, 0 to 100
  std::optional<View> view{};   ///< for a sheet: the view to render, instead of --view
  std::filesystem::path key_file{};  ///< FarmOptions::key_file()
};

/// Returns the input files that the command line of the request names.
InputFiles inputs_of(const RenderRequest& request);

/// Throws InputError if the request asks for a feature that its mode lacks.
void check_request(const RenderRequest& request);

/// A render of one picture, ready for submission.
struct PreparedRender {
  Submission submission;
  OutputPaths outputs;  ///< files, and steps after tracing, that options and scene ask for
  ExtraChannels extra;  ///< the channels to trace after the render, and the denoising
};

/// Checks the request, its output files and its viewer (--display), then loads the scene. Throws
/// InputError.
PreparedRender prepare(const RenderRequest& request);

/// Sets submission.reserved_seconds: the part of the time limit for steps of this command, such as
/// denoising and writing. `elapsed` returns the seconds of the limit that have passed. If denoising
/// does not fit, leaves it out; if extra channels still do not fit, leaves them out, too. Prints a
/// line on stderr for each. Does nothing without a time limit. See time_reserve.h.
void reserve_time(PreparedRender& render, std::function<double()> elapsed);

/// Throws InputError unless this machine has the instruction set.
void check_isa(Isa isa);

}  // namespace parray::commands

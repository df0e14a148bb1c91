#pragma once

#include <cstdint>
#include <string>

#include "common/rooms.h"

namespace parray::commands {

/// How a command has pictures rendered.
enum class RenderMode : std::uint8_t {
  render,  ///< one picture, in this process
  mpi,     ///< one picture, by the ranks of one mpirun
  wait,    ///< one picture, by a farm; this process writes the file
  submit,  ///< one picture, by a farm; no file here
  sheet,   ///< several views in one picture, in this process
  series,  ///< frames, by a farm
  http,    ///< one picture, submitted by HTTP
  fetch    ///< a picture from a farm, without its scene
};

/// What some modes cannot have.
enum class Feature : std::uint8_t {
  denoising,
  denoised_target,  ///< a target error of the denoised picture
  transparency,
  labels,
  postprocessing,  ///< outlines, depth cue
  preview,         ///< --preview, --display
  end_command,
  error_map,
  exr_file,
  like,
  view,             ///< --view
  traced_channels,  ///< extra channels that need the scene
  standard_input    ///< the scene comes from there
};

[[nodiscard]] bool can_have(RenderMode mode, Feature feature);

/// Throws InputError, with a remedy, if `mode` cannot have `feature`. `name`: what asks for the
/// feature, as "--denoise".
void require(RenderMode mode, Feature feature, const std::string& name);

}  // namespace parray::commands

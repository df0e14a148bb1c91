#pragma once

#include <filesystem>
#include <optional>

#include "cli/output/picture/picture.h"
#include "cli/output/postprocess/postprocessing.h"
#include "proto/clock.h"

namespace parray::output {

/// A picture that is made again, of --like.
struct OriginalPicture {
  std::string file;  ///< for people
  std::string image_sha256;
};

/// Where a picture and its report go; empty: not wanted.
struct OutputPaths {
  std::filesystem::path image{};
  std::filesystem::path report{};
  Aovs aovs{};                        ///< wanted as extra channels of the image
  bool denoise = false;               ///< the image is to be a denoised one
  std::filesystem::path error_map{};  ///< see cli/output/error_map.h
  nlohmann::json notes{};             ///< of the files of particles, for the report
  std::filesystem::path preview{};    ///< follows the job (preview.h); ends as a copy of the image
  bool transparent = false;           ///< the image is to have no background

  OriginalPicture original{};  ///< whose bits the picture is to have; without a hash: nobody's

  Finishing finishing{};  ///< of the files that are PNG
  std::string legends{};  ///< what colours mean, as legends_text() has it; for files and report
  double dpi = 0;         ///< pixels an inch when printed, for the files' metadata; 0: not said

  /// How much of the picture has to come for them.
  [[nodiscard]] PictureDetail wanted_detail() const;

  /// Image or preview is a file that finishing steps are for.
  [[nodiscard]] bool has_png() const;
  [[nodiscard]] bool none() const { return image.empty() && report.empty(); }
};

/// Both name the same file, whether it is there yet or not; false if one is empty.
bool same_file(const std::filesystem::path& a, const std::filesystem::path& b);

/// Throws InputError unless all can be written, image, report and map differ, none is `scene`, and
/// the image has room for the channels. Called before any work.
void check_outputs(const OutputPaths& outputs, const std::filesystem::path& scene = {});

/// Of the command that has rendered the picture.
struct CommandTimes {
  Time started;
  double submit_seconds = 0;  ///< until its scene was taken in
  bool limited = false;       ///< a time limit counts since `started`, writing included
};

/// Writes a picture with its recipe and, if it is an EXR file, its channels; else with the
/// finishing steps of `outputs` applied. Waits for the disk. Throws as write_outputs() does.
void write_picture(const std::filesystem::path& file, const Picture& picture,
                   const OutputPaths& outputs = {}, bool fast = false);

/// Writes a finished picture, also as its preview, its map and its report, and says on
/// stdout what was written (on stderr, too, if samples were not finite). The report gets
/// `seconds.write` and `seconds.total`. With `times` that is the time since the start, and its
/// parts add up to it: `submit`, and `other`: waiting for a turn, making the image and its error.
/// Without them it is the sum of what parts there are.
///
/// Returns the program's exit status: 0, or 1 if samples were not finite or the bits are not those
/// of the original, which it says on stderr. Throws RunError, and Interrupted (see
/// common/process/stop_signal.h) between two strips of the image; nothing half-written stays. An
/// image that cannot be written is kept in another folder, which the error names.
int write_outputs(Picture picture, const OutputPaths& outputs, std::optional<CommandTimes> times);

}  // namespace parray::output

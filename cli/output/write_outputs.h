#pragma once

#include <filesystem>
#include <optional>

#include "cli/output/picture/picture.h"
#include "cli/output/postprocess/postprocessing.h"
#include "proto/clock.h"

namespace parray::output {

/// The picture that --like reproduces.
struct OriginalPicture {
  std::string file;  ///< its file, for messages
  std::string image_sha256;
};

/// The files of a picture and their contents. An empty path: no such file.
struct OutputPaths {
  std::filesystem::path image{};
  std::filesystem::path report{};
  Aovs aovs{};                        ///< extra channels of the image
  bool denoise = false;               ///< denoise the image
  std::filesystem::path error_map{};  ///< see cli/output/error_map.h
  nlohmann::json notes{};             ///< notes about files of particles, for the report
  std::filesystem::path
      preview{};             ///< updated during the job (preview.h); at the end a copy of the image
  bool transparent = false;  ///< remove the background

  OriginalPicture original{};  ///< the picture must have its bits; without a hash: no such check

  PostprocessSteps finishing{};  ///< postprocessing of PNG files
  std::string legends{};         ///< legends_text(), for files and report
  double dpi = 0;                ///< pixels per inch in print, for the metadata; 0: unknown

  /// The part of the picture that the files need.
  [[nodiscard]] PictureDetail wanted_detail() const;

  /// Whether image or preview is a file with postprocessing.
  [[nodiscard]] bool has_png() const;
  [[nodiscard]] bool none() const { return image.empty() && report.empty(); }
};

/// Whether both paths name the same file, which need not exist. False if one is empty.
bool same_file(const std::filesystem::path& a, const std::filesystem::path& b);

/// Throws InputError unless all files can be written, image, report and map differ, no file is
/// `scene`, and the image has room for the channels. Call before any work.
void check_outputs(const OutputPaths& outputs, const std::filesystem::path& scene = {});

/// Times of the command that rendered the picture.
struct CommandTimes {
  Time started;
  double submit_seconds = 0;  ///< until the scene was accepted
  bool limited = false;       ///< a time limit counts from `started` and includes writing
};

/// Writes a picture with its recipe. An EXR file also gets the channels; other files get the
/// postprocessing of `outputs`. Waits for the disk. Throws as write_outputs() does.
void write_picture(const std::filesystem::path& file, const Picture& picture,
                   const OutputPaths& outputs = {}, bool fast = false);

/// Writes image, preview, error map and report. Prints on stdout what was written, and on stderr if
/// samples were not finite. The report gets `seconds.write` and `seconds.total`. With `times` the
/// total is the time since the start and the sum of its parts, which include `submit` and `other`
/// (waiting for a turn, computing the image and its error). Without `times` the total is the sum of
/// the known parts.
///
/// Returns the exit status: 0, or 1 if samples were not finite or the bits differ from the
/// original's; stderr says so. Throws RunError, and Interrupted (common/process/stop_signal.h)
/// between two strips of the image; no partial file remains. If the image cannot be written, it is
/// saved to another folder, which the error names.
int write_outputs(Picture picture, const OutputPaths& outputs, std::optional<CommandTimes> times);

}  // namespace parray::output

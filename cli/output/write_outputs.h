#pragma once

#include <filesystem>
#include <optional>

#include "cli/output/input_files.h"
#include "cli/output/picture/picture.h"
#include "cli/output/postprocess/postprocessing.h"
#include "proto/clock.h"

namespace parray::output {

/// The picture that --like reproduces.
struct OriginalPicture {
  std::string file;          ///< its file name, for messages
  std::string image_sha256;  ///< of the picture before denoising; empty: no such picture
};

/// The files of a picture and what they contain. An empty path: no such file.
struct OutputPaths {
  std::filesystem::path image{};
  std::filesystem::path report{};
  Aovs aovs{};                        ///< extra channels of the image
  bool denoise = false;               ///< denoise the image
  std::filesystem::path error_map{};  ///< see cli/output/error_map.h
  nlohmann::json notes{};             ///< notes about particle files, for the report
  nlohmann::json facts{};             ///< map of further members of the report; null: none
  bool summary = true;                ///< print a summary of the files on stdout
  std::filesystem::path
      preview{};             ///< updated during the job (preview.h); becomes a copy of the image
  bool transparent = false;  ///< remove the background

  OriginalPicture original{};  ///< the result must have the same bits; no hash: no check

  PostprocessSteps finishing{};  ///< postprocessing of all files except EXR
  std::string legends{};         ///< legends_text(), for files and report
  double dpi = 0;                ///< pixels per inch in print, for the metadata; 0: unknown

  /// Returns the detail of the picture that the files need.
  [[nodiscard]] PictureDetail wanted_detail() const;

  /// Returns whether image or preview is a file that gets postprocessing: any except EXR.
  [[nodiscard]] bool shows_postprocessing() const;
  /// Returns whether neither image nor report is written.
  [[nodiscard]] bool none() const { return image.empty() && report.empty(); }
};

/// Returns whether both paths name the same file, which need not exist. Returns false if one is
/// empty.
bool same_file(const std::filesystem::path& a, const std::filesystem::path& b);

/// Throws InputError unless all files can be written, they differ (except that the preview may be
/// the image), none is an input, the image can contain the channels, and the map is not EXR.
/// Throws RunError if the font for the map is missing. Call it before any work.
void check_outputs(const OutputPaths& outputs, const InputFiles& inputs = {});

/// Throws InputError if one of the files is an input. Call it for inputs that were not known when
/// check_outputs() was called.
void check_not_inputs(const OutputPaths& outputs, const InputFiles& inputs);

/// Times of the command that rendered the picture.
struct CommandTimes {
  Time started;
  double submit_seconds = 0;  ///< seconds until the scene was accepted
  bool limited = false;       ///< true: a time limit counts from `started` and includes writing
};

/// Writes a picture with its recipe. An EXR file also gets the channels. Other files get the
/// postprocessing of `outputs`. `fast`: a larger file in less time. Waits until the data are on the
/// disk. Throws RunError, and Interrupted as write_outputs() does.
void write_picture(const std::filesystem::path& file, const Picture& picture,
                   const OutputPaths& outputs = {}, bool fast = false);

/// Writes image, preview, error map and report. Prints a summary on stdout, and a warning on stderr
/// if samples were not finite. The report gets `seconds.write` and `seconds.total`. With `times`,
/// the total is the time since `times.started`, and `seconds` also gets `submit` and `other`
/// (waiting, computing the image and its error). Without `times`, the total is the sum of the known
/// parts.
///
/// Returns the exit status: 0, or 1 if samples were not finite or the bits differ from those of the
/// original. Prints the reason on stderr. Throws RunError. Throws Interrupted
/// (common/process/stop_signal.h) between two strips of the image; no partial file remains. If the
/// image cannot be written, tries to save it to the folder for temporary files or the current
/// folder. The error then names the saved file.
int write_outputs(Picture picture, const OutputPaths& outputs, std::optional<CommandTimes> times);

}  // namespace parray::output

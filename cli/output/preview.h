#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "cli/farm/client.h"
#include "common/image/image.h"
#include "common/process/stop_signal.h"

namespace parray::output {

/// What a command shows of a job, and runs at its end.
struct ProgressOptions {
  bool quiet = false;    ///< show no progress
  std::string progress;  ///< its style, see progress_style()
  std::string preview;   ///< picture file; empty: none
  std::string display;   ///< HOST:PORT of a viewer; empty: none
  std::string on_end;    ///< command for the shell; see run_end_command(). Empty: none

  /// Whether the command shows the unfinished picture.
  [[nodiscard]] bool shows_picture() const { return !preview.empty() || !display.empty(); }
};

/// Decides when to write previews. A preview is whole if every pixel has a sample, and otherwise
/// partial. The first whole preview is due as soon as every pixel has a sample. If this takes
/// longer than a tenth of a second, partial previews are due before. Later previews are due at most
/// ten times a second. Writing these later previews takes at most a fiftieth of the time since the
/// first sample.
///
/// Reads no clock.
class PreviewPace {
 public:
  /// Returns whether it is time for a preview. `elapsed`: seconds since the first sample was
  /// noticed. `whole`: every pixel has a sample.
  [[nodiscard]] bool due(double elapsed, bool whole) const;
  /// Records a preview whose writing took `cost` seconds and ended at `elapsed`.
  void wrote(double elapsed, bool whole, double cost);

 private:
  double spent_ = 0;  ///< cost of all previews except the first and the first whole one
  double latest_cost_ = 0;
  std::optional<double> latest_;
  bool shown_whole_ = false;
};

class Display;

/// Throws InputError unless `address`, that of a viewer, is empty or HOST:PORT with a port above 0.
/// The default port of tev is 14158.
void check_display(const std::string& address);

/// Updates a file and a viewer with the unfinished picture of a job. Each update replaces the file
/// atomically, so that readers never see half a file. The caller writes the finished picture to the
/// file.
class Preview {
 public:
  /// Uses the preview file and the viewer of `options`. The caller must have called
  /// check_image_path() for the file. Throws InputError for an invalid address. follow() calls
  /// `while_writing` every few milliseconds while it writes EXR or PNG. An exception of it ends the
  /// writing and passes through follow().
  explicit Preview(const ProgressOptions& options,
                   std::function<void()> while_writing = check_interrupted);
  ~Preview();
  Preview& operator=(Preview&&) = delete;

  [[nodiscard]] bool wanted() const { return !file_.empty() || display_; }

  /// Writes the current picture if it is time. `partial` returns this picture, in which pixels
  /// without a sample have the colours of pixels near them. `clock` gives the current time. Throws
  /// RunError if the file cannot be written. Ignores a viewer that does not answer, except for
  /// one line on stderr.
  void follow(const Clock& clock, const JobStatus& status, const std::function<Image()>& partial);
  /// Shows the finished picture if a viewer has been sent an unfinished one.
  void finish(const Image& image);

 private:
  std::filesystem::path file_;
  std::unique_ptr<Display> display_;
  std::string name_;  ///< name of the picture in the viewer
  std::function<void()> while_writing_;
  std::optional<Time> began_;  ///< when follow() noticed the first samples
  PreviewPace pace_;
};

}  // namespace parray::output

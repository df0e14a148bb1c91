#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "cli/farm/client.h"
#include "cli/output/display.h"
#include "common/image/image.h"
#include "common/process/stop_signal.h"

namespace parray::output {

/// What is shown of a job until it is done.
struct ProgressOptions {
  bool quiet = false;    ///< no progress
  std::string progress;  ///< its style, see progress_style()
  std::string preview;   ///< picture file; empty: none
  std::string display;   ///< HOST:PORT of a viewer; empty: none
  std::string on_end;    ///< command for the shell; see run_end_command(). Empty: none

  /// The picture is looked at before it is done.
  [[nodiscard]] bool shows_picture() const { return !preview.empty() || !display.empty(); }
};

/// When to write previews: the first as soon as every pixel has a sample, or after a tenth of a
/// second of what there is, if that takes longer, and then when every pixel has one; later ones ten
/// times a second at most, and such that they take a fiftieth of the time.
///
/// Arithmetic on seconds alone.
class PreviewPace {
 public:
  /// `elapsed`: since the first sample, or before. `whole`: every pixel has a sample.
  [[nodiscard]] bool due(double elapsed, bool whole) const;
  /// One was written, until `elapsed`, and took `cost` seconds.
  void wrote(double elapsed, bool whole, double cost);

 private:
  double spent_ = 0;  ///< but for the first, and the first of all pixels
  double latest_cost_ = 0;
  std::optional<double> latest_;
  bool shown_whole_ = false;
};

/// A picture that follows a job, in a file that is written anew every now and then, always a whole
/// one, and on a display. Pixels without a sample are filled. What the file ends with,
/// write_outputs() writes.
class Preview {
 public:
  /// Of `following` preview, which may be written (check_image_path()), and display; throws
  /// InputError where that is no address. `while_writing` is called time and again, and may throw.
  explicit Preview(const ProgressOptions& following,
                   std::function<void()> while_writing = check_interrupted);

  [[nodiscard]] bool wanted() const { return !file_.empty() || display_; }

  /// Writes what there is of the picture, when it is time to. `now` is what `clock` says.
  void follow(const Clock& clock, const JobStatus& status, const std::function<Image()>& partial);
  /// Puts the finished picture on the display, if it has been there.
  void finish(const Image& image);

 private:
  std::filesystem::path file_;
  std::unique_ptr<Display> display_;
  std::string name_;  ///< of the window
  std::function<void()> while_writing_;
  std::optional<Time> began_;  ///< samples were seen
  PreviewPace pace_;
};

}  // namespace parray::output

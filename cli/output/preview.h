#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "cli/farm/client.h"
#include "common/image/image.h"
#include "common/process/stop_signal.h"

namespace parray {

/// What is shown of a job until it is done.
struct Following {
  bool quiet = false;   ///< no progress
  std::string preview;  ///< picture file; empty: none
  std::string on_end;   ///< command for the shell; see run_end_command(). Empty: none
};

/// A picture file that follows a job: written anew every now and then, always whole.
class Preview {
 public:
  /// An empty path: none. Throws InputError unless it can be written. `while_writing` is called
  /// time and again, and may throw.
  explicit Preview(std::filesystem::path file,
                   std::function<void()> while_writing = check_interrupted);

  [[nodiscard]] bool wanted() const { return !file_.empty(); }

  /// Writes what there is of the picture, when it is time to: first as soon as every pixel has a
  /// sample, or after a second of waiting for that (only progressive jobs begin with a sample of
  /// each); then after at least ten times as long as that takes.
  void follow(Time now, const JobStatus& status, const std::function<Image()>& partial);

 private:
  std::filesystem::path file_;
  std::function<void()> while_writing_;
  std::optional<Time> began_;
  Time next_{};
};

}  // namespace parray

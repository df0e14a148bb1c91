#pragma once

#include <filesystem>
#include <functional>
#include <ostream>
#include <string>

#include "common/rooms.h"

namespace parray::picture {

/// Throws InputError unless a file can be made at `path`: its directory exists and may be written
/// to, and what is there now, if anything, is a plain file. Meant for before the work whose result
/// the file will hold; the disk may still fill up afterwards.
void check_output_path(const std::filesystem::path& path);

/// A file that appears under its own name only when it is complete.
///
/// It is written as `.NAME.partial-PID.EXTENSION` beside its target, so that the final step is a
/// rename within one file system. Whatever ends the writing early, the partial file goes with this
/// object. One thread.
class PartialFile {
 public:
  /// Makes nothing yet: whoever has the object opens path().
  explicit PartialFile(std::filesystem::path target);
  ~PartialFile();
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;

  /// Where to write. The extension is the target's, because image libraries go by it.
  [[nodiscard]] const std::filesystem::path& path() const { return partial_; }

  /// Waits for the disk and gives the file its name; an older file of that name is replaced.
  /// Throws RunError "writing FILE: reason".
  void commit();
  /// The same for a file that may be lost when the machine fails: waits for nothing.
  void show();

 private:
  std::filesystem::path target_;
  std::filesystem::path partial_;
};

/// Makes the file `path` of what `write` puts into the stream, all of it or nothing. Throws
/// RunError "writing FILE: reason" as soon as the stream fails; what `write` throws passes through.
void write_file(const std::filesystem::path& path, const std::function<void(std::ostream&)>& write);

/// Writes `text` to `path`, all of it or nothing. Throws RunError "writing FILE: reason".
void write_text_file(const std::filesystem::path& path, const std::string& text);

}  // namespace parray::picture

#pragma once

#include <filesystem>
#include <functional>
#include <ostream>
#include <string>

#include "common/rooms.h"

namespace parray::picture {

/// Throws InputError unless a file can be created at `path`: its directory exists and is writable,
/// and an existing file there is a regular file. Call before the work whose result the file will
/// hold. The disk may still fill up later.
void check_output_path(const std::filesystem::path& path);

/// A file that appears under its own name only when it is complete.
///
/// It is written as `.NAME.partial-PID.EXTENSION` beside its target, so that the last step is a
/// rename within one file system. The destructor removes a partial file. Not thread-safe.
class PartialFile {
 public:
  /// Creates nothing yet: the caller opens path().
  explicit PartialFile(std::filesystem::path target);
  ~PartialFile();
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;

  /// The path to write to. It has the target's extension, because image libraries use it.
  [[nodiscard]] const std::filesystem::path& path() const { return partial_; }

  /// Waits for the disk and renames the file; replaces an existing file. Throws RunError "writing
  /// FILE: reason".
  void commit();
  /// The same without waiting for the disk: the file may be lost if the machine fails.
  void show();

 private:
  std::filesystem::path target_;
  std::filesystem::path partial_;
};

/// Creates the file `path` from what `write` puts into the stream, all of it or nothing. Throws
/// RunError "writing FILE: reason" when the stream fails; exceptions of `write` pass through.
void write_file(const std::filesystem::path& path, const std::function<void(std::ostream&)>& write);

/// Writes `text` to `path`, all of it or nothing. Throws RunError "writing FILE: reason".
void write_text_file(const std::filesystem::path& path, const std::string& text);

}  // namespace parray::picture

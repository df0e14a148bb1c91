#pragma once

#include <filesystem>
#include <functional>
#include <ostream>
#include <string>

#include "common/rooms.h"

namespace parray::picture {

/// Throws InputError unless a file can be created at `path`. Its directory must exist and be
/// writable. An existing file must be a regular file. Call it before the work whose result the file
/// will contain. The disk may still fill up later.
void check_output_path(const std::filesystem::path& path);

/// A file that appears under its own name only when it is complete.
///
/// Writing uses the name `.NAME.partial-PID.EXTENSION` beside the target. So the last step is a
/// rename within one file system. The destructor removes a partial file. Not thread-safe.
class PartialFile {
 public:
  /// Creates no file. The caller opens path().
  explicit PartialFile(std::filesystem::path target);
  ~PartialFile();
  PartialFile& operator=(PartialFile&&) = delete;

  /// Returns the path to write to. It has the target's extension, because image libraries use it.
  [[nodiscard]] const std::filesystem::path& path() const { return partial_; }

  /// Waits for the disk and renames the file. Replaces an existing file. Throws RunError "writing
  /// FILE: reason".
  void commit();
  /// Does the same without waiting for the disk. The file may be lost if the machine fails.
  void show();

 private:
  std::filesystem::path target_;
  std::filesystem::path partial_;
};

/// Creates the file `path` with all data that `write` puts into the stream, or not at all. Throws
/// RunError "writing FILE: reason" if the stream fails. Passes on exceptions of `write`.
void write_file(const std::filesystem::path& path, const std::function<void(std::ostream&)>& write);

/// Writes `text` to `path` completely or not at all. Throws RunError "writing FILE: reason".
void write_text_file(const std::filesystem::path& path, const std::string& text);

}  // namespace parray::picture

#pragma once

#include <sys/types.h>

#include <filesystem>
#include <initializer_list>
#include <set>
#include <utility>

#include "common/rooms.h"

namespace parray::output {

/// The files that a command reads. It must not overwrite them.
class InputFiles {
 public:
  InputFiles() = default;
  InputFiles(std::initializer_list<std::filesystem::path> files) {
    for (const std::filesystem::path& file : files) add(file);
  }

  /// Adds a file, which need not exist. "-" also stands for the file that is the standard input.
  /// Does nothing if the path is empty.
  void add(const std::filesystem::path& file);
  /// Throws InputError if `output` is one of the files, also under another name, such as that of a
  /// symbolic link. Does nothing if the path is empty.
  void check(const std::filesystem::path& output) const;

 private:
  std::set<std::pair<dev_t, ino_t>> identities_;  ///< of the files that exist
  std::set<std::filesystem::path> names_;         ///< absolute
};

}  // namespace parray::output

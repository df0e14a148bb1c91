#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "coordinator/store/state_files.h"

namespace parray::store {

/// A path of the state that holds the wrong kind of thing: a directory, a pipe, a socket or a
/// device in the place of a file, or a file in the place of a directory.
struct Misplaced {
  std::filesystem::path path{};  ///< absolute
  std::string line{};  ///< "jobs/3/rows is a directory, not a file", relative to the state
};

/// Finds them among the names that the state uses, parents before their content. A symbolic link
/// counts as what it points to. Opens and changes no file.
std::vector<Misplaced> find_misplaced(const StateFiles& files);

/// Moves each to lost/`uptime`. Returns a line for each. Throws RunError when a path cannot be
/// moved.
std::vector<std::string> set_aside_misplaced(StateFiles& files,
                                             const std::vector<Misplaced>& misplaced,
                                             std::uint64_t uptime);

}  // namespace parray::store

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

/// Finds misplaced paths among the names that the state uses, directories before their content. A
/// symbolic link counts as its target. Opens and changes no file.
std::vector<Misplaced> find_misplaced(const StateFiles& files);

/// Moves each path to lost/`uptime`. Returns one line for each. Throws RunError if it cannot move
/// one.
std::vector<std::string> move_misplaced_to_lost(StateFiles& files,
                                                const std::vector<Misplaced>& misplaced,
                                                std::uint64_t uptime);

}  // namespace parray::store

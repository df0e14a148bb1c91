#pragma once

#include <optional>
#include <string>

#include "coordinator/store/store.h"

namespace parray::coordinator {

/// The file of a finished picture, as read from a store.
struct PictureFile {
  std::optional<std::string> bytes;  ///< nothing: the store has no undamaged picture
  std::string damage;                ///< what was wrong with the store's file; empty: nothing
  bool restored = false;             ///< a copy from the standby has replaced the damaged file
};

/// Reads the picture of a job. Replaces a damaged file by the store's other copy, if there is one.
/// Throws RunError if the store cannot be read at all.
PictureFile read_picture_file(Store& store, JobId job);

/// Returns the new JobRecord::flag (a text about faults) of a job whose picture was read. `flag`:
/// the present one. If the file is or was damaged, a new note on this replaces the older note on
/// the file. If the file is undamaged, the older note disappears. But a note that the file was
/// restored stays, because the disk may be defective. A missing file changes nothing.
std::string flag_with(const std::string& flag, const PictureFile& kept);

}  // namespace parray::coordinator

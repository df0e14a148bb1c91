#pragma once

#include <optional>
#include <string>

#include "coordinator/store/store.h"

namespace parray::coordinator {

/// The file of a finished picture, as a store gives it out.
struct PictureFile {
  std::optional<std::string> bytes;  ///< empty: the store has no undamaged picture
  std::string damage;                ///< what was wrong with the store's file; empty: nothing
  bool restored = false;             ///< the damaged file was replaced by a copy from elsewhere
};

/// Reads the picture of a job. A damaged file is replaced by the store's other copy, if there is
/// one. Throws RunError when the store cannot be read at all.
PictureFile read_picture_file(Store& store, JobId job);

/// The flag of a job whose picture was read: `flag` as it was before, without an older note on the
/// picture's file, and with the note that `kept` calls for.
std::string flag_with(const std::string& flag, const PictureFile& kept);

}  // namespace parray::coordinator

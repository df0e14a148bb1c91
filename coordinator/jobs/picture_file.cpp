#include "coordinator/jobs/picture_file.h"

#include <string_view>

namespace parray::coordinator {

/// How every note of this file begins.
static constexpr std::string_view note_begin = "the file of its picture ";

PictureFile read_picture_file(Store& store, JobId job) {
  PictureFile kept;
  try {
    kept.bytes = store.picture(job);
  } catch (const DamagedFile& damaged) {
    kept.damage = damaged.what();
    kept.restored = store.restore_picture(job);
    if (kept.restored) kept.bytes = store.picture(job);
  }
  return kept;
}

std::string flag_with(const std::string& flag, const PictureFile& kept) {
  const std::size_t old = flag.find(note_begin);
  const bool mended = old != std::string::npos && flag.find("restored", old) != std::string::npos;
  if (kept.damage.empty() && (mended || !kept.bytes)) return flag;
  std::string begin = flag.substr(0, old);
  if (kept.damage.empty()) {
    begin.resize(begin.ends_with("; ") ? begin.size() - 2 : begin.size());
    return begin;
  }
  if (!begin.empty() && !begin.ends_with("; ")) begin += "; ";
  return begin + std::string(note_begin) +
         (kept.restored ? "was damaged and has been restored from the standby: test this disk"
                        : "is damaged: put it back from a backup, or submit the scene again");
}

}  // namespace parray::coordinator

#include <algorithm>
#include <system_error>

#include "coordinator/store/disk_store.h"

namespace parray::store {

namespace fs = std::filesystem;

static bool is_cut(const fs::path& file, std::uint64_t bytes) {
  std::error_code error;
  const std::uint64_t size = fs::file_size(file, error);
  return error || size < bytes;
}

bool DiskStore::lacks_files() {
  const bool lacks_scene = std::ranges::any_of(scenes_, [this](const auto& scene) {
    return is_cut(files_.scene(scene.first), scene.second.bytes);
  });
  return lacks_scene || std::ranges::any_of(jobs_, [this](const auto& job) {
           const auto& [id, entry] = job;
           return (entry.log && is_cut(files_.rows(id, entry.log->number), entry.log->committed)) ||
                  (entry.picture &&
                   is_cut(files_.picture(id, entry.picture->number), entry.picture->file.bytes));
         });
}

}  // namespace parray::store

#include <algorithm>

#include "coordinator/disputes/dispute_desk.h"
#include "coordinator/jobs/job_book.h"
#include "coordinator/loop/farm.h"

namespace parray::coordinator {

/// Drops data of the oldest ended jobs first, and the last picture only if there is no other way.
bool JobBook::make_room(std::uint64_t bytes) {
  if (farm_.store != nullptr) {
    return memory_in_use() + bytes <= farm_.options.memory;  // the store keeps ended jobs
  }
  std::uint64_t in_use = memory_in_use() + bytes;
  drop_unfinished(in_use);
  std::uint64_t kept = 0;
  std::size_t pictures = 0;
  bool at_work = false;
  for (const auto& [id, job] : farm_.jobs) {
    kept += job.kept_bytes();
    pictures += job.picture_bytes > 0 ? 1 : 0;
    at_work = at_work || job.work;
  }
  if (in_use - kept > farm_.options.memory) {
    return false;  // dropping everything would not suffice
  }
  for (auto& [id, job] : farm_.jobs) {
    if (in_use <= farm_.options.memory) break;
    const bool last_picture = job.picture_bytes > 0 && pictures == 1;
    if (job.kept_bytes() == 0 || (last_picture && (at_work || bytes == 0))) continue;
    in_use -= job.kept_bytes();
    pictures -= job.picture_bytes > 0 ? 1 : 0;
    job.picture = {};
    job.journal = {};
    job.picture_bytes = 0;
    job.scene = {};
  }
  return in_use <= farm_.options.memory;
}

std::uint64_t JobBook::memory_of(const Job& job) const {
  return JobPicture::memory(job.record.settings) +
         (farm_.store != nullptr ? job.record.scene_bytes : 0);
}

std::uint64_t JobBook::memory_in_use() const {
  std::uint64_t bytes = disputes_.referee().memory() + farm_.bulk.bytes() +
                        farm_.log_pictures.bytes() + farm_.scenes_waiting.bytes();
  for (const JobId id : farm_.at_work) bytes += memory_of(farm_.jobs.at(id));
  if (farm_.store == nullptr) {
    for (const auto& [id, job] : farm_.jobs) bytes += job.scene.size() + job.picture_bytes;
  }
  return bytes;
}

/// Returns whether memory suffices for all scenes and the largest picture of the open jobs and a
/// new job that needs `needed` bytes with its scene. Otherwise some job could never start.
bool JobBook::fits_beside_scenes(std::uint64_t needed, std::uint64_t scene) const {
  std::uint64_t scenes = scene;
  std::uint64_t largest = needed - scene;
  for (const JobId id : farm_.index.open()) {
    scenes += farm_.jobs.at(id).scene.size();
    largest = std::max(largest, JobPicture::memory(farm_.jobs.at(id).record.settings));
  }
  return scenes + largest <= farm_.options.memory;
}

}  // namespace parray::coordinator

#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/scene/settings.h"

namespace parray {

using JobId = std::uint64_t;

enum class JobState : std::uint8_t { queued, running, paused, done, failed, cancelled };
std::string_view name_of(JobState state);

/// What outlives a coordinator about a job.
struct JobRecord {
  JobId id = 0;
  std::string token;
  std::string name;
  std::uint32_t priority = 50;
  RenderSettings settings;
  std::string precision_reason;
  std::uint64_t duplicates_removed = 0;
  double load_seconds = 0;
  std::string scene;       ///< digest
  std::uint32_t life = 0;  ///< coordinators that have had it open before this one
  /// Samples of each pass that has begun; see common/image/passes.h.
  std::vector<std::uint64_t> passes{};
  JobState state = JobState::queued;
  std::string reason;  ///< of a failure
  std::string report;  ///< JSON, of a done job
};

/// Where jobs, scenes, accepted blocks and pictures are kept: the seam to the disk.
///
/// Nothing counts as kept before commit() has returned; the coordinator acknowledges nothing
/// earlier. Every member may throw RunError (disk full, file damaged). One thread.
class Store {
 public:
  virtual ~Store() = default;

  virtual void put_job(const JobRecord& job) = 0;  ///< new, or in place of the one with its id
  virtual void put_scene(const std::string& digest, const std::string& bytes) = 0;
  virtual void put_block(JobId job, std::uint64_t epoch, const std::string& bytes) = 0;
  /// The finished picture (float32 RGB); the job's blocks are no longer needed.
  virtual void put_picture(JobId job, const std::string& bytes) = 0;
  /// The job's blocks are no longer needed; nor is a scene that no unfinished job uses.
  virtual void drop_work(JobId job) = 0;
  virtual void drop_job(JobId job) = 0;
  virtual void commit() = 0;

  /// What an earlier life left behind.
  virtual std::vector<JobRecord> jobs() = 0;
  virtual std::optional<std::string> scene(const std::string& digest) = 0;
  using BlockVisitor = std::function<void(const std::string& bytes)>;
  virtual void each_block(JobId job, const BlockVisitor& visit) = 0;
  virtual std::optional<std::string> picture(JobId job) = 0;
};

/// Keeps the last finished pictures for as long as the process lives, and nothing else.
class MemoryStore final : public Store {
 public:
  void put_job(const JobRecord& /*job*/) override {}
  void put_scene(const std::string& /*digest*/, const std::string& /*bytes*/) override {}
  void put_block(JobId /*job*/, std::uint64_t /*epoch*/, const std::string& /*bytes*/) override {}
  void put_picture(JobId job, const std::string& bytes) override {
    pictures_[job] = bytes;
    kept_bytes_ += bytes.size();
    while (kept_bytes_ > most_bytes && pictures_.size() > 1) {
      drop_job(pictures_.begin()->first);
    }
  }
  void drop_work(JobId /*job*/) override {}
  void drop_job(JobId job) override {
    if (const auto found = pictures_.find(job); found != pictures_.end()) {
      kept_bytes_ -= found->second.size();
      pictures_.erase(found);
    }
  }
  void commit() override {}
  std::vector<JobRecord> jobs() override { return {}; }
  std::optional<std::string> scene(const std::string& /*digest*/) override { return {}; }
  void each_block(JobId /*job*/, const BlockVisitor& /*visit*/) override {}
  std::optional<std::string> picture(JobId job) override {
    const auto found = pictures_.find(job);
    return found == pictures_.end() ? std::nullopt : std::optional(found->second);
  }

 private:
  static constexpr std::size_t most_bytes = std::size_t{1} << 32;
  std::map<JobId, std::string> pictures_;
  std::size_t kept_bytes_ = 0;
};

}  // namespace parray

#pragma once

#include <map>
#include <random>
#include <set>

#include "common/base/error.h"
#include "coordinator/store.h"

namespace parray::test {

/// A disk that forgets what was not committed when the coordinator dies, and whose commits may
/// fail, as on a full disk.
class CrashStore final : public Store {
 public:
  /// `failing`: probability that a commit throws instead.
  CrashStore(double failing, std::uint64_t seed) : failing_(failing), random_(seed) {}

  /// The coordinator has died: what is left is what was committed.
  void crash() { staged_ = committed_; }
  [[nodiscard]] bool has_block(JobId job, std::uint64_t epoch) const {
    const auto blocks = committed_.blocks.find(job);
    return blocks != committed_.blocks.end() && blocks->second.contains(epoch);
  }
  /// The job's blocks are gone because its picture is there.
  [[nodiscard]] bool has_picture(JobId job) const { return committed_.pictures.contains(job); }

  void put_job(const JobRecord& job) override { staged_.jobs[job.id] = job; }
  void put_scene(const std::string& digest, const std::string& bytes) override {
    staged_.scenes[digest] = bytes;
  }
  void put_block(JobId job, std::uint64_t epoch, const std::string& bytes) override {
    staged_.blocks[job][epoch] = bytes;
  }
  void put_picture(JobId job, const std::string& bytes) override { staged_.pictures[job] = bytes; }
  void drop_work(JobId job) override { staged_.blocks.erase(job); }
  void drop_job(JobId job) override { staged_.jobs.erase(job); }
  void commit() override {
    if (std::uniform_real_distribution<>(0, 1)(random_) < failing_) {
      throw RunError("keeping state: disk full");
    }
    committed_ = staged_;
  }

  std::vector<JobRecord> jobs() override {
    std::vector<JobRecord> all;
    for (const auto& [id, job] : staged_.jobs) {
      all.push_back(job);
    }
    return all;
  }
  std::optional<std::string> scene(const std::string& digest) override {
    const auto found = staged_.scenes.find(digest);
    return found == staged_.scenes.end() ? std::nullopt : std::optional(found->second);
  }
  void each_block(JobId job, const BlockVisitor& visit) override {
    for (const auto& [epoch, bytes] : staged_.blocks[job]) {
      visit(bytes);
    }
  }
  std::optional<std::string> picture(JobId job) override {
    const auto found = staged_.pictures.find(job);
    return found == staged_.pictures.end() ? std::nullopt : std::optional(found->second);
  }

 private:
  struct Content {
    std::map<JobId, JobRecord> jobs;
    std::map<std::string, std::string> scenes;
    std::map<JobId, std::map<std::uint64_t, std::string>> blocks;
    std::map<JobId, std::string> pictures;
  };

  double failing_;
  std::mt19937_64 random_;
  Content staged_;
  Content committed_;
};

}  // namespace parray::test

#pragma once

#include <algorithm>
#include <map>
#include <optional>
#include <random>
#include <utility>

#include "coordinator/store/store.h"
#include "tests/support/rooms.h"

namespace parray::test {

/// A store in memory that loses everything uncommitted when the coordinator crashes. Its commits
/// may fail, as on a full disk. A failed commit stores nothing, and the changes remain for the next
/// one.
class CrashStore : public Store {
 public:
  /// `failing` is the probability that a commit throws StorageFull.
  CrashStore(double failing, std::uint64_t seed) : failing_(failing), random_(seed) {}

  /// Loses everything uncommitted, as when the coordinator crashes.
  void crash() {
    staged_ = committed_;
    new_mark_.reset();
    new_reached_.clear();
  }
  /// Makes the disk full or not. While it is full, commits and puts of scenes and pictures fail.
  void fill(bool full) { full_ = full; }
  /// Returns the entries of the job's log that survive a crash.
  [[nodiscard]] const std::vector<std::string>& committed_rows(JobId job) const {
    static const std::vector<std::string> none;
    const auto rows = committed_.rows.find(job);
    return rows == committed_.rows.end() ? none : rows->second;
  }
  /// Returns whether the job has a picture. The store then has dropped the job's rows.
  [[nodiscard]] bool has_picture(JobId job) const { return committed_.pictures.contains(job); }

  void put_job(const JobRecord& job) override {
    changed_ = true;
    staged_.jobs[job.id] = job;
  }
  void put_scene(const std::string& digest, std::string_view bytes) override {
    take_room();
    changed_ = true;
    staged_.scenes.try_emplace(digest, bytes);
  }
  void append_rows(JobId job, std::string entry) override {
    changed_ = true;
    staged_.rows[job].push_back(std::move(entry));
  }
  void drop_rows(JobId job) override {
    changed_ = true;
    staged_.rows.erase(job);
  }
  void keep_rows(JobId job, std::uint64_t entries) override {
    changed_ = true;
    staged_.rows[job].resize(std::min<std::size_t>(staged_.rows[job].size(), entries));
  }
  void put_picture(JobId job, std::span<const std::string_view> pieces) override {
    take_room();
    std::string picture;
    for (const std::string_view piece : pieces) picture.append(piece);
    changed_ = true;
    staged_.pictures[job] = std::move(picture);
  }
  void drop_work(JobId job) override {
    changed_ = true;
    staged_.rows.erase(job);
    staged_.scenes_dropped = true;
  }
  void drop_job(JobId job) override {
    staged_.jobs.erase(job);
    staged_.pictures.erase(job);
    drop_work(job);
  }
  void put_note(const std::string& name, const std::string& text) override {
    changed_ = true;
    staged_.notes[name] = text;
  }
  void put_mark(const std::string& text) override {
    changed_ = true;
    new_mark_ = text;
  }
  void put_reached_mark(const std::string& text) override {
    put_mark("");
    new_reached_ = text;
  }
  void commit() override {
    take_room();
    if (std::uniform_real_distribution<>(0, 1)(random_) < failing_) {
      throw StorageFull("keeping state: disk full");
    }
    if (!std::exchange(changed_, false)) return;
    if (std::exchange(staged_.scenes_dropped, false)) {
      std::erase_if(staged_.scenes, [&](const auto& scene) { return !is_used(scene.first); });
    }
    staged_.mark = std::exchange(new_mark_, {}).value_or("");
    const std::string reached = staged_.mark.empty() ? new_reached_ : staged_.mark;
    staged_.reached = reached.empty() ? staged_.reached : reached;
    new_reached_.clear();
    committed_ = staged_;
  }

  Usage usage() override {
    Usage usage;
    for (const auto& [digest, bytes] : staged_.scenes) usage.total += bytes.size();
    for (const auto& [id, job] : staged_.jobs) {
      std::uint64_t own = picture_bytes(id);
      for (const std::string& entry : staged_.rows[id]) own += entry.size();
      usage.total += own;
      const auto scene = staged_.scenes.find(job.scene);
      usage.jobs[id] = own + (scene == staged_.scenes.end() ? 0 : scene->second.size());
    }
    return usage;
  }
  std::string note(const std::string& name) override {
    return find(staged_.notes, name).value_or("");
  }
  std::map<std::string, std::string> notes() override { return staged_.notes; }
  std::string mark() override { return new_mark_.value_or(staged_.mark); }
  std::string reached_mark() override { return staged_.reached; }
  std::vector<JobRecord> jobs() override {
    std::vector<JobRecord> all;
    for (const auto& [id, job] : staged_.jobs) all.push_back(job);
    return all;
  }
  std::optional<std::string> scene(const std::string& digest) override {
    return find(staged_.scenes, digest);
  }
  void each_rows(JobId job, const RowsVisitor& visit) override {
    for (const std::string& entry : staged_.rows[job]) visit(entry);
  }
  std::optional<std::string> picture(JobId job) override { return find(staged_.pictures, job); }
  std::uint64_t picture_bytes(JobId job) override {
    const auto found = staged_.pictures.find(job);
    return found == staged_.pictures.end() ? 0 : found->second.size();
  }
  void tidy(double /*keep_lost*/) override {}

 private:
  struct Content {
    std::map<JobId, JobRecord> jobs;
    std::map<std::string, std::string> scenes;
    std::map<JobId, std::vector<std::string>> rows;
    std::map<JobId, std::string> pictures;
    std::map<std::string, std::string> notes;
    std::string mark;
    std::string reached;
    bool scenes_dropped = false;
  };

  void take_room() const {
    if (full_) throw StorageFull("keeping state: disk full");
  }
  template <typename Map>
  static std::optional<std::string> find(const Map& map, const typename Map::key_type& key) {
    const auto found = map.find(key);
    return found == map.end() ? std::nullopt : std::optional(found->second);
  }
  [[nodiscard]] bool is_used(const std::string& digest) const {
    return std::any_of(staged_.jobs.begin(), staged_.jobs.end(), [&](const auto& job) {
      return job.second.scene == digest && needs_scene(job.second.state, job.second.keeps_scene());
    });
  }

  double failing_;
  bool full_ = false;
  bool changed_ = false;
  std::optional<std::string> new_mark_;
  std::string new_reached_;  ///< mark of the last put_reached_mark(); empty: none
  std::mt19937_64 random_;
  Content staged_;
  Content committed_;
};

}  // namespace parray::test

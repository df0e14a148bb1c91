#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "common/scene/settings.h"
#include "coordinator/store/disk_store.h"
#include "tests/support/rooms.h"

namespace parray::test {

/// Returns a digest with this first digit, all others 0.
inline std::string digest(char digit) {
  std::string text(64, '0');
  text[0] = digit;
  return text;
}

inline JobRecord stored_job(JobId id, JobState state = JobState::queued, char scene = 'a') {
  JobRecord job;
  job.id = id;
  job.token = "token-" + std::to_string(id);
  job.name = "a scene, with \"quotes\"";
  job.priority = 70;
  job.settings->precision = Precision::f64;
  job.settings->accelerator = AcceleratorKind::bvh;
  job.settings->row_order = RowOrder::interleaved;
  job.settings->seed = UINT64_MAX;
  job.precision_reason = "asked for";
  job.duplicates_removed = 5;
  job.load_seconds = 0.25;
  job.scene = digest(scene);
  job.state = state;
  return job;
}

inline void put_picture(Store& store, JobId job, std::string_view bytes) {
  store.put_picture(job, std::span(&bytes, 1));
}

inline std::vector<std::string> rows_of(Store& store, JobId job) {
  std::vector<std::string> rows;
  store.each_rows(job, [&](std::string_view entry) { rows.emplace_back(entry); });
  return rows;
}

/// The complete content of a store, with scenes a to f.
struct StoredState {
  std::map<JobId, std::string> records;
  std::map<JobId, std::vector<std::string>> rows;
  std::map<JobId, std::string> pictures;
  std::map<std::string, std::string> scenes;
  friend bool operator==(const StoredState&, const StoredState&) = default;
};

inline StoredState stored_state(Store& store) {
  StoredState state;
  for (const JobRecord& job : store.jobs()) {
    state.records[job.id] = record_to_json(job);
    state.rows[job.id] = rows_of(store, job.id);
    if (const auto picture = store.picture(job.id)) state.pictures[job.id] = *picture;
  }
  for (char name = 'a'; name <= 'f'; ++name) {
    if (const auto scene = store.scene(digest(name))) state.scenes[digest(name)] = *scene;
  }
  return state;
}

inline StoredState stored_state(const std::filesystem::path& directory) {
  DiskStore store(directory);
  return stored_state(store);
}

inline std::string file_bytes(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline void write_bytes(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

/// Copies the directory in its present state, as a killed process would leave it.
inline void copy_state(const std::filesystem::path& from, const std::filesystem::path& onto) {
  std::filesystem::remove_all(onto);
  std::filesystem::copy(from, onto, std::filesystem::copy_options::recursive);
}

/// Returns relative names and sizes of all plain files below the directory.
inline std::map<std::string, std::uint64_t> files_below(const std::filesystem::path& directory) {
  std::map<std::string, std::uint64_t> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(directory)) {
    if (entry.is_regular_file()) {
      files[entry.path().lexically_relative(directory).generic_string()] = entry.file_size();
    }
  }
  return files;
}

/// Returns the files of files_below() that contain scenes, rows and pictures. Leaves out `lost`.
inline std::vector<std::string> bulk_files(const std::filesystem::path& directory) {
  const std::set<std::string> records = {"reserve", "commits", "notes.json", "notes.next"};
  std::vector<std::string> names;
  for (const auto& [name, size] : files_below(directory)) {
    if (!name.starts_with("parray.sqlite") && !name.starts_with("lost/") &&
        name.find("/job.") == std::string::npos && !records.contains(name)) {
      names.push_back(name);
    }
  }
  return names;
}

}  // namespace parray::test

#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/sha256.h"
#include "coordinator/store/disk_store.h"
#include "tests/support/rooms.h"
#include "tests/support/stored_state.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {

inline const char* const scene_text = "the scene of all jobs";

inline std::string real_digest() { return sha256_hex(as_byte_span(scene_text)); }

inline JobRecord job_with(JobId id, JobState state) {
  JobRecord job = stored_job(id, state);
  job.name = "name of " + std::to_string(id);
  job.scene = real_digest();
  return job;
}

/// The acknowledged content of jobs.
struct Acknowledged {
  std::map<JobId, std::string> pictures;           ///< of done jobs
  std::map<JobId, std::vector<std::string>> rows;  ///< of unfinished jobs
};

inline void submit(Store& store, Acknowledged& acknowledged, JobId id) {
  store.put_scene(real_digest(), scene_text);
  store.put_job(job_with(id, JobState::queued));
  store.append_rows(id, "first row of " + std::to_string(id));
  store.commit();
  acknowledged.rows[id] = {"first row of " + std::to_string(id)};
}

inline void trace(Store& store, Acknowledged& acknowledged, JobId id) {
  const std::string row = "row " + std::string(id * 50, 'r');
  store.append_rows(id, row);
  store.commit();
  acknowledged.rows[id].push_back(row);
}

inline void finish(Store& store, Acknowledged& acknowledged, JobId id) {
  const std::string picture = "picture of " + std::to_string(id) + std::string(id * 100, 'p');
  put_picture(store, id, picture);
  store.put_job(job_with(id, JobState::done));
  store.drop_work(id);
  store.commit();
  acknowledged.rows.erase(id);
  acknowledged.pictures[id] = picture;
}

/// Puts job 1, which is done and keeps its scene for labels.
inline void put_labelled_job(Store& store, bool denoise) {
  JobRecord job = job_with(1, JobState::done);
  job.denoise = denoise;
  job.drawing = "{}";
  store.put_scene(real_digest(), scene_text);
  put_picture(store, 1, "picture");
  store.put_job(job);
  store.drop_work(1);
  store.commit();
}

/// Makes five jobs: 1, 2 and 3 are done, 5 is deleted, and 6 is committed with a note. Calls
/// `between` in the middle.
template <typename Between>
Acknowledged live(Store& store, const Between& between) {
  Acknowledged acknowledged;
  for (JobId id = 1; id <= 3; ++id) submit(store, acknowledged, id);
  finish(store, acknowledged, 1);
  between();
  for (JobId id = 4; id <= 6; ++id) {
    submit(store, acknowledged, id);
    trace(store, acknowledged, id - 1);
  }
  finish(store, acknowledged, 2);
  finish(store, acknowledged, 3);
  store.drop_job(5);
  store.put_note("workers", "some");
  store.commit();
  acknowledged.rows.erase(5);
  trace(store, acknowledged, 6);
  return acknowledged;
}

/// A state after `kill -9`, with all files open.
inline Acknowledged make_killed_state(const std::filesystem::path& directory,
                                      const std::filesystem::path& workshop) {
  DiskStore store(workshop);
  const Acknowledged acknowledged = live(store, [] {});
  copy_state(workshop, directory);
  return acknowledged;
}

inline bool names(const std::vector<std::string>& lines, JobId id) {
  const std::string number = std::to_string(id);
  return std::any_of(lines.begin(), lines.end(), [&](const std::string& line) {
    return line.find("job " + number) != std::string::npos ||
           line.find("jobs/" + number + "/") != std::string::npos;
  });
}

/// Checks that every acknowledged job is correct, or that `lines` name the job or the scene.
inline void check_all(const std::filesystem::path& directory, const Acknowledged& acknowledged,
                      std::vector<std::string> lines) {
  DiskStore store(directory);
  lines.insert(lines.end(), store.reports().begin(), store.reports().end());
  CAPTURE(doctest::toString(lines.size()));
  std::map<JobId, JobState> states;
  for (const JobRecord& job : store.jobs()) states[job.id] = job.state;
  const auto right = [&](const auto& what, const auto& expected) {
    try {
      return what() == expected;
    } catch (const RunError& error) {
      lines.emplace_back(error.what());
      return false;
    }
  };
  for (const auto& done : acknowledged.pictures) {
    const JobId id = done.first;  // Clang 14 does not capture a structured binding
    const bool there = states.contains(id) && states.at(id) == JobState::done &&
                       right([&] { return store.picture(id).value_or(""); }, done.second);
    CHECK_MESSAGE((there || names(lines, id)), "job " << id << " has lost its picture silently");
  }
  for (const auto& unfinished : acknowledged.rows) {
    const JobId id = unfinished.first;
    const bool there = states.contains(id) && states.at(id) == JobState::queued &&
                       right([&] { return rows_of(store, id); }, unfinished.second);
    CHECK_MESSAGE((there || names(lines, id)), "job " << id << " has lost rows silently");
  }
  CHECK_FALSE(states.contains(5));
}

inline void check_whole(const std::filesystem::path& directory, const Acknowledged& acknowledged) {
  check_all(directory, acknowledged, {});
  DiskStore store(directory);
  CHECK(store.reports() == std::vector<std::string>{});
  CHECK(store.jobs().size() == acknowledged.pictures.size() + acknowledged.rows.size());
  CHECK(store.scene(real_digest()) == scene_text);
  CHECK(store.note("workers") == "some");
}

}  // namespace parray::test

#include "coordinator/store/inspection.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>

#include "common/base/printable.h"
#include "common/base/sha256.h"

namespace parray::store {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Reads a copy. Returns nothing if the file is missing or, with `problem` set, damaged.
auto read_copy(const fs::path& file, const auto& read, std::string& problem)
    -> std::optional<decltype(read(std::string_view()))> {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return std::nullopt;
  const std::optional<std::string> text = text_of_file(file);
  if (!text) {
    problem = "it cannot be read";
    return std::nullopt;
  }
  try {
    return read(*text);
  } catch (const RunError& error) {
    problem = error.what();
    return std::nullopt;
  }
}

/// Returns whether two records are equal as JSON: versions may write them in different ways.
bool same_record(const std::string& a, const std::string& b) {
  if (a == b) return true;
  const json left = json::parse(a, nullptr, false);
  return !left.is_discarded() && left == json::parse(b, nullptr, false);
}

std::string name_of_job(JobId id) { return "jobs/" + std::to_string(id); }

class JobComparison {
 public:
  JobComparison(JobId id, const JobRow* row, const FoundJob& found, std::uint64_t batch,
                Comparison& result)
      : id_(id), row_(row), found_(found), batch_(batch), result_(result), json_(found.json) {}

  void run() {
    check_next();
    check_dropped();
    if (row_ != nullptr && row_->record) {
      if (row_->batch > batch_ || !row_matches_record(*row_)) {
        severe("the database's row of job " + std::to_string(id_) + " contradicts itself");
      }
      check_json();
    } else if (json_) {
      severe("the database has no job " + std::to_string(id_) + ", but " + file() + " exists");
    } else if (!found_.problem.empty()) {
      severe("the database has no job " + std::to_string(id_) + ", and " + file() +
             " is damaged: " + found_.problem);
    }
  }

 private:
  [[nodiscard]] std::string file() const { return name_of_job(id_) + "/job.json"; }
  void severe(std::string line) { result_.severe.push_back(std::move(line)); }
  void minor(std::string line) { result_.minor.push_back(std::move(line)); }

  void check_next() {
    if (!found_.next) return;
    if (found_.next->batch > batch_ + 1) {
      severe(name_of_job(id_) + "/job.next belongs to commit " +
             std::to_string(found_.next->batch) + ", but the database ends with commit " +
             std::to_string(batch_));
    } else if (row_ != nullptr && row_->record && row_->batch == found_.next->batch) {
      json_ = found_.next;
      result_.upkeep.finish.push_back(id_);
    } else {
      result_.upkeep.remove_next.push_back(id_);
    }
  }

  void check_dropped() {
    if (!found_.dropped) return;
    if (found_.dropped->batch > batch_) {
      severe(name_of_job(id_) + "/job.dropped is newer than the database");
    } else if (row_ == nullptr || !row_->record) {
      result_.upkeep.remove_dropped.push_back(id_);
    } else if (!json_) {
      json_ = found_.dropped;
      result_.upkeep.restore.push_back(id_);
    }
  }

  void check_json() {
    if (!json_ || json_->batch < row_->batch) {
      minor(file() + (json_                    ? " is older than the database"
                      : found_.problem.empty() ? " is missing"
                                               : " is damaged: " + found_.problem));
      result_.upkeep.rewrite.push_back(id_);
    } else if (json_->batch > row_->batch) {
      severe("the database's record of job " + std::to_string(id_) + " is older than " + file());
    } else if (!same_record(json_->record, *row_->record) || json_->picture != row_->picture ||
               !rows_follow()) {
      severe("the database's record of job " + std::to_string(id_) + " differs from " + file());
    }
  }

  /// Returns whether row and copy name the same rows file, and the row at least as many bytes.
  [[nodiscard]] bool rows_follow() const {
    if (!json_->rows || !row_->rows) return json_->rows.has_value() == row_->rows.has_value();
    return json_->rows->number == row_->rows->number && json_->rows->bytes <= row_->rows->bytes;
  }

  const JobId id_;
  const JobRow* const row_;  ///< null: the database does not have the job
  const FoundJob& found_;
  const std::uint64_t batch_;
  Comparison& result_;
  std::optional<JobFile> json_;  ///< the job.json that exists after upkeep
};

void compare_notes(const Records& records, const FoundFiles& found, Comparison& result) {
  std::optional<NotesFile> notes = found.notes;
  if (found.notes_next && found.notes_next->batch == records.notes_batch) {
    notes = found.notes_next;
    result.upkeep.finish_notes = true;
  }
  if (!notes || notes->batch < records.notes_batch) {
    if (records.notes_batch > 0) {
      result.minor.emplace_back("notes.json is missing, damaged or out of date");
      result.upkeep.rewrite_notes = true;
    }
  } else if (notes->batch > records.notes_batch) {
    result.severe.emplace_back("the database's notes are older than notes.json");
  } else if (notes_file_to_text({0, notes->notes}) != notes_file_to_text({0, records.notes})) {
    result.severe.emplace_back("the database's notes differ from notes.json");
  }
}

void compare_commits(const Records& records, const FoundFiles& found, Comparison& result) {
  if (found.commits && *found.commits > records.batch) {
    result.severe.push_back("the database ends with commit " + std::to_string(records.batch) +
                            ", but " + std::to_string(*found.commits) + " were completed");
  } else if (!found.commits && (found.has_commits || records.batch > 1)) {
    result.severe.push_back("the file 'commits' is " +
                            std::string(found.has_commits ? "damaged" : "missing") +
                            ": the database may lack commits");
  }
}

std::string_view kind_of(fs::file_type type) {
  switch (type) {
    case fs::file_type::regular: return "a file";
    case fs::file_type::directory: return "a directory";
    case fs::file_type::fifo: return "a pipe";
    case fs::file_type::socket: return "a socket";
    case fs::file_type::block:
    case fs::file_type::character: return "a device";
    default: return "no file";
  }
}

}  // namespace

FoundJob find_job(const StateFiles& files, JobId id) {
  const auto read = [id](std::string_view text) { return job_file_from_text(id, text); };
  FoundJob job;
  std::string ignored;
  job.next = read_copy(files.job_next(id), read, ignored);
  job.json = read_copy(files.job_json(id), read, job.problem);
  job.dropped = read_copy(files.job_dropped(id), read, ignored);
  return job;
}

FoundFiles find_notes(const StateFiles& files) {
  FoundFiles found;
  std::string problem;
  found.notes_next = read_copy(files.notes_next(), notes_file_from_text, problem);
  found.notes = read_copy(files.notes_json(), notes_file_from_text, problem);
  std::error_code error;
  found.has_commits = fs::exists(files.commits(), error);
  found.incomplete = fs::exists(files.incomplete(), error);
  if (const auto text = text_of_file(files.commits())) {
    found.commits = commit_count_from_text(*text);
  }
  return found;
}

FoundFiles find_files(const StateFiles& files) {
  std::map<JobId, FoundJob> jobs;
  for (const JobId id : files.jobs_with_directory()) jobs[id] = find_job(files, id);
  FoundFiles found = find_notes(files);
  found.jobs = std::move(jobs);
  return found;
}

Comparison compare(const Records& records, const FoundFiles& found) {
  Comparison result;
  if (found.incomplete) result.severe.emplace_back(unfinished_copy);
  for (const auto& [digest, file] : records.scenes) {
    if (!is_sha256_hex(digest)) {
      result.severe.push_back("parray.sqlite: '" + printable(digest, 80) +
                              "' is no scene's digest");
    }
  }
  static const FoundJob nothing;
  std::set<JobId> ids;
  for (const auto& [id, row] : records.jobs) ids.insert(id);
  for (const auto& [id, job] : found.jobs) ids.insert(id);
  for (const JobId id : ids) {
    const auto row = records.jobs.find(id);
    const auto job = found.jobs.find(id);
    JobComparison(id, row == records.jobs.end() ? nullptr : &row->second,
                  job == found.jobs.end() ? nothing : job->second, records.batch, result)
        .run();
  }
  compare_notes(records, found, result);
  compare_commits(records, found, result);
  return result;
}

void complete_row(JobId id, JobRow& row) {
  const JobRecord record = record_from_json(id, row.record.value_or(""));
  row.scene = record.scene;
  row.unfinished = needs_scene(record.state, record.keeps_scene());
}

bool row_matches_record(const JobRow& row) {
  const json record = json::parse(row.record.value_or(""), nullptr, false);
  const bool keeps = record.is_object() && (record.value("denoise", json()) == true ||
                                            record.value("drawing", json("")) != json(""));
  return record.is_object() && record.value("scene", json()) == row.scene &&
         record.value("state", json()).is_number_unsigned() &&
         needs_scene(static_cast<JobState>(record.value("state", 0)), keeps) == row.unfinished;
}

std::vector<Misplaced> find_misplaced(const StateFiles& files) {
  std::vector<Misplaced> found;
  const auto expect = [&](const fs::path& path, fs::file_type type) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (!fs::exists(status) || status.type() == type) return;
    found.push_back({path, path.lexically_relative(files.directory()).string() + " is " +
                               std::string(kind_of(status.type())) + ", not " +
                               std::string(kind_of(type))});
  };
  const auto expect_file = [&](const fs::path& path) { expect(path, fs::file_type::regular); };
  const auto expect_files_in = [&](const fs::path& directory) {
    std::error_code error;
    std::vector<fs::path> paths;
    for (fs::directory_iterator entry(directory, error), end; !error && entry != end;
         entry.increment(error)) {
      if (StateFiles::is_file_name(entry->path().filename().string())) {
        paths.push_back(entry->path());
      }
    }
    std::ranges::sort(paths);
    std::ranges::for_each(paths, expect_file);
  };
  for (const fs::path& file : {files.database(), files.notes_json(), files.notes_next(),
                               files.commits(), files.incomplete(), files.reserve()}) {
    expect_file(file);
    expect_file(StateFiles::temporary(file));
  }
  for (const char* suffix : {"-wal", "-shm", "-journal", ".new", ".new-journal"}) {
    expect_file(files.database().string() + suffix);
  }
  for (const fs::path& directory : {files.lost(), files.scenes(), files.jobs()}) {
    expect(directory, fs::file_type::directory);
  }
  expect_files_in(files.scenes());
  for (const JobId id : files.jobs_with_directory()) {
    expect(files.job(id), fs::file_type::directory);
    expect_files_in(files.job(id));
  }
  return found;
}

std::vector<std::string> move_misplaced_to_lost(StateFiles& files,
                                                const std::vector<Misplaced>& misplaced,
                                                std::uint64_t uptime) {
  std::vector<std::string> lines;
  for (const auto& [path, line] : misplaced) {
    if (!files.move_to_lost(path, uptime)) {
      throw RunError(line + ", and it cannot be moved to " + files.lost().string() +
                     ": move it away yourself");
    }
    lines.push_back(line + ": moved to lost/" + std::to_string(uptime));
  }
  return lines;
}

}  // namespace parray::store

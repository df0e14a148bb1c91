// Copies the files of a state while a coordinator may be writing them. Rows files grow, and small
// files are replaced as a whole. All other files are written once.
#include <fcntl.h>
#include <unistd.h>

#include <optional>
#include <system_error>

#include "coordinator/store/rebuild.h"
#include "coordinator/store/row_log.h"

namespace parray::store {
namespace {

namespace fs = std::filesystem;

constexpr int most_copies = 20;  // attempts for a job that changes meanwhile

class Copier {
 public:
  Copier(const StateFiles& from, StateFiles& onto) : from_(from), onto_(onto) {}

  std::vector<std::string> run() {
    for (const JobId id : from_.jobs_with_directory()) copy_job(id);
    if (const auto notes = committed_notes(from_)) {
      onto_.write(onto_.notes_json(), notes_file_to_text(*notes));
    }
    onto_.sync();
    const OpenPath directory(onto_.directory(), O_RDONLY | O_DIRECTORY);
    if (directory.get() < 0 || syncfs(directory.get()) != 0) {  // all that fs::copy_file() wrote
      throw RunError(onto_.directory().string() + ": the copy cannot be written to the disk");
    }
    return std::move(lines_);
  }

 private:
  void copy_job(JobId id) {
    for (int tries = 1;; ++tries) {
      std::string problem;
      const std::optional<JobFile> job = committed(id, problem);
      if (!job) {  // a commit is adding or dropping the job
        if (!problem.empty()) {
          lines_.push_back("left out: jobs/" + std::to_string(id) + "/job.json: " + problem);
        }
        return;
      }
      const std::optional<std::string> missing = copy_files(id, *job);
      const std::optional<JobFile> after = committed(id, problem);
      if (after && after->batch != job->batch && tries < most_copies) continue;
      if (!after && problem.empty()) {  // the job was dropped meanwhile
        std::error_code ignored;
        fs::remove_all(onto_.job(id), ignored);
        return;
      }
      if (missing) lines_.push_back("left out: " + *missing + ": it is missing, or is not a file");
      onto_.write(onto_.job_json(id), job_file_to_text(id, *job));
      return;
    }
  }

  /// Returns the committed copy of a job; nothing: none. Reads in the order of find_files().
  [[nodiscard]] std::optional<JobFile> committed(JobId id, std::string& problem) const {
    const FoundJob job = find_job(from_, id);
    const auto text = text_of_file(from_.commits());
    const std::uint64_t commits = text ? commit_count_from_text(*text).value_or(0) : 0;
    problem = job.problem;
    if (job.next && job.next->batch <= commits &&
        (!job.json || job.next->batch > job.json->batch)) {
      return job.next;
    }
    return job.json ? job.json : job.dropped;
  }

  /// Copies the files of a job. Returns the name of a file that is missing or not a file, if any.
  std::optional<std::string> copy_files(JobId id, const JobFile& job) {
    std::optional<std::string> missing;
    const auto copy = [&](const fs::path& from, const fs::path& onto) {
      if (!copy_file(from, onto)) missing = from.lexically_relative(from_.directory()).string();
    };
    if (job.rows) {
      copy(from_.rows(id, job.rows->number), onto_.rows(id, job.rows->number));
      StateFiles::cut(onto_.rows(id, job.rows->number),
                      sound_bytes(onto_.rows(id, job.rows->number)));
    }
    if (job.picture) {
      copy(from_.picture(id, job.picture->number), onto_.picture(id, job.picture->number));
    }
    JobRow row;
    row.record = job.record;
    complete_row(id, row);
    std::error_code ignored;
    if (row.unfinished && !fs::exists(onto_.scene(row.scene), ignored) &&
        fs::exists(from_.scene(row.scene), ignored)) {
      copy(from_.scene(row.scene), onto_.scene(row.scene));
    }
    return missing;
  }

  /// Returns false if the source is missing or not a file. Throws StorageFull if the target is
  /// full, RunError if copying fails for another reason.
  static bool copy_file(const fs::path& from, const fs::path& onto) {
    std::error_code error;
    if (!fs::is_regular_file(from, error)) return false;
    fs::create_directories(onto.parent_path(), error);
    if (!error) fs::copy_file(from, onto, fs::copy_options::overwrite_existing, error);
    if (error == std::errc::no_such_file_or_directory) return false;
    if (error && lacks_room(onto.parent_path(), from)) {
      throw StorageFull("copying " + from.string() + " to " + onto.string() + ": the disk is full");
    }
    if (error) {
      throw RunError("copying " + from.string() + " to " + onto.string() + ": " + error.message());
    }
    return true;
  }

  /// Returns whether a copy failed for lack of room, which the C++ library does not report.
  static bool lacks_room(const fs::path& directory, const fs::path& file) {
    std::error_code unknown;
    const std::uintmax_t room = fs::space(directory, unknown).available;
    return !unknown && room < fs::file_size(file, unknown) && !unknown;
  }

  const StateFiles& from_;
  StateFiles& onto_;
  std::vector<std::string> lines_;
};

}  // namespace

std::optional<NotesFile> committed_notes(const StateFiles& files) {
  const FoundFiles found = find_notes(files);
  const std::optional<NotesFile>& next = found.notes_next;
  const bool newer = next && next->batch <= found.commits.value_or(0) &&
                     (!found.notes || next->batch > found.notes->batch);
  return newer ? next : found.notes;
}

std::vector<std::string> copy_state(const StateFiles& from, StateFiles& onto) {
  const FoundFiles found = find_notes(from);
  if (!found.has_commits && !from.jobs_with_directory().empty()) {
    throw InputError(from.directory().string() +
                     ": the file 'commits' is missing: use --check to list the damage");
  }
  return Copier(from, onto).run();
}

}  // namespace parray::store

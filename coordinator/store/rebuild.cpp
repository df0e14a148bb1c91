#include "coordinator/store/rebuild.h"

#include <algorithm>
#include <cstdlib>
#include <set>
#include <system_error>

#include "coordinator/store/row_log.h"

namespace parray::store {
namespace {

namespace fs = std::filesystem;

std::string job_name(JobId id) { return "job " + std::to_string(id); }

class Rebuilder {
 public:
  Rebuilder(StateFiles& files, const Survey& survey, double now)
      : files_(files), survey_(survey), now_(now), trusts_database_(survey.severe.empty()) {}

  std::vector<std::string> run() {
    choose_notes();
    for (std::string& line : move_misplaced_to_lost(files_, survey_.misplaced, uptime_)) {
      report(std::move(line));
    }
    choose_jobs();
    choose_scenes();
    repair_files();
    report_unknown_ends();
    records_.batch = records_.notes_batch = newest_ + 1;
    for (auto& [id, row] : records_.jobs) row.batch = records_.batch;
    write_everything();
    return std::move(lines_);
  }

 private:
  void report(std::string line) { lines_.push_back(std::move(line)); }
  void note_batch(std::uint64_t batch) { newest_ = std::max(newest_, batch); }
  [[nodiscard]] const Records& database() const { return survey_.database.records; }

  void choose_notes() {
    const auto take = [this](std::uint64_t batch, const std::map<std::string, std::string>& notes) {
      note_batch(batch);
      if (batch >= notes_batch_) {
        notes_batch_ = batch;
        records_.notes = notes;
      }
    };
    take(database().notes_batch, database().notes);
    for (const auto& file : {survey_.found.notes_next, survey_.found.notes}) {
      if (file) take(file->batch, file->notes);
    }
    note_batch(database().batch);
    note_batch(survey_.found.commits.value_or(0));
    for (const auto& [id, job] : survey_.found.jobs) {
      for (const auto& file : {job.json, job.next, job.dropped}) note_batch(file ? file->batch : 0);
    }
    records_.reached = database().reached;  // but no mark, because content may be lost
    const auto uptime = records_.notes.find(uptime_note);
    uptime_ =
        uptime == records_.notes.end() ? 0 : std::strtoull(uptime->second.c_str(), nullptr, 10);
  }

  void choose_jobs() {
    std::set<JobId> ids;
    for (const auto& [id, row] : database().jobs) ids.insert(id);
    for (const auto& [id, job] : survey_.found.jobs) ids.insert(id);
    for (const JobId id : ids) choose_job(id);
  }

  void choose_job(JobId id) {
    const auto known = database().jobs.find(id);
    const JobRow* row = known == database().jobs.end() ? nullptr : &known->second;
    const auto found = survey_.found.jobs.find(id);
    static const FoundJob nothing;
    const FoundJob& job = found == survey_.found.jobs.end() ? nothing : found->second;
    const JobFile* copy = best_copy(row, job);
    const bool row_is_sound = row != nullptr && row->record && is_record(id, *row->record);
    if (row_is_sound && found == survey_.found.jobs.end() && newest_ > database().batch) {
      report("left out: " + job_name(id) + ": only the out-of-date database has it, and jobs/" +
             std::to_string(id) + " is missing: the job was deleted, or it is lost");
    } else if (row_is_sound && (copy == nullptr || row->batch > copy->batch)) {
      note_batch(row->batch);
      records_.jobs[id] = *row;
      complete_row(id, records_.jobs[id]);
    } else if (copy != nullptr && is_record(id, copy->record)) {
      take_copy(id, row, *copy);
    } else if (row != nullptr && row->record) {
      lose(id, "its record is damaged, and there is no undamaged copy");
    } else if (!job.problem.empty()) {
      lose(id, "jobs/" + std::to_string(id) + "/job.json is damaged (" + job.problem +
                   "), and the database does not have the job");
    } else if (!trusts_database_ && !job.next) {
      lose(id, "jobs/" + std::to_string(id) +
                   " has no job.json, and the database does not have the job");
    }
  }

  void lose(JobId id, const std::string& why) {
    report("lost: " + job_name(id) + ": " + why + ": submit it again");
    files_.move_to_lost(files_.job(id), uptime_);
  }

  /// Returns the newest valid copy; null: none, or the job was dropped. A damaged database cannot
  /// prove that a commit was completed. Then job.next and job.dropped count, too.
  [[nodiscard]] const JobFile* best_copy(const JobRow* row, const FoundJob& job) const {
    const JobFile* best = job.json ? &*job.json : nullptr;
    if (job.next) {
      const bool counts = !trusts_database_ || (row != nullptr && row->batch == job.next->batch);
      if (counts && (best == nullptr || job.next->batch > best->batch)) best = &*job.next;
    }
    if (best == nullptr && job.dropped && (row != nullptr || !trusts_database_)) {
      best = &*job.dropped;
    }
    return best;
  }

  static bool is_record(JobId id, const std::string& text) {
    try {
      record_from_json(id, text);
      return true;
    } catch (const RunError&) {
      return false;
    }
  }

  void take_copy(JobId id, const JobRow* row, const JobFile& copy) {
    JobRow& taken = records_.jobs[id];
    taken.record = copy.record;
    taken.rows = copy.rows;
    taken.picture = copy.picture;
    complete_row(id, taken);
    if (taken.rows && row != nullptr && row->rows && row->rows->number == taken.rows->number) {
      taken.rows->bytes = std::max(taken.rows->bytes, row->rows->bytes);
    }
    if (!trusts_database_ && !survey_.is_backup &&
        (row == nullptr || row->batch != copy.batch || !row->record)) {
      report(job_name(id) + " was restored from the copy in jobs/" + std::to_string(id));
    }
    if (!trusts_database_ && taken.rows) {  // appending results does not rewrite the copy
      taken.rows->bytes =
          std::max(taken.rows->bytes, sound_bytes(files_.rows(id, taken.rows->number)));
    }
  }

  void choose_scenes() {
    for (const auto& [id, row] : records_.jobs) {
      const auto known = database().scenes.find(row.scene);
      const bool as_known = known != database().scenes.end() &&
                            is_scene(files_.scene(row.scene), row.scene, &known->second);
      if (row.unfinished && !records_.scenes.contains(row.scene) &&
          (as_known || is_scene(files_.scene(row.scene), row.scene, nullptr))) {
        records_.scenes[row.scene] = *measure(files_.scene(row.scene));
      }
    }
  }

  void repair_files() {
    for (const FileDamage& damage : verify_files(files_, records_)) {
      JobRow& row = records_.jobs.at(damage.job);
      switch (damage.kind) {
        case FileDamage::Kind::rows: repair_rows(damage, row); break;
        case FileDamage::Kind::picture:
          if (row.picture) {
            files_.move_to_lost(files_.picture(damage.job, row.picture->number), uptime_);
            row.picture.reset();
          }
          fail(damage, row, "its picture is damaged or missing: submit the job again");
          break;
        case FileDamage::Kind::scene: lose_scene(damage, row); break;
      }
    }
  }

  /// Makes the job fail, or, if it is done, only gives up denoising and labels.
  void lose_scene(const FileDamage& damage, JobRow& row) {
    JobRecord record = record_from_json(damage.job, *row.record);
    if (record.state != JobState::done) {
      fail(damage, row, "its scene is damaged or missing: submit the job again");
      return;
    }
    report("lost: " + damage.line + ": " + job_name(damage.job) +
           " will be neither denoised nor labelled");
    record.denoise = false;
    record.drawing.clear();
    record.note(now_,
                "its scene is damaged or missing: its picture is neither denoised nor labelled");
    row.record = record_to_json(record);
    row.unfinished = needs_scene(record.state, record.keeps_scene());
  }

  void repair_rows(const FileDamage& damage, JobRow& row) {
    const fs::path file = files_.rows(damage.job, row.rows->number);
    const std::uint64_t sound = sound_bytes(file);
    report("lost: " + damage.line + ": " + job_name(damage.job) +
           " traces the rest again, if it is unfinished or queued again");
    const fs::path kept = file.string() + ".sound";
    std::error_code error;
    if (sound > 0) {
      fs::copy_file(file, kept, fs::copy_options::overwrite_existing, error);
      fs::resize_file(kept, sound, error);
    }
    files_.move_to_lost(file, uptime_);
    if (sound > 0) fs::rename(kept, file, error);
    if (error) throw RunError("repairing " + file.string() + " failed: " + error.message());
    if (sound > 0) {
      row.rows->bytes = sound;
    } else {
      row.rows.reset();
    }
  }

  /// Names the jobs whose log of results may end too early. Only the database stores the length of
  /// a log. So a log that lost whole entries together with a damaged database looks complete.
  void report_unknown_ends() {
    if (trusts_database_ || survey_.is_backup) return;
    for (const auto& [id, row] : records_.jobs) {
      if (row.rows && row.record && record_from_json(id, *row.record).state != JobState::done) {
        report(job_name(id) + " keeps " + std::to_string(row.rows->bytes) +
               " bytes of results. The database does not show whether results are missing. Missing "
               "results are traced again if the job is unfinished or queued again");
      }
    }
  }

  void fail(const FileDamage& damage, JobRow& row, const std::string& reason) {
    JobRecord record = record_from_json(damage.job, *row.record);
    report("lost: " + damage.line + ": " + job_name(damage.job) + " '" + record.name + "' fails");
    record.state = JobState::failed;
    record.reason = reason;
    record.report.clear();
    if (damage.kind == FileDamage::Kind::picture) record.course.forget_picture();
    record.note(now_, "failed: " + reason);
    row.record = record_to_json(record);
    row.unfinished = needs_scene(record.state, record.keeps_scene());
  }

  void write_everything() {
    write_database();
    for (const auto& [id, row] : records_.jobs) {
      if (row.record) {
        files_.write(files_.job_json(id),
                     job_file_to_text(id, {row.batch, *row.record, row.rows, row.picture}));
      }
      StateFiles::remove(files_.job_next(id));
    }
    files_.write(files_.notes_json(), notes_file_to_text({records_.notes_batch, records_.notes}));
    StateFiles::remove(files_.notes_next());
    files_.write(files_.commits(), commit_count_to_text(records_.batch));
    files_.sync();
  }

  /// Writes the database under another name first, so that the former one stays until then.
  void write_database() {
    const fs::path made = files_.database().string() + ".new";
    for (const char* suffix : {"", "-journal"}) StateFiles::remove(made.string() + suffix);
    {
      Database database(made);
      database.run("PRAGMA auto_vacuum = FULL");
      Transaction transaction(database);
      make_tables(database);
      write_records(database, records_);
      transaction.commit();
    }
    for (const char* suffix : {"-shm", "-wal", ""}) {
      const fs::path former = files_.database().string() + suffix;
      std::error_code ignored;
      if (fs::exists(former, ignored) && !files_.move_to_lost(former, uptime_)) {
        throw RunError("moving " + former.string() + " to " + files_.lost().string() + " failed");
      }
    }
    files_.rename(made, files_.database());
    files_.expect_sync(files_.directory());
  }

  StateFiles& files_;
  const Survey& survey_;
  const double now_;
  const bool trusts_database_;  ///< the database is undamaged: use it where no copy is newer
  Records records_;             ///< the chosen content
  std::uint64_t newest_ = 0;    ///< highest commit number in database and copies
  std::uint64_t notes_batch_ = 0;
  std::uint64_t uptime_ = 0;  ///< in seconds, names the folder in lost/
  std::vector<std::string> lines_;
};

}  // namespace

std::vector<std::string> rebuild_state(StateFiles& files, const Survey& survey, double now) {
  return Rebuilder(files, survey, now).run();
}

}  // namespace parray::store

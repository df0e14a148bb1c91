#include "coordinator/store/disk_store.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "coordinator/store/records.h"

namespace parray {
namespace {

namespace fs = std::filesystem;

/// The lowest number whose file is not there; `path_of` gives its path.
template <typename PathOf>
std::uint64_t free_number(const PathOf& path_of) {
  std::uint64_t number = 0;
  std::error_code ignored;
  while (fs::exists(path_of(number), ignored)) {
    ++number;
  }
  return number;
}

}  // namespace

const DiskStore::JobEntry* DiskStore::find(JobId job) const {
  const auto found = jobs_.find(job);
  return found == jobs_.end() ? nullptr : &found->second;
}

void DiskStore::put_job(const JobRecord& job) {
  std::string text = record_to_json(job);
  JobEntry& entry = jobs_[job.id];
  entry.scene = job.scene;
  entry.unfinished = needs_scene(job.state);
  entry.has_record = true;
  Change& change = changes_[job.id];
  change.record = change.copy = true;
  change.text = std::move(text);
}

void DiskStore::put_scene(const std::string& digest, std::string_view bytes) {
  const fs::path path = files_.scene(digest);
  if (scenes_.contains(digest)) {
    return;
  }
  scenes_[digest] = files_.write(path, std::span(&bytes, 1));
  new_scenes_.insert(digest);
}

void DiskStore::append_rows(JobId job, std::string entry) {
  std::optional<RowLog>& log = jobs_[job].log;
  if (!log) {
    log.emplace();
    log->number = free_number([&](std::uint64_t n) { return files_.rows(job, n); });
    changes_[job].copy = true;
  }
  log->fresh.append(std::move(entry));
  changes_[job].log = true;
}

void DiskStore::drop_log(JobId job, JobEntry& entry) {
  if (!entry.log) {
    return;
  }
  const fs::path rows = files_.rows(job, entry.log->number);
  entry.log.reset();
  Change& change = changes_[job];
  change.log = change.copy = true;
  // A file that was never written leaves its number to the next.
  if (std::error_code ignored; fs::exists(rows, ignored)) {
    change.doomed.push_back(rows);
  }
}

void DiskStore::drop_rows(JobId job) {
  if (const auto found = jobs_.find(job); found != jobs_.end()) {
    drop_log(job, found->second);
  }
}

void DiskStore::keep_rows(JobId job, std::uint64_t entries) {
  const auto found = jobs_.find(job);
  if (found == jobs_.end() || !found->second.log) {
    return;
  }
  RowLog& log = *found->second.log;
  log.committed = std::min(log.committed, bytes_of_entries(files_.rows(job, log.number), entries));
  log.fresh = {};
  Change& change = changes_[job];
  change.log = change.copy = true;
}

void DiskStore::drop_picture(JobId job, JobEntry& entry) {
  if (entry.picture) {
    Change& change = changes_[job];
    change.picture = change.copy = true;
    change.doomed.push_back(files_.picture(job, entry.picture->number));
    entry.picture.reset();
  }
}

void DiskStore::put_picture(JobId job, std::span<const std::string_view> pieces) {
  // A commit removes the file that this one replaces, even if it is gone already: another number.
  const JobEntry* entry_before = find(job);
  const KeptPicture* replaced =
      entry_before != nullptr && entry_before->picture ? &*entry_before->picture : nullptr;
  const std::uint64_t number = free_number([&](std::uint64_t n) {
    return replaced != nullptr && n == replaced->number ? files_.directory()
                                                        : files_.picture(job, n);
  });
  const WholeFile file = files_.write(files_.picture(job, number), pieces);
  JobEntry& entry = jobs_[job];
  drop_picture(job, entry);
  entry.picture = {number, file};
  Change& change = changes_[job];
  change.picture = change.copy = true;
}

void DiskStore::drop_work(JobId job) {
  drop_rows(job);
  scenes_dropped_ = true;
}

void DiskStore::drop_job(JobId job) {
  scenes_dropped_ = true;
  const auto found = jobs_.find(job);
  if (found == jobs_.end()) {
    return;
  }
  drop_log(job, found->second);
  drop_picture(job, found->second);
  jobs_.erase(found);
  Change& change = changes_[job];
  change.record = true;
  change.text.clear();
}

void DiskStore::put_note(const std::string& name, const std::string& text) {
  new_notes_[name] = text;
}

void DiskStore::put_mark(const std::string& text) { new_mark_ = text; }

void DiskStore::put_reached_mark(const std::string& text) {
  new_mark_ = "";
  new_reached_mark_ = text;
}

void DiskStore::commit() {
  if (changes_.empty() && new_scenes_.empty() && !scenes_dropped_ && new_notes_.empty() &&
      !new_mark_) {
    return;
  }
  check_place();
  std::exception_ptr failure;
  const std::set<JobId> held_back = write_logs(failure);
  const std::vector<std::string> unused = unused_scenes(held_back);
  try {
    keep(held_back, unused);
  } catch (const StorageFull&) {
    // A full disk must not keep anybody from making room on it.
    if (!frees_room(unused) || !files_.release_reserve()) {
      throw;
    }
    keep(held_back, unused);
  }
  settle(held_back, unused);
  files_.keep_reserve();
  if (failure) {
    std::rethrow_exception(failure);
  }
}

/// A database that was removed takes commits without a word.
void DiskStore::check_place() const {
  if (database_->moved()) {
    throw StorageFull("--state " + files_.directory().string() +
                      ": parray.sqlite was moved or removed: put it back");
  }
}

void DiskStore::keep(const std::set<JobId>& held_back, const std::vector<std::string>& unused) {
  if (!counts_commits_) {
    files_.overwrite(files_.commits(), commit_count_to_text(batch_));
  }
  write_copies(held_back);
  files_.sync();
  counts_commits_ = true;
  try {
    record(held_back, unused);
  } catch (const InputError& error) {  // it cannot be written any more
    throw StorageFull(error.what());
  }
}

/// Writes the copies of what the commit is about to record. Until it is done they stand beside the
/// former ones.
void DiskStore::write_copies(const std::set<JobId>& held_back) {
  for (const auto& [id, change] : changes_) {
    if (held_back.contains(id)) {
      StateFiles::remove(files_.job_next(id));  // of a commit that failed
    } else if (change.drops()) {
      StateFiles::remove(files_.job_next(id));
      if (std::error_code ignored; fs::exists(files_.job_json(id), ignored)) {
        files_.rename(files_.job_json(id), files_.job_dropped(id));
        files_.expect_sync(files_.job(id));
      }
    } else if (change.copy) {
      write_copy(id, change);
    }
  }
  if (!new_notes_.empty()) {
    files_.overwrite(files_.notes_next(), notes_file_to_text({batch_ + 1, notes()}));
  }
}

void DiskStore::write_copy(JobId job, const Change& change) {
  const JobEntry& entry = jobs_.at(job);
  if (!entry.has_record) {
    return;
  }
  JobFile copy{batch_ + 1, record_of(job, change), {}, entry.picture};
  if (entry.log) {
    copy.rows = {entry.log->number, entry.log->committed + entry.log->fresh.bytes()};
  }
  files_.overwrite(files_.job_next(job), job_file_to_text(job, copy));
}

std::string DiskStore::record_of(JobId job, const Change& change) {
  if (change.record) {
    return change.text;
  }
  Statement row(*database_, "SELECT record FROM jobs WHERE id = ?");
  row.bind(job);
  return row.step() ? std::string(row.bytes(0)) : "";
}

bool DiskStore::frees_room(const std::vector<std::string>& unused) const {
  return !unused.empty() || std::any_of(changes_.begin(), changes_.end(), [](const auto& changed) {
    return !changed.second.doomed.empty();
  });
}

/// Puts fresh rows into their files. Returns the jobs whose rows found no room there.
std::set<JobId> DiskStore::write_logs(std::exception_ptr& failure) {
  std::set<JobId> held_back;
  for (const auto& [id, change] : changes_) {
    const JobEntry* entry = find(id);
    if (entry == nullptr || !entry->log || entry->log->fresh.bytes() == 0) {
      continue;
    }
    try {
      const RowLog& log = *entry->log;
      files_.write_at(files_.rows(id, log.number), log.committed, log.fresh.pieces());
    } catch (const RunError&) {
      held_back.insert(id);
      failure = std::current_exception();
    }
  }
  return held_back;
}

std::vector<std::string> DiskStore::unused_scenes(const std::set<JobId>& held_back) const {
  std::vector<std::string> unused;
  if (!scenes_dropped_) {
    return unused;
  }
  std::set<std::string_view> used;
  for (const auto& [id, entry] : jobs_) {
    if (entry.unfinished || held_back.contains(id)) {
      used.insert(entry.scene);
    }
  }
  for (const auto& [digest, file] : scenes_) {
    if (!used.contains(digest)) {
      unused.push_back(digest);
    }
  }
  return unused;
}

void DiskStore::record(const std::set<JobId>& held_back, const std::vector<std::string>& unused) {
  Transaction transaction(*database_);
  for (const std::string& digest : new_scenes_) {
    write_scene(*database_, digest, scenes_.at(digest));
  }
  for (const std::string& digest : unused) {
    write_scene(*database_, digest, std::nullopt);
  }
  for (const auto& [name, text] : new_notes_) {
    write_note(*database_, name, text);
  }
  if (!new_notes_.empty()) {
    write_note(*database_, own_note::notes_batch, std::to_string(batch_ + 1));
  }
  for (const auto& [id, change] : changes_) {
    if (!held_back.contains(id)) {
      record_change(id, change);
    }
  }
  record_mark(held_back.empty());
  write_note(*database_, own_note::batch, std::to_string(batch_ + 1));
  transaction.commit();
}

void DiskStore::record_mark(bool everything) {
  if (everything && new_mark_ && !new_mark_->empty()) {
    write_note(*database_, own_note::mark, *new_mark_);
    write_note(*database_, own_note::reached, *new_mark_);
  } else {
    execute(*database_, "DELETE FROM notes WHERE name = ?", own_note::mark);
    if (everything && new_reached_mark_) {
      write_note(*database_, own_note::reached, *new_reached_mark_);
    }
  }
}

void DiskStore::record_change(JobId job, const Change& change) {
  const JobEntry* entry = find(job);
  if (change.drops()) {
    execute(*database_, "DELETE FROM jobs WHERE id = ?", job);
  } else if (change.record) {
    execute(*database_, "INSERT OR REPLACE INTO jobs VALUES (?, ?, ?, ?, ?)", job, entry->scene,
            std::uint64_t{entry->unfinished ? 1U : 0U}, change.text, batch_ + 1);
  } else if (change.copy) {
    execute(*database_, "UPDATE jobs SET batch = ? WHERE id = ?", batch_ + 1, job);
  }
  if (change.log) {
    const bool kept = entry != nullptr && entry->log;
    write_rows(*database_, job,
               kept ? std::optional(RowsFile{entry->log->number,
                                             entry->log->committed + entry->log->fresh.bytes()})
                    : std::nullopt);
  }
  if (change.picture) {
    write_picture(*database_, job, entry != nullptr ? entry->picture : std::nullopt);
  }
}

/// What was committed is no change any more, and its files that nobody needs go.
void DiskStore::settle(const std::set<JobId>& held_back, const std::vector<std::string>& unused) {
  ++batch_;
  log_is_fresh_ = false;
  files_.overwrite_later(files_.commits(), commit_count_to_text(batch_));
  if (!new_notes_.empty()) {
    put_in_place(files_.notes_next(), files_.notes_json());
  }
  new_scenes_.clear();
  new_notes_.clear();
  if (held_back.empty()) {
    new_mark_.reset();
    new_reached_mark_.reset();
  }
  std::erase_if(changes_, [&](const auto& changed) {
    if (held_back.contains(changed.first)) {
      return false;
    }
    settle_change(changed.first, changed.second);
    return true;
  });
  for (const std::string& digest : unused) {
    scenes_.erase(digest);
    StateFiles::remove(files_.scene(digest));
  }
  scenes_dropped_ = scenes_dropped_ && !held_back.empty();
}

void DiskStore::settle_change(JobId job, const Change& change) {
  const auto found = jobs_.find(job);
  if (found != jobs_.end() && found->second.log) {
    RowLog& log = *found->second.log;
    log.committed += log.fresh.bytes();
    log.fresh = {};
  }
  if (change.copy && found != jobs_.end() && found->second.has_record) {
    put_in_place(files_.job_next(job), files_.job_json(job));
  }
  for (const fs::path& file : change.doomed) {
    StateFiles::remove(file);
  }
  if (change.drops()) {
    StateFiles::remove(files_.job_dropped(job));
  }
  if (!change.doomed.empty() || change.drops()) {
    StateFiles::remove(files_.job(job));  // if it is empty now
  }
}

/// Failing, it leaves that to the next opening.
void DiskStore::put_in_place(const fs::path& next, const fs::path& current) {
  try {
    files_.rename(next, current);
  } catch (const RunError&) {
    return;
  }
}

Store::Usage DiskStore::usage() {
  Usage usage;
  usage.total = lost_bytes_;
  const auto bytes_of = [](const auto& file) { return file.bytes; };
  for (const auto& [digest, file] : scenes_) {
    usage.total += bytes_of(file);
  }
  for (const auto& [id, entry] : jobs_) {
    const std::uint64_t own = (entry.log ? entry.log->committed : 0) +
                              (entry.picture ? bytes_of(entry.picture->file) : 0);
    const auto scene = scenes_.find(entry.scene);
    usage.total += own;
    usage.jobs[id] = own + (scene == scenes_.end() ? 0 : bytes_of(scene->second));
  }
  return usage;
}

std::string DiskStore::note(const std::string& name) {
  if (const auto fresh = new_notes_.find(name); fresh != new_notes_.end()) {
    return fresh->second;
  }
  Statement row(*database_, "SELECT text FROM notes WHERE name = ?");
  row.bind(name);
  return row.step() ? std::string(row.bytes(0)) : "";
}

std::map<std::string, std::string> DiskStore::notes() {
  std::map<std::string, std::string> notes = new_notes_;
  Statement rows(*database_, "SELECT name, text FROM notes");
  while (rows.step()) {
    notes.try_emplace(std::string(rows.bytes(0)), rows.bytes(1));
  }
  erase_own_notes(notes);
  return notes;
}

std::string DiskStore::mark() { return new_mark_ ? *new_mark_ : note(std::string(own_note::mark)); }

std::vector<JobRecord> DiskStore::jobs() {
  std::map<JobId, std::string> texts;
  Statement rows(*database_, "SELECT id, record FROM jobs");
  while (rows.step()) {
    texts[rows.number(0)] = rows.bytes(1);
  }
  for (const auto& [id, change] : changes_) {
    if (change.record && change.text.empty()) {
      texts.erase(id);
    } else if (change.record) {
      texts[id] = change.text;
    }
  }
  std::vector<JobRecord> jobs;
  jobs.reserve(texts.size());
  for (const auto& [id, text] : texts) {
    jobs.push_back(record_from_json(id, text));
  }
  return jobs;
}

std::optional<std::string> DiskStore::scene(const std::string& digest) {
  const auto found = scenes_.find(digest);
  if (found == scenes_.end()) {
    return std::nullopt;
  }
  return StateFiles::read(files_.scene(digest), found->second);
}

void DiskStore::each_rows(JobId job, const RowsVisitor& visit) {
  if (const JobEntry* entry = find(job); entry != nullptr && entry->log) {
    each_entry_in(files_.rows(job, entry->log->number), entry->log->committed, visit);
    entry->log->fresh.each(visit);
  }
}

std::optional<std::string> DiskStore::picture(JobId job) {
  const JobEntry* entry = find(job);
  if (entry == nullptr || !entry->picture) {
    return std::nullopt;
  }
  return StateFiles::read(files_.picture(job, entry->picture->number), entry->picture->file);
}

std::uint64_t DiskStore::picture_bytes(JobId job) {
  const JobEntry* entry = find(job);
  return entry == nullptr || !entry->picture ? 0 : entry->picture->file.bytes;
}

}  // namespace parray

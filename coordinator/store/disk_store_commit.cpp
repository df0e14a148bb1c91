// The commit of a DiskStore.
#include <algorithm>

#include "coordinator/store/disk_store.h"
#include "coordinator/store/records.h"

namespace parray::store {

namespace fs = std::filesystem;

void DiskStore::commit() {
  if (changes_.empty() && new_scenes_.empty() && !scenes_dropped_ && new_notes_.empty() &&
      !new_mark_) {
    return;
  }
  if (database_->moved()) {  // SQLite reports no error then
    throw StorageFull(files_.directory().string() +
                      ": the file parray.sqlite was moved or removed: put it back, or stop this "
                      "coordinator and use --repair");
  }
  std::exception_ptr failure;
  const std::set<JobId> held_back = write_logs(failure);
  const std::vector<std::string> unused = unused_scenes(held_back);
  try {
    write(held_back, unused);
  } catch (const StorageFull&) {
    // A commit that frees room must succeed on a full disk. So it may use the reserve.
    if (!frees_room(unused) || !files_.release_reserve()) throw;
    write(held_back, unused);
  }
  finish(held_back, unused);
  files_.keep_reserve();
  if (failure) std::rethrow_exception(failure);
}

void DiskStore::write(const std::set<JobId>& held_back, const std::vector<std::string>& unused) {
  if (!counts_commits_) files_.overwrite(files_.commits(), commit_count_to_text(batch_));
  write_copies(held_back);
  for (const auto& [digest, bytes] : new_scenes_) {  // a failed sync may have lost small scenes
    if (sync_failed_ && !bytes.empty()) files_.overwrite(files_.scene(digest), bytes);
  }
  sync_failed_ = true;
  files_.sync();
  sync_failed_ = false;
  counts_commits_ = true;
  try {
    write_records(held_back, unused);
  } catch (const InputError& error) {  // the database is no longer writable
    throw StorageFull(error.what());
  }
}

/// Writes the copies of the new records. The former copies stay until the commit is done.
void DiskStore::write_copies(const std::set<JobId>& held_back) {
  for (const auto& [id, change] : changes_) {
    if (held_back.contains(id)) {
      StateFiles::remove(files_.job_next(id));  // left by a failed commit
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
  if (!entry.has_record) return;
  JobFile copy{batch_ + 1, record_of(job, change), {}, entry.picture};
  if (entry.log) copy.rows = {entry.log->number, entry.log->committed + entry.log->pending.bytes()};
  files_.overwrite(files_.job_next(job), job_file_to_text(job, copy));
}

std::string DiskStore::record_of(JobId job, const Change& change) {
  if (change.record) return change.text;
  Statement row(*database_, "SELECT record FROM jobs WHERE id = ?");
  row.bind(job);
  return row.step() ? std::string(row.bytes(0)) : "";
}

bool DiskStore::frees_room(const std::vector<std::string>& unused) const {
  return !unused.empty() || std::ranges::any_of(changes_, [](const auto& changed) {
    return !changed.second.files_to_remove.empty();
  });
}

/// Appends pending entries to their files. Returns the jobs whose entries could not be written.
std::set<JobId> DiskStore::write_logs(std::exception_ptr& failure) {
  std::set<JobId> held_back;
  for (const auto& [id, change] : changes_) {
    const JobEntry* entry = find(id);
    if (entry == nullptr || !entry->log || entry->log->pending.bytes() == 0) continue;
    try {
      const RowLog& log = *entry->log;
      files_.write_at(files_.rows(id, log.number), log.committed, log.pending.pieces());
    } catch (const RunError&) {
      held_back.insert(id);
      failure = std::current_exception();
    }
  }
  return held_back;
}

std::vector<std::string> DiskStore::unused_scenes(const std::set<JobId>& held_back) const {
  std::vector<std::string> unused;
  if (!scenes_dropped_) return unused;
  std::set<std::string_view> used;
  for (const auto& [id, entry] : jobs_) {
    if (entry.unfinished || held_back.contains(id)) used.insert(entry.scene);
  }
  for (const auto& [digest, file] : scenes_) {
    if (!used.contains(digest)) unused.push_back(digest);
  }
  return unused;
}

void DiskStore::write_records(const std::set<JobId>& held_back,
                              const std::vector<std::string>& unused) {
  Transaction transaction(*database_);
  for (const auto& [digest, bytes] : new_scenes_) {
    write_scene(*database_, digest, scenes_.at(digest));
  }
  for (const std::string& digest : unused) write_scene(*database_, digest, std::nullopt);
  for (const auto& [name, text] : new_notes_) write_note(*database_, name, text);
  if (!new_notes_.empty()) {
    write_note(*database_, own_note::notes_batch, std::to_string(batch_ + 1));
  }
  for (const auto& [id, change] : changes_) {
    if (!held_back.contains(id)) write_change(id, change);
  }
  write_mark(held_back.empty());
  write_note(*database_, own_note::batch, std::to_string(batch_ + 1));
  transaction.commit();
}

void DiskStore::write_mark(bool everything) {
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

void DiskStore::write_change(JobId job, const Change& change) {
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
                                             entry->log->committed + entry->log->pending.bytes()})
                    : std::nullopt);
  }
  if (change.picture) {
    write_picture(*database_, job, entry != nullptr ? entry->picture : std::nullopt);
  }
}

/// Forgets the committed changes and removes files that the database no longer names.
void DiskStore::finish(const std::set<JobId>& held_back, const std::vector<std::string>& unused) {
  ++batch_;
  database_log_is_empty_ = false;
  files_.overwrite_later(files_.commits(), commit_count_to_text(batch_));
  if (!new_notes_.empty()) put_in_place(files_.notes_next(), files_.notes_json());
  new_scenes_.clear();
  new_notes_.clear();
  if (held_back.empty()) {
    new_mark_.reset();
    new_reached_mark_.reset();
  }
  std::erase_if(changes_, [&](const auto& changed) {
    if (held_back.contains(changed.first)) return false;
    finish_change(changed.first, changed.second);
    return true;
  });
  for (const std::string& digest : unused) {
    scenes_.erase(digest);
    StateFiles::remove(files_.scene(digest));
  }
  scenes_dropped_ = scenes_dropped_ && !held_back.empty();
}

void DiskStore::finish_change(JobId job, const Change& change) {
  const auto found = jobs_.find(job);
  if (found != jobs_.end() && found->second.log) {
    RowLog& log = *found->second.log;
    log.committed += log.pending.bytes();
    log.pending = {};
  }
  if (change.copy && found != jobs_.end() && found->second.has_record) {
    put_in_place(files_.job_next(job), files_.job_json(job));
  }
  for (const fs::path& file : change.files_to_remove) StateFiles::remove(file);
  if (change.drops()) StateFiles::remove(files_.job_dropped(job));
  if (!change.files_to_remove.empty() || change.drops()) {
    StateFiles::remove(files_.job(job));  // only if it is empty
  }
}

/// Renames a file. After a failure, the next opening renames it.
void DiskStore::put_in_place(const fs::path& next, const fs::path& current) {
  try {
    files_.rename(next, current);
  } catch (const RunError&) {
    return;
  }
}

}  // namespace parray::store

#include "coordinator/store/disk_store.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "coordinator/store/records.h"

namespace parray::store {

namespace fs = std::filesystem;

/// Returns the lowest number whose file, path_of(number), does not exist.
static std::uint64_t free_number(const auto& path_of) {
  std::uint64_t number = 0;
  std::error_code ignored;
  while (fs::exists(path_of(number), ignored)) ++number;
  return number;
}

const DiskStore::JobEntry* DiskStore::find(JobId job) const {
  const auto found = jobs_.find(job);
  return found == jobs_.end() ? nullptr : &found->second;
}

void DiskStore::put_job(const JobRecord& job) {
  std::string text = record_to_json(job);
  JobEntry& entry = jobs_[job.id];
  entry.scene = job.scene;
  entry.unfinished = needs_scene(job.state, job.keeps_scene());
  entry.has_record = true;
  Change& change = changes_[job.id];
  change.record = change.copy = true;
  change.text = std::move(text);
}

void DiskStore::put_scene(const std::string& digest, std::string_view bytes) {
  const fs::path path = files_.scene(digest);
  if (scenes_.contains(digest)) return;
  constexpr std::size_t large = 1 << 20;  // bytes that take longer to write than to sync
  if (bytes.size() >= large) {
    scenes_[digest] = files_.write(path, bytes);
    new_scenes_[digest] = "";
    return;
  }
  try {
    files_.overwrite(path, bytes);
  } catch (const RunError&) {
    StateFiles::remove(path);
    throw;
  }
  scenes_[digest] = whole_file_of(std::span(&bytes, 1));
  new_scenes_[digest] = bytes;
}

void DiskStore::append_rows(JobId job, std::string entry) {
  std::optional<RowLog>& log = jobs_[job].log;
  if (!log) {
    log.emplace();
    log->number = free_number([&](std::uint64_t n) { return files_.rows(job, n); });
    changes_[job].copy = true;
  }
  log->pending.append(std::move(entry));
  changes_[job].log = true;
}

void DiskStore::drop_log(JobId job, JobEntry& entry) {
  if (!entry.log) return;
  const fs::path rows = files_.rows(job, entry.log->number);
  entry.log.reset();
  Change& change = changes_[job];
  change.log = change.copy = true;
  // If the file was never written, the next file gets the same number.
  if (std::error_code ignored; fs::exists(rows, ignored)) change.files_to_remove.push_back(rows);
}

void DiskStore::drop_rows(JobId job) {
  if (const auto found = jobs_.find(job); found != jobs_.end()) drop_log(job, found->second);
}

void DiskStore::keep_rows(JobId job, std::uint64_t entries) {
  const auto found = jobs_.find(job);
  if (found == jobs_.end() || !found->second.log) return;
  RowLog& log = *found->second.log;
  log.committed = std::min(log.committed, bytes_of_entries(files_.rows(job, log.number), entries));
  log.pending = {};
  Change& change = changes_[job];
  change.log = change.copy = true;
}

void DiskStore::drop_picture(JobId job, JobEntry& entry) {
  if (entry.picture) {
    Change& change = changes_[job];
    change.picture = change.copy = true;
    change.files_to_remove.push_back(files_.picture(job, entry.picture->number));
    entry.picture.reset();
  }
}

void DiskStore::put_picture(JobId job, std::span<const std::string_view> pieces) {
  // The commit removes the replaced file, even if it is missing now. So never use its number.
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
  if (found == jobs_.end()) return;
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

void DiskStore::put_reached_mark(const std::string& text) {
  new_mark_ = "";
  new_reached_mark_ = text;
}

Store::Usage DiskStore::usage() {
  Usage usage;
  usage.total = lost_bytes_;
  const auto bytes_of = [](const auto& file) { return file.bytes; };
  for (const auto& [digest, file] : scenes_) usage.total += bytes_of(file);
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
  if (const auto fresh = new_notes_.find(name); fresh != new_notes_.end()) return fresh->second;
  Statement row(*database_, "SELECT text FROM notes WHERE name = ?");
  row.bind(name);
  return row.step() ? std::string(row.bytes(0)) : "";
}

std::map<std::string, std::string> DiskStore::notes() {
  std::map<std::string, std::string> notes = new_notes_;
  Statement rows(*database_, "SELECT name, text FROM notes");
  while (rows.step()) notes.try_emplace(std::string(rows.bytes(0)), rows.bytes(1));
  erase_own_notes(notes);
  return notes;
}

std::string DiskStore::mark() { return new_mark_ ? *new_mark_ : note(std::string(own_note::mark)); }

std::vector<JobRecord> DiskStore::jobs() {
  std::map<JobId, std::string> texts;
  Statement rows(*database_, "SELECT id, record FROM jobs");
  while (rows.step()) texts[rows.number(0)] = rows.bytes(1);
  for (const auto& [id, change] : changes_) {
    if (change.record && change.text.empty()) {
      texts.erase(id);
    } else if (change.record) {
      texts[id] = change.text;
    }
  }
  std::vector<JobRecord> jobs;
  jobs.reserve(texts.size());
  for (const auto& [id, text] : texts) jobs.push_back(record_from_json(id, text));
  return jobs;
}

std::optional<std::string> DiskStore::scene(const std::string& digest) {
  const auto found = scenes_.find(digest);
  if (found == scenes_.end()) return std::nullopt;
  return StateFiles::read(files_.scene(digest), found->second);
}

void DiskStore::each_rows(JobId job, const RowsVisitor& visit) {
  if (const JobEntry* entry = find(job); entry != nullptr && entry->log) {
    each_entry_in(files_.rows(job, entry->log->number), entry->log->committed, visit);
    entry->log->pending.each(visit);
  }
}

std::optional<std::string> DiskStore::picture(JobId job) {
  const JobEntry* entry = find(job);
  if (entry == nullptr || !entry->picture) return std::nullopt;
  return StateFiles::read(files_.picture(job, entry->picture->number), entry->picture->file);
}

std::uint64_t DiskStore::picture_bytes(JobId job) {
  const JobEntry* entry = find(job);
  return entry == nullptr || !entry->picture ? 0 : entry->picture->file.bytes;
}

}  // namespace parray::store

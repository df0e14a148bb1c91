#include "coordinator/store/disk_store.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "coordinator/store/schema.h"

namespace parray {
namespace {

namespace fs = std::filesystem;

/// The mark stands among the notes.
constexpr const char* mark_name = "mark";

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

void remove_file(const fs::path& path) {
  std::error_code ignored;  // the next life tries again
  fs::remove(path, ignored);
}

}  // namespace

DiskStore::DiskStore(const fs::path& directory, Disk& disk) : files_(directory, disk) {
  try {
    database_ = std::make_unique<Database>(files_.directory() / "parray.sqlite");
    ready_database(*database_, files_);
    load();
  } catch (const StorageFull& error) {
    throw InputError(error.what());
  }
  remove_leftovers();
}

DiskStore::~DiskStore() = default;

void DiskStore::load() {
  Statement jobs(*database_, "SELECT id, scene, unfinished FROM jobs");
  while (jobs.step()) {
    jobs_[jobs.number(0)] = {std::string(jobs.bytes(1)), jobs.number(2) != 0};
  }
  Statement scenes(*database_, "SELECT digest, bytes, checksum FROM scenes");
  while (scenes.step()) {
    scenes_[std::string(scenes.bytes(0))] = {scenes.number(1), scenes.number(2)};
  }
  Statement logs(*database_, "SELECT job, number, bytes FROM logs");
  while (logs.step()) {
    jobs_[logs.number(0)].log = {logs.number(1), logs.number(2)};
  }
  Statement pictures(*database_, "SELECT job, number, bytes, checksum FROM pictures");
  while (pictures.step()) {
    jobs_[pictures.number(0)].picture = {pictures.number(1),
                                         {pictures.number(2), pictures.number(3)}};
  }
}

void DiskStore::remove_leftovers() const {
  std::set<fs::path> named;
  for (const auto& [digest, file] : scenes_) {
    named.insert(files_.scene(digest));
  }
  for (const auto& [id, entry] : jobs_) {
    if (entry.log) {
      const fs::path rows = files_.rows(id, entry.log->number);
      StateFiles::cut(rows, entry.log->committed);
      named.insert(rows);
    }
    if (entry.picture) {
      named.insert(files_.picture(id, entry.picture->number));
    }
  }
  files_.remove_leftovers(named);
}

const DiskStore::JobEntry* DiskStore::find(JobId job) const {
  const auto found = jobs_.find(job);
  return found == jobs_.end() ? nullptr : &found->second;
}

void DiskStore::put_job(const JobRecord& job) {
  std::string text = record_to_json(job);
  JobEntry& entry = jobs_[job.id];
  entry.scene = job.scene;
  entry.unfinished = needs_scene(job.state);
  Change& change = changes_[job.id];
  change.record = true;
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
  change.log = true;
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

void DiskStore::drop_picture(JobId job, JobEntry& entry) {
  if (entry.picture) {
    Change& change = changes_[job];
    change.picture = true;
    change.doomed.push_back(files_.picture(job, entry.picture->number));
    entry.picture.reset();
  }
}

void DiskStore::put_picture(JobId job, std::span<const std::string_view> pieces) {
  const std::uint64_t number = free_number([&](std::uint64_t n) { return files_.picture(job, n); });
  const WholeFile file = files_.write(files_.picture(job, number), pieces);
  JobEntry& entry = jobs_[job];
  drop_picture(job, entry);
  entry.picture = {number, file};
  changes_[job].picture = true;
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

void DiskStore::commit() {
  if (changes_.empty() && new_scenes_.empty() && !scenes_dropped_ && new_notes_.empty() &&
      !new_mark_) {
    return;
  }
  std::exception_ptr failure;
  const std::set<JobId> held_back = write_logs(failure);
  files_.sync_directories();
  const std::vector<std::string> unused = unused_scenes(held_back);
  try {
    record(held_back, unused);
  } catch (const StorageFull&) {
    // A full disk must not keep anybody from making room on it.
    if (!frees_room(unused) || !files_.release_reserve()) {
      throw;
    }
    record(held_back, unused);
  }
  settle(held_back, unused);
  files_.keep_reserve();
  if (failure) {
    std::rethrow_exception(failure);
  }
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
    const WholeFile& file = scenes_.at(digest);
    execute(*database_, "INSERT OR REPLACE INTO scenes VALUES (?, ?, ?)", digest, file.bytes,
            file.checksum);
  }
  for (const std::string& digest : unused) {
    execute(*database_, "DELETE FROM scenes WHERE digest = ?", digest);
  }
  for (const auto& [name, text] : new_notes_) {
    execute(*database_, "INSERT OR REPLACE INTO notes VALUES (?, ?)", name, text);
  }
  for (const auto& [id, change] : changes_) {
    if (!held_back.contains(id)) {
      record_change(id, change);
    }
  }
  record_mark(held_back.empty());
  transaction.commit();
}

void DiskStore::record_mark(bool everything) {
  if (everything && new_mark_) {
    execute(*database_, "INSERT OR REPLACE INTO notes VALUES (?, ?)", std::string_view(mark_name),
            *new_mark_);
  } else {
    execute(*database_, "DELETE FROM notes WHERE name = ?", std::string_view(mark_name));
  }
}

void DiskStore::record_change(JobId job, const Change& change) {
  const JobEntry* entry = find(job);
  if (change.record && change.text.empty()) {
    execute(*database_, "DELETE FROM jobs WHERE id = ?", job);
  } else if (change.record) {
    execute(*database_, "INSERT OR REPLACE INTO jobs VALUES (?, ?, ?, ?)", job, entry->scene,
            std::uint64_t{entry->unfinished ? 1U : 0U}, change.text);
  }
  if (change.log) {
    record_log(job, entry);
  }
  if (change.picture) {
    record_picture(job, entry);
  }
}

void DiskStore::record_log(JobId job, const JobEntry* entry) {
  if (entry == nullptr || !entry->log) {
    execute(*database_, "DELETE FROM logs WHERE job = ?", job);
    return;
  }
  execute(*database_, "INSERT OR REPLACE INTO logs VALUES (?, ?, ?)", job, entry->log->number,
          entry->log->committed + entry->log->fresh.bytes());
}

void DiskStore::record_picture(JobId job, const JobEntry* entry) {
  if (entry == nullptr || !entry->picture) {
    execute(*database_, "DELETE FROM pictures WHERE job = ?", job);
    return;
  }
  execute(*database_, "INSERT OR REPLACE INTO pictures VALUES (?, ?, ?, ?)", job,
          entry->picture->number, entry->picture->file.bytes, entry->picture->file.checksum);
}

/// What was committed is no change any more, and its files that nobody needs go.
void DiskStore::settle(const std::set<JobId>& held_back, const std::vector<std::string>& unused) {
  new_scenes_.clear();
  new_notes_.clear();
  if (held_back.empty()) {
    new_mark_.reset();
  }
  for (const std::string& digest : unused) {
    scenes_.erase(digest);
    remove_file(files_.scene(digest));
  }
  scenes_dropped_ = scenes_dropped_ && !held_back.empty();
  std::erase_if(changes_, [&](const auto& changed) {
    const auto& [id, change] = changed;
    if (held_back.contains(id)) {
      return false;
    }
    if (const auto found = jobs_.find(id); found != jobs_.end() && found->second.log) {
      RowLog& log = *found->second.log;
      log.committed += log.fresh.bytes();
      log.fresh = {};
    }
    for (const fs::path& file : change.doomed) {
      remove_file(file);
    }
    if (!change.doomed.empty()) {
      remove_file(files_.job(id));  // if it is empty now
    }
    return true;
  });
}

Store::Usage DiskStore::usage() {
  Usage usage;
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
  notes.erase(mark_name);
  return notes;
}

std::string DiskStore::mark() { return new_mark_ ? *new_mark_ : note(mark_name); }

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

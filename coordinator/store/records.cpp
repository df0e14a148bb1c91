#include "coordinator/store/records.h"

#include <utility>

namespace parray::store {
namespace {

constexpr const char* tables =
    "CREATE TABLE jobs (id INTEGER PRIMARY KEY, scene TEXT NOT NULL,"
    "  unfinished INTEGER NOT NULL, record TEXT NOT NULL, batch INTEGER NOT NULL);"
    "CREATE TABLE scenes (digest TEXT PRIMARY KEY, bytes INTEGER NOT NULL,"
    "  checksum INTEGER NOT NULL);"
    "CREATE TABLE pictures (job INTEGER PRIMARY KEY, number INTEGER NOT NULL,"
    "  bytes INTEGER NOT NULL, checksum INTEGER NOT NULL);"
    "CREATE TABLE logs (job INTEGER PRIMARY KEY, number INTEGER NOT NULL, bytes INTEGER NOT NULL);"
    "CREATE TABLE notes (name TEXT PRIMARY KEY, text TEXT NOT NULL);"
    "PRAGMA user_version = 3;";

std::string extract(std::map<std::string, std::string>& notes, std::string_view name) {
  auto note = notes.extract(std::string(name));
  return note ? std::move(note.mapped()) : "";
}

std::uint64_t extract_number(std::map<std::string, std::string>& notes, std::string_view name) {
  return std::strtoull(extract(notes, name).c_str(), nullptr, 10);
}

}  // namespace

void make_tables(Database& database) { database.run(tables); }

std::string other_version_text(const std::filesystem::path& directory, std::uint64_t version) {
  return "the state in " + directory.string() + " is of version " + std::to_string(version) +
         ", and this program reads version " + std::to_string(present_version) +
         ": use the version of ParRay that wrote the state, or name another directory";
}

Records read_records(Database& database) {
  Records records;
  Statement jobs(database, "SELECT id, scene, unfinished, record, batch FROM jobs");
  while (jobs.step()) {
    records.jobs[jobs.number(0)] = {std::string(jobs.bytes(1)), jobs.number(2) != 0, jobs.number(4),
                                    std::string(jobs.bytes(3))};
  }
  Statement scenes(database, "SELECT digest, bytes, checksum FROM scenes");
  while (scenes.step()) {
    records.scenes[std::string(scenes.bytes(0))] = {scenes.number(1), scenes.number(2)};
  }
  Statement logs(database, "SELECT job, number, bytes FROM logs");
  while (logs.step()) records.jobs[logs.number(0)].rows = {logs.number(1), logs.number(2)};
  Statement pictures(database, "SELECT job, number, bytes, checksum FROM pictures");
  while (pictures.step()) {
    records.jobs[pictures.number(0)].picture = {pictures.number(1),
                                                {pictures.number(2), pictures.number(3)}};
  }
  Statement notes(database, "SELECT name, text FROM notes");
  while (notes.step()) records.notes[std::string(notes.bytes(0))] = notes.bytes(1);
  records.mark = extract(records.notes, own_note::mark);
  records.reached = extract(records.notes, own_note::reached);
  records.batch = extract_number(records.notes, own_note::batch);
  records.notes_batch = extract_number(records.notes, own_note::notes_batch);
  return records;
}

void write_records(Database& database, const Records& records) {
  for (const auto& [id, job] : records.jobs) {
    if (job.record) {
      execute(database, "INSERT INTO jobs VALUES (?, ?, ?, ?, ?)", id, job.scene,
              std::uint64_t{job.unfinished ? 1U : 0U}, *job.record, job.batch);
    }
    write_rows(database, id, job.rows);
    write_picture(database, id, job.picture);
  }
  for (const auto& [digest, file] : records.scenes) write_scene(database, digest, file);
  for (const auto& [name, text] : records.notes) write_note(database, name, text);
  if (!records.reached.empty()) write_note(database, own_note::reached, records.reached);
  write_note(database, own_note::batch, std::to_string(records.batch));
  write_note(database, own_note::notes_batch, std::to_string(records.notes_batch));
}

void erase_own_notes(std::map<std::string, std::string>& notes) {
  for (const std::string_view name :
       {own_note::mark, own_note::reached, own_note::batch, own_note::notes_batch}) {
    notes.erase(std::string(name));
  }
}

void write_note(Database& database, std::string_view name, const std::string& text) {
  execute(database, "INSERT OR REPLACE INTO notes VALUES (?, ?)", name, text);
}

void write_scene(Database& database, const std::string& digest,
                 const std::optional<WholeFile>& file) {
  if (file) {
    execute(database, "INSERT OR REPLACE INTO scenes VALUES (?, ?, ?)", digest, file->bytes,
            file->checksum);
  } else {
    execute(database, "DELETE FROM scenes WHERE digest = ?", digest);
  }
}

void write_rows(Database& database, JobId job, const std::optional<RowsFile>& rows) {
  if (rows) {
    execute(database, "INSERT OR REPLACE INTO logs VALUES (?, ?, ?)", job, rows->number,
            rows->bytes);
  } else {
    execute(database, "DELETE FROM logs WHERE job = ?", job);
  }
}

void write_picture(Database& database, JobId job, const std::optional<KeptPicture>& picture) {
  if (picture) {
    execute(database, "INSERT OR REPLACE INTO pictures VALUES (?, ?, ?, ?)", job, picture->number,
            picture->file.bytes, picture->file.checksum);
  } else {
    execute(database, "DELETE FROM pictures WHERE job = ?", job);
  }
}

}  // namespace parray::store

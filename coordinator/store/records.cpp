#include "coordinator/store/records.h"

#include <spdlog/fmt/fmt.h>

#include <charconv>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/base/checksum.h"
#include "common/base/error.h"
#include "common/base/json_text.h"
#include "common/base/printable.h"

namespace parray::store {
namespace {

using nlohmann::json;

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

constexpr std::string_view before_checksum = "{\"checksum\": \"";
constexpr std::string_view before_content = "\",\n\"content\": ";
constexpr std::string_view after_content = "}\n";
constexpr std::size_t digits = 16;

std::string checksum_text(std::string_view bytes) {
  return fmt::format("{:016x}", checksum_of(bytes));
}

std::string with_checksum(const std::string& content) {
  return std::string(before_checksum) + checksum_text(content) + std::string(before_content) +
         content + std::string(after_content);
}

std::string_view checked_content(std::string_view text) {
  constexpr std::size_t head = before_checksum.size() + digits + before_content.size();
  if (text.size() < head + after_content.size() || !text.starts_with(before_checksum) ||
      !text.ends_with(after_content) ||
      text.substr(before_checksum.size() + digits, before_content.size()) != before_content) {
    throw RunError("it is incomplete");
  }
  const std::string_view content = text.substr(head, text.size() - head - after_content.size());
  if (text.substr(before_checksum.size(), digits) != checksum_text(content)) {
    throw RunError("it fails its checksum");
  }
  return content;
}

auto read_content(std::string_view text, const auto& read) {
  const std::string_view content = checked_content(text);
  try {
    return read(json::parse(content));
  } catch (const json::exception& error) {
    throw RunError("it has wrong content: " + printable(error.what(), 400));
  }
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

/// Inserts the record as text without parsing it into a tree, because a commit may have 1000 jobs.
std::string job_file_to_text(JobId id, const JobFile& file) {
  if (!json::accept(file.record)) {
    throw RunError("the state's record of job " + std::to_string(id) +
                   " is damaged: it is not JSON");
  }
  std::string content =
      fmt::format(R"({{"batch":{},"job":{},"record":{})", file.batch, id, file.record);
  if (file.rows) {
    content +=
        fmt::format(R"(,"rows":{{"number":{},"bytes":{}}})", file.rows->number, file.rows->bytes);
  }
  if (file.picture) {
    content +=
        fmt::format(R"(,"picture":{{"number":{},"bytes":{},"checksum":{}}})", file.picture->number,
                    file.picture->file.bytes, file.picture->file.checksum);
  }
  return with_checksum(content + "}");
}

JobFile job_file_from_text(JobId id, std::string_view text) {
  return read_content(text, [id](const json& content) {
    if (content.at("job") != id) throw RunError("it belongs to job " + content.at("job").dump());
    JobFile file{content.at("batch"), content.at("record").dump()};
    if (content.contains("rows")) {
      const json& rows = content.at("rows");
      file.rows = {rows.at("number"), rows.at("bytes")};
    }
    if (content.contains("picture")) {
      const json& picture = content.at("picture");
      file.picture = {picture.at("number"), {picture.at("bytes"), picture.at("checksum")}};
    }
    return file;
  });
}

std::string notes_file_to_text(const NotesFile& file) {
  const json content = {{"batch", file.batch}, {"notes", file.notes}};
  return with_checksum(json_text(content));
}

NotesFile notes_file_from_text(std::string_view text) {
  return read_content(text, [](const json& content) {
    return NotesFile{content.at("batch"), content.at("notes")};
  });
}

std::string commit_count_to_text(std::uint64_t commits) {
  constexpr std::size_t width = 20;  // digits of the largest number
  const std::string number = std::to_string(commits);
  const std::string padded = std::string(width - number.size(), '0') + number;
  return padded + " " + checksum_text(padded) + "\n";
}

std::optional<std::uint64_t> commit_count_from_text(std::string_view text) {
  std::uint64_t commits = 0;
  std::from_chars(text.data(), text.data() + text.size(), commits);
  return commit_count_to_text(commits) == text ? std::optional(commits) : std::nullopt;
}

}  // namespace parray::store

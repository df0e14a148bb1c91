// Examines a state for damage.
#include <optional>
#include <system_error>

#include "common/base/bytes.h"
#include "common/base/files.h"
#include "common/base/sha256.h"
#include "coordinator/store/rebuild.h"
#include "coordinator/store/row_log.h"

namespace parray::store {
namespace {

namespace fs = std::filesystem;

OwnedPath temporary_directory() {
  std::error_code error;
  const fs::path parent = fs::temp_directory_path(error);
  fs::path path = error ? "" : make_directory(parent / "parray-check-");
  if (path.empty()) {
    throw RunError("copying the database failed: set TMPDIR to a writable directory");
  }
  return OwnedPath(std::move(path));
}

void copy_if_file(const fs::path& from, const fs::path& onto) {
  std::error_code error;
  if (fs::is_regular_file(from, error) && !fs::copy_file(from, onto, error)) {
    throw RunError("copying " + from.string() + " to " + onto.string() + ": " + error.message() +
                   ": make the file readable, or set TMPDIR to a directory with more room");
  }
}

void read_into(DatabaseContent& content, const fs::path& file) {
  try {
    Database database(file);
    content.version = database.number("PRAGMA user_version");
    Statement check(database, "PRAGMA integrity_check(1)");
    if (check.step() && check.bytes(0) != "ok") {
      content.damage = "parray.sqlite: " + std::string(check.bytes(0));
    }
    if (content.version == present_version) content.records = read_records(database);
  } catch (const StorageFull& full) {
    throw RunError(file.parent_path().string() +
                   " has too little room for a copy of the database: set TMPDIR to a directory "
                   "with more room (" +
                   full.what() + ")");
  } catch (const RunError& error) {
    content.damage = error.what();
  } catch (const InputError& error) {
    content.damage = error.what();
  }
}

/// Reads a temporary copy of the database. Throws RunError if there is no room for the copy.
DatabaseContent read_database_copy(const StateFiles& files) {
  DatabaseContent content;
  std::error_code ignored;
  content.present = fs::exists(files.database(), ignored);
  if (!content.present) return content;
  if (!fs::is_regular_file(files.database(), ignored)) {
    content.damage = "parray.sqlite is not a file";
    return content;
  }
  const OwnedPath scratch = temporary_directory();
  const fs::path copy = scratch.path() / files.database().filename();
  copy_if_file(files.database(), copy);
  copy_if_file(files.database().string() + "-wal", copy.string() + "-wal");
  read_into(content, copy);
  return content;
}

std::string relative(const StateFiles& files, const fs::path& file) {
  return file.lexically_relative(files.directory()).string();
}

/// Returns what is wrong with a file that is written once; empty: nothing.
std::string damage_of(const fs::path& file, const WholeFile& expected) {
  const std::optional<WholeFile> found = measure(file);
  if (!found) return "is missing or cannot be read";
  if (found->bytes != expected.bytes) {
    return "has " + std::to_string(found->bytes) + " bytes instead of " +
           std::to_string(expected.bytes);
  }
  return *found == expected ? "" : "fails its checksum";
}

std::optional<JobState> state_of(const JobRow& row, JobId id) {
  try {
    return record_from_json(id, row.record.value_or("")).state;
  } catch (const RunError&) {
    return std::nullopt;
  }
}

}  // namespace

bool is_scene(const fs::path& file, const std::string& digest, const WholeFile* expected) {
  if (expected != nullptr) return measure(file) == *expected;
  const std::optional<std::string> bytes = text_of_file(file);
  return bytes && sha256_hex(as_byte_span(*bytes)) == digest;
}

std::vector<FileDamage> verify_files(const StateFiles& files, const Records& records) {
  std::vector<FileDamage> damage;
  for (const auto& [id, row] : records.jobs) {
    if (row.rows) {
      const fs::path file = files.rows(id, row.rows->number);
      const std::uint64_t sound = sound_bytes(file);
      if (sound < row.rows->bytes) {
        damage.push_back({id, FileDamage::Kind::rows,
                          relative(files, file) + ": " + std::to_string(sound) + " of " +
                              std::to_string(row.rows->bytes) + " bytes are undamaged"});
      } else if (!ends_an_entry(file, row.rows->bytes)) {
        damage.push_back({id, FileDamage::Kind::rows,
                          "the length in the database of " + relative(files, file) +
                              " ends within an entry of this file"});
      }
    }
    if (row.picture) {
      const fs::path file = files.picture(id, row.picture->number);
      const std::string what = damage_of(file, row.picture->file);
      if (!what.empty()) {
        damage.push_back({id, FileDamage::Kind::picture, relative(files, file) + " " + what});
      }
    } else if (row.record && state_of(row, id) == JobState::done) {
      damage.push_back({id, FileDamage::Kind::picture,
                        "job " + std::to_string(id) + " is done but has no picture"});
    }
    const auto scene = records.scenes.find(row.scene);
    const WholeFile* expected = scene == records.scenes.end() ? nullptr : &scene->second;
    const JobState state = state_of(row, id).value_or(JobState::failed);
    const bool needed =
        row.record && (is_unfinished(state) || (state == JobState::done && row.unfinished));
    if ((needed || (row.unfinished && expected != nullptr)) &&
        !is_scene(files.scene(row.scene), row.scene, expected)) {
      damage.push_back({id, FileDamage::Kind::scene,
                        relative(files, files.scene(row.scene)) + ", which job " +
                            std::to_string(id) + " needs, is missing or damaged"});
    }
  }
  return damage;
}

Survey survey_state(const StateFiles& files) {
  Survey survey{read_database_copy(files), find_files(files), {}, {}, find_misplaced(files)};
  const DatabaseContent& database = survey.database;
  const std::string place = files.directory().string();
  if (!database.present && survey.found.empty()) {
    throw InputError(place + " holds no state: name the directory of --state");
  }
  const bool older = database.version != 0 && database.version < present_version;
  if (database.version > present_version || (older && !survey.found.has_commits)) {
    throw InputError(other_version_text(files.directory(), database.version));
  }
  if (!database.present) {
    survey.severe.emplace_back("parray.sqlite is missing");
  } else if (!database.damage.empty()) {
    survey.severe.push_back(database.damage);
  } else if (database.version == 0 && !survey.found.empty()) {
    survey.severe.emplace_back("the database has lost its content");
  } else if (older) {
    survey.severe.emplace_back(older_database);
  }
  if (survey.severe.empty()) {
    survey.comparison = compare(database.records, survey.found);
    survey.severe = survey.comparison.severe;
  } else if (survey.found.incomplete) {
    survey.severe.emplace_back(unfinished_copy);
  }
  return survey;
}

}  // namespace parray::store

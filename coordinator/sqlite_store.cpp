#include "coordinator/sqlite_store.h"

#include <sqlite3.h>

#include <nlohmann/json.hpp>

#include "common/base/error.h"
#include "proto/messages.h"
#include "proto/settings_json.h"

namespace parray {
namespace {

using nlohmann::json;

constexpr int schema_version = 1;

constexpr const char* schema =
    "CREATE TABLE IF NOT EXISTS jobs (id INTEGER PRIMARY KEY, scene TEXT NOT NULL,"
    "  open INTEGER NOT NULL, record TEXT NOT NULL);"
    "CREATE TABLE IF NOT EXISTS scenes (digest TEXT PRIMARY KEY, bytes BLOB NOT NULL);"
    "CREATE TABLE IF NOT EXISTS blocks (job INTEGER NOT NULL, epoch INTEGER NOT NULL,"
    "  bytes BLOB NOT NULL, PRIMARY KEY (job, epoch));"
    "CREATE TABLE IF NOT EXISTS pictures (job INTEGER PRIMARY KEY, bytes BLOB NOT NULL);";

bool is_open(JobState state) { return state == JobState::queued || state == JobState::running; }

json record_to_json(const JobRecord& job) {
  return {{"token", job.token},
          {"name", job.name},
          {"priority", job.priority},
          {"settings", settings_to_json(job.settings)},
          {"precision_reason", job.precision_reason},
          {"duplicates_removed", job.duplicates_removed},
          {"load_seconds", job.load_seconds},
          {"scene", job.scene},
          {"life", job.life},
          {"passes", job.passes},
          {"state", static_cast<int>(job.state)},
          {"reason", job.reason},
          {"report", job.report}};
}

JobRecord record_from_json(JobId id, const std::string& text) {
  try {
    const json map = json::parse(text);
    JobRecord job;
    job.id = id;
    job.token = map.at("token");
    job.name = map.at("name");
    job.priority = map.at("priority");
    job.settings = settings_from_json(map.at("settings"));
    job.precision_reason = map.at("precision_reason");
    job.duplicates_removed = map.value("duplicates_removed", std::uint64_t{0});
    job.load_seconds = map.at("load_seconds");
    job.scene = map.at("scene");
    job.life = map.at("life");
    job.passes = map.value("passes", std::vector<std::uint64_t>());
    job.state = static_cast<JobState>(map.at("state").get<int>());
    job.reason = map.at("reason");
    job.report = map.at("report");
    return job;
  } catch (const std::exception& error) {
    throw RunError("the state's record of job " + std::to_string(id) +
                   " is damaged: " + error.what());
  }
}

}  // namespace

/// One connection, one prepared statement at a time, errors as RunError.
class SqliteStore::Database {
 public:
  explicit Database(const std::string& file) : file_(file) {
    if (sqlite3_open(file.c_str(), &db_) != SQLITE_OK) {
      const std::string why = sqlite3_errmsg(db_);
      sqlite3_close(db_);
      throw InputError("--state: opening " + file + ": " + why);
    }
  }
  ~Database() { sqlite3_close(db_); }
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  void run(const char* sql) {
    if (sqlite3_exec(db_, sql, nullptr, nullptr, nullptr) != SQLITE_OK) {
      fail();
    }
  }

  /// Opens the transaction that commit() closes.
  void begin() {
    if (sqlite3_get_autocommit(db_) != 0) {
      run("BEGIN IMMEDIATE");
    }
  }
  void commit() {
    if (sqlite3_get_autocommit(db_) == 0) {
      run("COMMIT");
    }
  }

  [[noreturn]] void fail() const {
    const std::string why = sqlite3_errmsg(db_);
    if (sqlite3_errcode(db_) == SQLITE_BUSY) {
      throw InputError("--state: another coordinator uses " + file_ +
                       ": stop it, or name another directory");
    }
    throw RunError("keeping state in " + file_ + ": " + why);
  }

  sqlite3* handle() { return db_; }

 private:
  std::string file_;
  sqlite3* db_ = nullptr;
};

namespace {

/// A statement with its values; finalised with its scope.
template <typename Database>
class Statement {
 public:
  Statement(Database& database, const char* sql) : database_(database) {
    check(sqlite3_prepare_v2(database.handle(), sql, -1, &statement_, nullptr) == SQLITE_OK);
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& bind(std::uint64_t value) {
    check(sqlite3_bind_int64(statement_, ++bound_, static_cast<sqlite3_int64>(value)) == SQLITE_OK);
    return *this;
  }
  Statement& bind_text(const std::string& value) {
    check(sqlite3_bind_text64(statement_, ++bound_, value.data(), value.size(), SQLITE_STATIC,
                              SQLITE_UTF8) == SQLITE_OK);
    return *this;
  }
  Statement& bind_blob(const std::string& value) {
    check(sqlite3_bind_blob64(statement_, ++bound_, value.data(), value.size(), SQLITE_STATIC) ==
          SQLITE_OK);
    return *this;
  }
  /// True while there is a row.
  bool step() {
    const int result = sqlite3_step(statement_);
    check(result == SQLITE_ROW || result == SQLITE_DONE);
    return result == SQLITE_ROW;
  }
  std::uint64_t number(int column) {
    return static_cast<std::uint64_t>(sqlite3_column_int64(statement_, column));
  }
  std::string bytes(int column) {
    const void* data = sqlite3_column_blob(statement_, column);
    const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
    return data == nullptr ? std::string() : std::string(static_cast<const char*>(data), size);
  }

 private:
  void check(bool ok) {
    if (!ok) {
      database_.fail();
    }
  }

  Database& database_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
};

}  // namespace

SqliteStore::SqliteStore(const std::filesystem::path& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) {
    throw InputError("--state " + directory.string() + ": " + error.message() +
                     ": name a directory that can be written");
  }
  database_ = std::make_unique<Database>((directory / "parray.sqlite").string());
  database_->run("PRAGMA locking_mode = EXCLUSIVE");  // one coordinator a state
  database_->run("PRAGMA journal_mode = WAL");
  database_->run("PRAGMA synchronous = FULL");  // a commit outlives a power cut
  Statement version(*database_, "PRAGMA user_version");
  version.step();
  if (version.number(0) > schema_version) {
    throw RunError("the state in " + directory.string() + " is of a later version of ParRay");
  }
  database_->begin();
  database_->run(schema);
  database_->run(("PRAGMA user_version = " + std::to_string(schema_version)).c_str());
  database_->commit();
}

SqliteStore::~SqliteStore() = default;

void SqliteStore::put_job(const JobRecord& job) {
  database_->begin();
  Statement(*database_, "INSERT OR REPLACE INTO jobs (id, scene, open, record) VALUES (?, ?, ?, ?)")
      .bind(job.id)
      .bind_text(job.scene)
      .bind(is_open(job.state) ? 1 : 0)
      .bind_text(record_to_json(job).dump(-1, ' ', false, json::error_handler_t::replace))
      .step();
}

void SqliteStore::put_scene(const std::string& digest, const std::string& bytes) {
  database_->begin();
  Statement(*database_, "INSERT OR IGNORE INTO scenes (digest, bytes) VALUES (?, ?)")
      .bind_text(digest)
      .bind_blob(bytes)
      .step();
}

void SqliteStore::put_block(JobId job, std::uint64_t epoch, const std::string& bytes) {
  database_->begin();
  Statement(*database_, "INSERT INTO blocks (job, epoch, bytes) VALUES (?, ?, ?)")
      .bind(job)
      .bind(epoch)
      .bind_blob(bytes)
      .step();
}

void SqliteStore::put_picture(JobId job, const std::string& bytes) {
  database_->begin();
  Statement(*database_, "INSERT OR REPLACE INTO pictures (job, bytes) VALUES (?, ?)")
      .bind(job)
      .bind_blob(bytes)
      .step();
}

void SqliteStore::drop_work(JobId job) {
  database_->begin();
  Statement(*database_, "DELETE FROM blocks WHERE job = ?").bind(job).step();
  Statement(*database_,
            "DELETE FROM scenes WHERE digest NOT IN (SELECT scene FROM jobs WHERE open = 1)")
      .step();
}

void SqliteStore::drop_job(JobId job) {
  database_->begin();
  Statement(*database_, "DELETE FROM jobs WHERE id = ?").bind(job).step();
  Statement(*database_, "DELETE FROM pictures WHERE job = ?").bind(job).step();
  drop_work(job);
}

void SqliteStore::commit() { database_->commit(); }

std::vector<JobRecord> SqliteStore::jobs() {
  std::vector<JobRecord> jobs;
  Statement rows(*database_, "SELECT id, record FROM jobs ORDER BY id");
  while (rows.step()) {
    jobs.push_back(record_from_json(rows.number(0), rows.bytes(1)));
  }
  return jobs;
}

std::optional<std::string> SqliteStore::scene(const std::string& digest) {
  Statement row(*database_, "SELECT bytes FROM scenes WHERE digest = ?");
  row.bind_text(digest);
  return row.step() ? std::optional(row.bytes(0)) : std::nullopt;
}

void SqliteStore::each_block(JobId job, const BlockVisitor& visit) {
  Statement rows(*database_, "SELECT bytes FROM blocks WHERE job = ?");
  rows.bind(job);
  while (rows.step()) {
    visit(rows.bytes(0));
  }
}

std::optional<std::string> SqliteStore::picture(JobId job) {
  Statement row(*database_, "SELECT bytes FROM pictures WHERE job = ?");
  row.bind(job);
  return row.step() ? std::optional(row.bytes(0)) : std::nullopt;
}

}  // namespace parray

#include "coordinator/store/database.h"

#include <sqlite3.h>

#include "coordinator/store/store.h"

namespace parray::store {

/// Returns whether an extended result code means that the disk did not accept a write.
static bool is_full(int code) {
  switch (code) {
    case SQLITE_IOERR_WRITE:
    case SQLITE_IOERR_FSYNC:
    case SQLITE_IOERR_DIR_FSYNC:
    case SQLITE_IOERR_TRUNCATE:
    case SQLITE_IOERR_SHMSIZE: return true;
    default: return (code & 0xff) == SQLITE_FULL;
  }
}

Database::Database(const std::filesystem::path& file) : directory_(file.parent_path()) {
  if (sqlite3_open(file.c_str(), &db_) != SQLITE_OK) {
    const int error = sqlite3_system_errno(db_);
    const std::string why =
        error != 0 ? std::generic_category().message(error) : sqlite3_errmsg(db_);
    sqlite3_close(db_);
    throw InputError(directory_.string() + ": " + file.filename().string() + " cannot be opened (" +
                     why +
                     "): start the program as the owner of the directory, or use another one");
  }
  sqlite3_extended_result_codes(db_, 1);
}

Database::~Database() { sqlite3_close(db_); }

void Database::run(const std::string& sql) {
  if (sqlite3_exec(db_, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) fail();
}

std::uint64_t Database::number(const char* sql) {
  Statement statement(*this, sql);
  return statement.step() ? statement.number(0) : 0;
}

void Database::keep_log_on_close(bool keep) {
  sqlite3_db_config(db_, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, keep ? 1 : 0, nullptr);
}

bool Database::moved() const {
  int moved = 0;
  return sqlite3_file_control(db_, "main", SQLITE_FCNTL_HAS_MOVED, &moved) == SQLITE_OK &&
         moved != 0;
}

void Database::fail() const {
  const int code = sqlite3_extended_errcode(db_);
  const std::string place = directory_.string() + ": ";
  const std::string why = sqlite3_errmsg(db_);
  if ((code & 0xff) == SQLITE_BUSY) {
    throw StateInUse(place +
                     "another process uses it (a coordinator, parray-mpi or --repair): wait for "
                     "its end, or use another directory");
  }
  if ((code & 0xff) == SQLITE_CANTOPEN || (code & 0xff) == SQLITE_READONLY) {
    throw InputError(place + why + ": use a writable directory");
  }
  if (is_full(code)) {
    throw StorageFull(place + "the disk accepts no more data (" + why +
                      "): make room there, or check the disk");
  }
  if ((code & 0xff) == SQLITE_CORRUPT || (code & 0xff) == SQLITE_NOTADB) {
    throw DatabaseDamaged("parray.sqlite: " + why);
  }
  throw RunError(place + "parray.sqlite: " + why);
}

Statement::Statement(Database& database, const char* sql) : database_(database) {
  check(sqlite3_prepare_v2(database.db_, sql, -1, &statement_, nullptr));
}

Statement::~Statement() { sqlite3_finalize(statement_); }

void Statement::check(int result) const {
  if (result != SQLITE_OK && result != SQLITE_ROW && result != SQLITE_DONE) database_.fail();
}

Statement& Statement::bind(std::uint64_t value) {
  check(sqlite3_bind_int64(statement_, ++bound_, static_cast<sqlite3_int64>(value)));
  return *this;
}

Statement& Statement::bind(std::string_view text) {
  check(sqlite3_bind_text64(statement_, ++bound_, text.data(), text.size(), SQLITE_STATIC,
                            SQLITE_UTF8));
  return *this;
}

bool Statement::step() {
  const int result = sqlite3_step(statement_);
  check(result);
  return result == SQLITE_ROW;
}

std::uint64_t Statement::number(int column) {
  return static_cast<std::uint64_t>(sqlite3_column_int64(statement_, column));
}

std::string_view Statement::bytes(int column) {
  const void* data = sqlite3_column_blob(statement_, column);
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
  return data == nullptr ? std::string_view()
                         : std::string_view(static_cast<const char*>(data), size);
}

Transaction::Transaction(Database& database) : database_(database) {
  database_.run("BEGIN IMMEDIATE");
}

Transaction::~Transaction() {
  // SQLite has already rolled back after some failures.
  if (sqlite3_get_autocommit(database_.db_) == 0) {
    sqlite3_exec(database_.db_, "ROLLBACK", nullptr, nullptr, nullptr);
  }
}

}  // namespace parray::store

#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "common/base/error.h"

struct sqlite3;
struct sqlite3_stmt;

namespace parray::store {

/// The database's file is damaged. `what()` describes the damage without the directory.
class DatabaseDamaged : public RunError {
 public:
  using RunError::RunError;
};

/// A connection to one SQLite file. Not thread-safe.
///
/// Errors are exceptions. StateInUse: another process uses the file. InputError: the file cannot be
/// opened or written. StorageFull: there is no room to write. DatabaseDamaged: the content is
/// damaged. RunError: anything else. Messages name the file's directory, except DatabaseDamaged's.
class Database {
 public:
  /// Opens the file. Creates it if it does not exist.
  explicit Database(const std::filesystem::path& file);
  ~Database();
  Database& operator=(Database&&) = delete;

  void run(const std::string& sql);       ///< runs one or more statements without results
  std::uint64_t number(const char* sql);  ///< returns column 0 of the first row, 0 without rows

  /// Sets whether closing keeps the write-ahead log instead of moving its content into the file.
  void keep_log_on_close(bool keep);
  /// Returns whether the file was removed or replaced. Commits would be lost then.
  [[nodiscard]] bool moved() const;

 private:
  friend class Statement;
  friend class Transaction;
  [[noreturn]] void fail() const;

  std::filesystem::path directory_;
  sqlite3* db_ = nullptr;
};

/// One prepared statement with its values. The destructor finalises it.
class Statement {
 public:
  /// `sql` has a `?` for each value, in the order of the bind() calls. Bound text is not copied and
  /// must outlive the last step().
  Statement(Database& database, const char* sql);
  ~Statement();
  Statement& operator=(Statement&&) = delete;

  Statement& bind(std::uint64_t value);  ///< keeps all 64 bits; SQL sees a signed number
  Statement& bind(std::string_view text);

  bool step();  ///< advances to the next row; false: there is none
  std::uint64_t number(int column);
  std::string_view bytes(int column);  ///< valid until the next step()

 private:
  void check(int result) const;

  Database& database_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
};

/// Runs a statement without results.
template <typename... Values>
void execute(Database& database, const char* sql, const Values&... values) {
  Statement statement(database, sql);
  (statement.bind(values), ...);
  statement.step();
}

/// Makes the database keep all statements between construction and commit(), or none of them.
class Transaction {
 public:
  explicit Transaction(Database& database);
  ~Transaction();
  Transaction& operator=(Transaction&&) = delete;

  void commit() { database_.run("COMMIT"); }  ///< returns when the changes are on the disk

 private:
  Database& database_;
};

}  // namespace parray::store

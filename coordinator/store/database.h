#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "common/base/error.h"

struct sqlite3;
struct sqlite3_stmt;

namespace parray::store {

/// The database's file is damaged. `what()` says how, without the directory.
class DatabaseDamaged : public RunError {
 public:
  using RunError::RunError;
};

/// A connection to one SQLite file. One thread.
///
/// Errors are exceptions. StateInUse: another process uses the file. InputError: the file cannot be
/// opened. StorageFull: there is no room to write. DatabaseDamaged: the content is damaged.
/// RunError: anything else. Messages name the directory of the file, except DatabaseDamaged's.
class Database {
 public:
  /// Opens the file, which is made if need be.
  explicit Database(const std::filesystem::path& file);
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  void run(const std::string& sql);       ///< one or more statements without results
  std::uint64_t number(const char* sql);  ///< first column of the first row; 0: there is no row

  /// Whether closing leaves the write-ahead log as it is, instead of taking it into the file.
  void keep_log_on_close(bool keep);
  /// The file was removed, or another one was put in its place: what is committed would be lost.
  [[nodiscard]] bool moved() const;

 private:
  friend class Statement;
  friend class Transaction;
  [[noreturn]] void fail() const;
  void close();

  std::filesystem::path directory_;
  sqlite3* db_ = nullptr;
};

/// One prepared statement with its values; finalised with its scope.
class Statement {
 public:
  /// `sql` has a `?` for each value, which are bound in this order. Text is not copied: it must
  /// outlive the last step().
  Statement(Database& database, const char* sql);
  ~Statement();
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& bind(std::uint64_t value);  ///< all 64 bits are kept; SQL sees a signed number
  Statement& bind(std::string_view text);

  bool step();  ///< true while there is a row
  std::uint64_t number(int column);
  std::string_view bytes(int column);  ///< until the next step()

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

/// Everything between construction and commit(), or nothing of it.
class Transaction {
 public:
  explicit Transaction(Database& database);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  void commit();  ///< on disk when it returns

 private:
  Database& database_;
};

}  // namespace parray::store

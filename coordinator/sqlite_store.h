#pragma once

#include <filesystem>
#include <memory>

#include "coordinator/store.h"

namespace parray {

/// Keeps everything in DIR/parray.sqlite (SQLite, write-ahead log, synced at every commit): what
/// commit() has returned for survives the death of the process and of the machine.
///
/// The constructor makes the directory if need be, and throws InputError when it cannot be used or
/// another coordinator uses it, RunError when the file is damaged or of a later version.
class SqliteStore final : public Store {
 public:
  explicit SqliteStore(const std::filesystem::path& directory);
  ~SqliteStore() override;
  SqliteStore(const SqliteStore&) = delete;
  SqliteStore& operator=(const SqliteStore&) = delete;

  void put_job(const JobRecord& job) override;
  void put_scene(const std::string& digest, const std::string& bytes) override;
  void put_block(JobId job, std::uint64_t epoch, const std::string& bytes) override;
  void put_picture(JobId job, const std::string& bytes) override;
  void drop_work(JobId job) override;
  void drop_job(JobId job) override;
  void commit() override;

  std::vector<JobRecord> jobs() override;
  std::optional<std::string> scene(const std::string& digest) override;
  void each_block(JobId job, const BlockVisitor& visit) override;
  std::optional<std::string> picture(JobId job) override;

 private:
  class Database;
  std::unique_ptr<Database> database_;
};

}  // namespace parray

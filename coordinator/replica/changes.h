#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/bytes.h"
#include "coordinator/store/store.h"

/// What was put into a store and dropped from it, as bytes: changes one after the other, each
///
///     1 byte   what: the ChangeKind
///     8 bytes  job, or 0
///     4 bytes  length of a name (a scene's digest, a note's name), and the name
///     8 bytes  length of the data, and the data
///
/// all numbers little-endian.
namespace parray::replica {

enum class ChangeKind : std::uint8_t {
  job = 1,
  scene,
  rows,
  drop_rows,
  picture,
  drop_work,
  drop_job,
  note,
  keep_rows,  ///< data: the number of entries, as 8 bytes
};

/// Changes that are yet to be sent, in order.
class Changes {
 public:
  void put_job(const JobRecord& job);
  void put_scene(const std::string& digest, std::string_view bytes);
  void append_rows(JobId job, std::string_view entry);
  void drop_rows(JobId job);
  void keep_rows(JobId job, std::uint64_t entries);
  void put_picture(JobId job, std::span<const std::string_view> pieces);
  void drop_work(JobId job);
  void drop_job(JobId job);
  void put_note(const std::string& name, std::string_view text);

  [[nodiscard]] std::size_t size() const { return size_; }
  std::string take();

 private:
  void add(ChangeKind kind, JobId job, std::string_view name,
           std::span<const std::string_view> pieces);

  std::string bytes_;
  std::size_t size_ = 0;  ///< of bytes_; GCC 12 warns of a move whose size it can tell
};

/// Does to the store what the first of the changes says; returns the bytes that it takes. Throws
/// DecodeError when that is no change, and what the store throws: it has not been done then.
std::size_t apply_first(std::string_view changes, Store& store);

}  // namespace parray::replica

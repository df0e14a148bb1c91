#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/bytes.h"
#include "coordinator/store/store.h"

/// The binary form of changes to a store. A batch is a sequence of changes, each
///
///     1 byte   ChangeKind
///     8 bytes  number of the job, or 0
///     4 bytes  length of the name, and the name: digest of a scene or name of a note
///     8 bytes  length of the data, and the data
///
/// All numbers are little-endian.
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
  keep_rows,  ///< data: the number of entries (8 bytes)
};

/// Collects changes in the order of the calls. Each member encodes the call of the Store member
/// with the same name.
class Changes {
 public:
  void put_job(const JobRecord& job) { add(ChangeKind::job, job.id, {}, record_to_json(job)); }
  void put_scene(const std::string& digest, std::string_view bytes) {
    add(ChangeKind::scene, 0, digest, bytes);
  }
  void append_rows(JobId job, std::string_view entry) { add(ChangeKind::rows, job, {}, entry); }
  void drop_rows(JobId job) { add(ChangeKind::drop_rows, job); }
  void keep_rows(JobId job, std::uint64_t entries);
  void put_picture(JobId job, std::span<const std::string_view> pieces) {
    add(ChangeKind::picture, job, {}, pieces);
  }
  void drop_work(JobId job) { add(ChangeKind::drop_work, job); }
  void drop_job(JobId job) { add(ChangeKind::drop_job, job); }
  void put_note(const std::string& name, std::string_view text) {
    add(ChangeKind::note, 0, name, text);
  }

  [[nodiscard]] std::size_t size() const { return size_; }  ///< bytes of all changes
  std::string take();  ///< returns all changes as one batch and forgets them

 private:
  void add(ChangeKind kind, JobId job, std::string_view name,
           std::span<const std::string_view> pieces);
  void add(ChangeKind kind, JobId job, std::string_view name = {}, std::string_view data = {}) {
    add(kind, job, name, std::span(&data, 1));
  }

  std::string bytes_;
  std::size_t size_ = 0;  ///< bytes_.size(), which GCC 12 warns about after a move
};

/// Applies the first change of `changes` to the store and returns the size of the change in bytes.
/// Throws DecodeError if `changes` does not begin with a valid change, RunError if the record of a
/// job is damaged, and what the store throws. In these cases the store is unchanged.
std::size_t apply_first(std::string_view changes, Store& store);

}  // namespace parray::replica

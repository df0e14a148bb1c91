#include "coordinator/replica/changes.h"

#include <utility>

namespace parray::replica {

void Changes::add(ChangeKind kind, JobId job, std::string_view name,
                  std::span<const std::string_view> pieces) {
  std::uint64_t size = 0;
  for (const std::string_view piece : pieces) size += piece.size();
  ByteWriter header;
  header.numbers(kind, job, static_cast<std::uint32_t>(name.size()));
  header.put_bytes(name);
  header.put(size);
  bytes_ += header.take();
  for (const std::string_view piece : pieces) bytes_ += piece;
  size_ = bytes_.size();
}

std::string Changes::take() {
  size_ = 0;
  return std::exchange(bytes_, {});
}

void Changes::keep_rows(JobId job, std::uint64_t entries) {
  ByteWriter count;
  count.put(entries);
  add(ChangeKind::keep_rows, job, {}, count.take());
}

std::size_t apply_first(std::string_view changes, Store& store) {
  ByteReader reader(changes);
  const auto kind = reader.get<ChangeKind>();
  const auto job = reader.get<JobId>();
  const std::string name(reader.get_bytes(reader.get<std::uint32_t>()));
  const std::string_view data = reader.get_bytes(reader.get<std::uint64_t>());
  switch (kind) {
    case ChangeKind::job: store.put_job(record_from_json(job, data)); break;
    case ChangeKind::scene: store.put_scene(name, data); break;
    case ChangeKind::rows: store.append_rows(job, std::string(data)); break;
    case ChangeKind::drop_rows: store.drop_rows(job); break;
    case ChangeKind::keep_rows: store.keep_rows(job, ByteReader(data).get<std::uint64_t>()); break;
    case ChangeKind::picture: store.put_picture(job, std::span(&data, 1)); break;
    case ChangeKind::drop_work: store.drop_work(job); break;
    case ChangeKind::drop_job: store.drop_job(job); break;
    case ChangeKind::note: store.put_note(name, std::string(data)); break;
    default: throw DecodeError("a change of no known kind");
  }
  return changes.size() - reader.left();
}

}  // namespace parray::replica

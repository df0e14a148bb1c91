#include "coordinator/store/state_files.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "common/base/checksum.h"
#include "common/base/sha256.h"
#include "common/base/text.h"
#include "coordinator/store/store.h"

namespace parray::store {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view temporary_suffix = ".partial";

bool is_digits(std::string_view name) {
  return !name.empty() && name.find_first_not_of("0123456789") == std::string_view::npos;
}

bool is_kept_name(std::string_view name) {
  for (const std::string_view kind : {"rows", "picture"}) {
    if (name == kind || (name.starts_with(kind) && name[kind.size()] == '.' &&
                         is_digits(name.substr(kind.size() + 1)))) {
      return true;
    }
  }
  return is_sha256_hex(name) || name == "job.json" || name == "job.next" || name == "job.dropped";
}

fs::path numbered(fs::path file, std::uint64_t number) {
  if (number > 0) file += "." + std::to_string(number);
  return file;
}

/// Returns the entries of a directory; none if it does not exist.
fs::directory_iterator entries_of(const fs::path& directory) {
  std::error_code ignored;
  return {directory, ignored};
}

bool is_temporary(std::string_view name) {
  return name == "job.next" ||
         (name.ends_with(temporary_suffix) &&
          is_kept_name(name.substr(0, name.size() - temporary_suffix.size())));
}

/// Returns the path if it is free, otherwise with the lowest number that makes it free.
fs::path free_path(const fs::path& wanted) {
  fs::path path = wanted;
  std::error_code ignored;
  for (std::uint64_t number = 1; fs::exists(path, ignored); ++number) {
    path = numbered(wanted, number);
  }
  return path;
}

}  // namespace

fs::path normal_directory(const fs::path& directory) {
  const fs::path path = fs::absolute(directory).lexically_normal();
  return path.has_filename() || path == path.root_path() ? path : path.parent_path();
}

StateFiles::StateFiles(const fs::path& directory, Disk& disk)
    : directory_(normal_directory(directory)), disk_(disk), unsynced_({directory_}) {
  std::error_code error;
  if (fs::create_directories(directory_, error)) unsynced_.insert(directory_.parent_path());
  if (error) {
    throw InputError("creating " + directory_.string() + ": " + error.message() +
                     ": name a directory that can be created");
  }
  reserved_ = fs::is_regular_file(reserve(), error);
  file_system_ = std::make_shared<const OpenPath>(directory_, O_RDONLY | O_DIRECTORY);
}

fs::path StateFiles::scene(const std::string& digest) const {
  if (!is_sha256_hex(digest)) {
    throw std::logic_error("the digest of a scene must be 64 lower-case hexadecimal digits");
  }
  return scenes() / digest;
}

fs::path StateFiles::rows(JobId job, std::uint64_t number) const {
  return numbered(this->job(job) / "rows", number);
}

fs::path StateFiles::picture(JobId job, std::uint64_t number) const {
  return numbered(this->job(job) / "picture", number);
}

fs::path StateFiles::temporary(const fs::path& file) {
  return file.string() + std::string(temporary_suffix);
}

bool StateFiles::is_file_name(std::string_view name) {
  return is_kept_name(name) || is_temporary(name);
}

std::vector<JobId> StateFiles::jobs_with_directory() const {
  std::vector<JobId> jobs;
  for (const fs::directory_entry& entry : entries_of(this->jobs())) {
    const std::string name = entry.path().filename().string();
    const std::optional<JobId> id = natural_in(name);
    if (id && std::to_string(*id) == name) jobs.push_back(*id);
  }
  std::ranges::sort(jobs);
  return jobs;
}

void StateFiles::fail(const fs::path& file, int error) const {
  constexpr std::array<int, 5> of_full_disks = {ENOSPC, EDQUOT, EFBIG, EIO, 0};
  // The directory was removed, mounted read-only, or lost its permission to write.
  constexpr std::array<int, 8> of_lost_places = {EACCES,  EPERM,  EROFS, ENOENT,
                                                 ENOTDIR, ENODEV, ENXIO, ESTALE};
  const auto is_one_of = [error](const auto& errors) {
    return std::ranges::find(errors, error) != errors.end();
  };
  const std::string why =
      error == 0 ? "nothing was written" : std::generic_category().message(error);
  const std::string place = directory_.string() + ": ";
  if (is_one_of(of_full_disks)) {
    throw StorageFull(place + "the disk accepts no more data (" + why +
                      "): make room there, or check the disk");
  }
  if (is_one_of(of_lost_places)) {
    throw StorageFull(place + file.lexically_relative(directory_).string() +
                      " cannot be written (" + why + "): make the directory writable again");
  }
  throw RunError("writing " + file.string() + " failed: " + why);
}

void StateFiles::make_directory(const fs::path& directory) {
  if (directory == directory_) return;
  make_directory(directory.parent_path());
  std::error_code error;
  if (fs::create_directory(directory, error)) {
    unsynced_.insert(directory.parent_path());
  } else if (error) {
    fail(directory, error.value());
  }
}

void StateFiles::write_and_sync(int file, std::span<const std::string_view> pieces,
                                std::uint64_t offset, const fs::path& path) {
  write_all(file, pieces, offset, path);
  if (disk_.sync(file) != 0) fail(path, errno);
}

void StateFiles::write_all(int file, std::span<const std::string_view> pieces, std::uint64_t offset,
                           const fs::path& path) {
  for (std::string_view piece : pieces) {
    while (!piece.empty()) {
      const ssize_t written = disk_.write(file, piece, offset);
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) fail(path, written < 0 ? errno : 0);
      offset += static_cast<std::uint64_t>(written);
      piece.remove_prefix(static_cast<std::size_t>(written));
    }
  }
}

WholeFile StateFiles::write(const fs::path& file, std::span<const std::string_view> pieces) {
  make_directory(file.parent_path());
  const fs::path temporary = StateFiles::temporary(file);
  const WholeFile made = whole_file_of(pieces);
  try {
    const OpenPath out(temporary, O_WRONLY | O_CREAT | O_TRUNC);
    if (out.get() < 0) fail(temporary, errno);
    write_and_sync(out.get(), pieces, 0, temporary);
    if (disk_.rename(temporary.c_str(), file.c_str()) != 0) fail(file, errno);
  } catch (const RunError&) {
    unlink(temporary.c_str());  // frees its room
    throw;
  }
  unsynced_.insert(file.parent_path());
  return made;
}

void StateFiles::write_at(const fs::path& file, std::uint64_t offset,
                          std::span<const std::string_view> pieces) {
  if (offset == 0) {
    make_directory(file.parent_path());
    unsynced_.insert(file.parent_path());
  }
  const OpenPath out(file, O_WRONLY | O_CREAT);
  if (out.get() < 0) fail(file, errno);
  try {
    write_and_sync(out.get(), pieces, offset, file);
  } catch (const RunError&) {
    if (ftruncate(out.get(), static_cast<off_t>(offset)) != 0) {
      // The partial data occupies room until the next write.
    }
    throw;
  }
}

void StateFiles::overwrite(const fs::path& file, std::string_view bytes) {
  make_directory(file.parent_path());
  unsynced_.insert(file.parent_path());
  const OpenPath out(file, O_WRONLY | O_CREAT | O_TRUNC);
  if (out.get() < 0) fail(file, errno);
  written_.insert(file);
  write_all(out.get(), std::span(&bytes, 1), 0, file);
}

void StateFiles::overwrite_later(const fs::path& file, std::string_view bytes) {
  const OpenPath out(file, O_WRONLY);
  if (out.get() >= 0 && disk_.write(out.get(), bytes, 0) < 0) {
    return;  // the file keeps its content
  }
}

void StateFiles::rename(const fs::path& from, const fs::path& onto) {
  if (disk_.rename(from.c_str(), onto.c_str()) != 0) fail(onto, errno);
}

void StateFiles::sync() {
  constexpr std::size_t many = 16;
  if (file_system_->get() >= 0 && written_.size() + unsynced_.size() > many) {
    if (disk_.sync_file_system(file_system_->get()) != 0) fail(directory_, errno);
    written_.clear();
    unsynced_.clear();
    return;
  }
  while (!written_.empty()) {
    const fs::path& file = *written_.begin();
    const OpenPath written(file, O_RDONLY);
    const bool removed = written.get() < 0 && errno == ENOENT;  // after a failed commit
    if (!removed && (written.get() < 0 || disk_.sync(written.get()) != 0)) fail(file, errno);
    written_.erase(written_.begin());
  }
  while (!unsynced_.empty()) {
    const fs::path& directory = *unsynced_.begin();
    const OpenPath open_directory(directory, O_RDONLY | O_DIRECTORY);
    // EINVAL: the file system cannot sync directories.
    if (open_directory.get() < 0 ||
        (disk_.sync_directory(open_directory.get()) != 0 && errno != EINVAL)) {
      fail(directory, errno);
    }
    unsynced_.erase(unsynced_.begin());
  }
}

void StateFiles::keep_reserve() {
  if (reserved_) return;
  constexpr std::size_t reserve_bytes = 262'144;  // about ten commits of the database
  try {
    write(reserve(), std::string(reserve_bytes, '\0'));
    reserved_ = true;
  } catch (const RunError&) {
    // The commit itself has succeeded. The next commit tries again.
  }
}

bool StateFiles::release_reserve() {
  std::error_code ignored;
  return std::exchange(reserved_, false) && fs::remove(reserve(), ignored);
}

std::string StateFiles::read(const fs::path& file, const WholeFile& expected) {
  const auto damaged = [&](const std::string& why) {
    return DamagedFile(file.string() + " is damaged: " + why);
  };
  const OpenPath in(file, O_RDONLY);
  if (in.get() < 0 && errno == ENOENT) throw damaged("it is missing");
  if (in.get() < 0) {
    throw RunError(file.string() + " cannot be read: " + std::generic_category().message(errno));
  }
  std::error_code error;
  if (fs::file_size(file, error) != expected.bytes || error) {
    throw damaged("it does not have its committed size");
  }
  std::string bytes(expected.bytes, '\0');
  const ssize_t got = in.read(bytes, 0);
  if (got < 0) throw damaged(std::generic_category().message(errno));
  if (got < std::ssize(bytes)) throw damaged("it ends early");
  if (checksum_of(bytes) != expected.checksum) throw damaged("it fails its checksum");
  return bytes;
}

void StateFiles::remove(const fs::path& path) {
  std::error_code ignored;
  fs::remove(path, ignored);
}

void StateFiles::cut(const fs::path& file, std::uint64_t bytes) {
  std::error_code error;
  if (fs::file_size(file, error) > bytes && !error) fs::resize_file(file, bytes, error);
}

bool StateFiles::move_to_lost(const fs::path& file, std::uint64_t uptime) {
  const fs::path place = lost() / std::to_string(uptime) / file.lexically_relative(directory_);
  std::error_code error;
  fs::create_directories(place.parent_path(), error);
  fs::rename(file, free_path(place), error);
  return !error;
}

void StateFiles::move_unnamed_in_to_lost(const fs::path& directory, const std::set<fs::path>& named,
                                         std::uint64_t uptime, std::vector<fs::path>& moved) {
  std::vector<fs::path> unnamed;
  for (const fs::directory_entry& entry : entries_of(directory)) {
    const std::string name = entry.path().filename().string();
    if (is_temporary(name)) {
      std::error_code ignored;
      fs::remove(entry.path(), ignored);
    } else if (is_kept_name(name) && !named.contains(entry.path())) {
      unnamed.push_back(entry.path());
    }
  }
  std::ranges::sort(unnamed);
  for (const fs::path& file : unnamed) {
    if (move_to_lost(file, uptime)) moved.push_back(file);
  }
}

std::vector<fs::path> StateFiles::move_unnamed_to_lost(const std::set<fs::path>& named,
                                                       std::uint64_t uptime) {
  std::vector<fs::path> moved;
  move_unnamed_in_to_lost(scenes(), named, uptime, moved);
  for (const JobId id : jobs_with_directory()) {
    move_unnamed_in_to_lost(job(id), named, uptime, moved);
    std::error_code not_empty;
    fs::remove(job(id), not_empty);
  }
  return moved;
}

std::uint64_t StateFiles::lost_bytes() const {
  std::uint64_t bytes = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(lost(), error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code gone;
    const std::uint64_t size = entry->is_regular_file(gone) ? entry->file_size(gone) : 0;
    bytes += gone ? 0 : size;
  }
  return bytes;
}

void StateFiles::remove_lost(double uptime) const {
  for (const fs::directory_entry& entry : entries_of(lost())) {
    const std::string name = entry.path().filename().string();
    if (is_digits(name) && std::strtod(name.c_str(), nullptr) < uptime) {
      std::error_code ignored;  // the next call tries again
      fs::remove_all(entry.path(), ignored);
    }
  }
}

}  // namespace parray::store

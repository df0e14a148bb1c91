#include "cli/input/particles/packed_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>
#include <vector>

#include "cli/input/particles/particle_text.h"
#include "common/base/module.h"
#include "common/base/printable.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

struct Packing {
  std::string_view name;
  std::string_view signature;
  std::array<std::string_view, 2> extensions;
};

// RFC 1952; the bzip2 format; the .xz file format, 2.1.1; RFC 8878, 3.1.1.
constexpr std::array<Packing, 4> packings{{{"gzip", "\x1f\x8b", {".gz", ".gzip"}},
                                           {"bzip2", "BZh", {".bz2", ".bzip2"}},
                                           {"xz", {"\xfd\x37zXZ\0", 6}, {".xz", ".xz"}},
                                           {"zstd", "\x28\xb5\x2f\xfd", {".zst", ".zstd"}}}};

/// As read(), from a place of the file, or where it has no places (at < 0) from where it stands.
std::size_t read_some(int file, char* to, std::size_t bytes, std::int64_t at,
                      const FilePlace& place) {
  for (;;) {
    const ssize_t got = at < 0 ? ::read(file, to, bytes) : pread(file, to, bytes, at);
    if (got >= 0) return static_cast<std::size_t>(got);
    if (errno != EINTR) place.fail("reading failed (" + last_system_error() + "): check its disk");
  }
}

struct stat status_of(int file, const FilePlace& place) {
  struct stat status {};
  if (fstat(file, &status) != 0) {
    place.fail("cannot be opened (" + last_system_error() + "): check the path");
  }
  if (S_ISDIR(status.st_mode)) place.fail("is a directory: name a file in it");
  return status;
}

std::unique_ptr<Unpacker> unpacker_for(std::string_view packing, int file) {
  if (packing == "gzip") return unpack_gzip(file);
  static const auto unpack = reinterpret_cast<UnpackerEntry>(module_entry(
      "unpack.so", unpacker_entry, "what expands packed files", "install ParRay again"));
  return std::unique_ptr<Unpacker>(unpack(file));
}

}  // namespace

std::filesystem::path unpacked_name(const std::filesystem::path& path) {
  const std::string extension = lower_case(path.extension().string());
  const auto has_it = [&](const Packing& packing) {
    return std::ranges::find(packing.extensions, extension) != packing.extensions.end();
  };
  return std::ranges::any_of(packings, has_it) ? path.parent_path() / path.stem() : path;
}

PackedFile::PackedFile(const std::filesystem::path& path) : place_{path.string()}, path_(path) {
  OpenFile file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.number() < 0) {
    if (errno == ENOENT || errno == ENOTDIR) place_.fail("no such file: check the path");
    place_.fail("cannot be opened (" + last_system_error() + "): check " +
                (errno == EACCES ? "its permissions" : "the path"));
  }
  take(std::move(file));
}

PackedFile::PackedFile(StandardInput /*unused*/) : place_{"standard input"} {
  OpenFile file(dup(STDIN_FILENO));
  if (file.number() < 0) place_.fail("is closed: name a file, or send one through a pipe");
  take(std::move(file));
}

PackedFile PackedFile::of_argument(const std::string& argument) {
  if (argument == standard_input_argument) return PackedFile(StandardInput{});
  return PackedFile(argument);
}

void PackedFile::take(OpenFile file) {
  struct stat status = status_of(file.number(), place_);
  if (!S_ISREG(status.st_mode)) {
    const auto read = [&](char* to, std::size_t bytes) {
      return read_some(file.number(), to, bytes, -1, place_);
    };
    file = spooled(read, place_);
    status = status_of(file.number(), place_);
  }
  file_ = std::move(file);
  std::array<char, 6> first{};
  const std::size_t got = read_some(file_.number(), first.data(), first.size(), 0, place_);
  if (got == 0 || status.st_size == 0) place_.fail("the file is empty: is it complete?");
  const std::string_view bytes(first.data(), got);
  const auto is_it = [&](const Packing& known) { return bytes.starts_with(known.signature); };
  const auto* const packing = std::ranges::find_if(packings, is_it);
  if (packing == packings.end()) {
    size_ = static_cast<std::uint64_t>(status.st_size);
  } else {
    packing_ = packing->name;
    rewind();
  }
}

void PackedFile::rewind() {
  position_ = total_ = 0;
  if (!packing_.empty()) unpacker_ = unpacker_for(packing_, file_.number());
}

std::size_t PackedFile::read_plain(char* to, std::size_t bytes) {
  std::size_t done = 0;
  while (done < bytes) {
    const std::size_t got = read_some(file_.number(), to + done, bytes - done,
                                      static_cast<std::int64_t>(position_ + done), place_);
    if (got == 0) break;
    done += got;
  }
  return done;
}

std::size_t PackedFile::read_packed(char* to, std::size_t bytes) {
  const std::ptrdiff_t got = unpacker_->read(to, bytes);
  if (got >= 0) return static_cast<std::size_t>(got);
  place_.fail("damaged " + std::string(packing_) + " data (" + printable(unpacker_->problem()) +
              "): copy or pack the file again");
}

std::size_t PackedFile::read(char* to, std::size_t bytes) {
  const std::size_t done = packing_.empty() ? read_plain(to, bytes) : read_packed(to, bytes);
  position_ += done;
  total_ += done;
  if (total_ > limits::max_scene_file_bytes) {
    place_.fail("holds more than " + std::to_string(limits::max_scene_file_bytes) +
                " bytes: split it");
  }
  return done;
}

bool PackedFile::skip(std::uint64_t bytes) {
  if (size_) {
    const std::uint64_t left = *size_ - std::min(*size_, position_);
    position_ += std::min(bytes, left);
    return bytes <= left;
  }
  std::vector<char> block(std::min<std::uint64_t>(bytes, std::uint64_t{1} << 17));
  while (bytes > 0) {
    const std::uint64_t part = std::min<std::uint64_t>(bytes, block.size());
    if (read(block.data(), part) < part) return false;
    bytes -= part;
  }
  return true;
}

const FileStart& PackedFile::start() {
  if (!start_) {
    rewind();
    start_bytes_.resize(FileStart::max_bytes + 1);
    const std::size_t got = read(start_bytes_.data(), start_bytes_.size());
    start_bytes_.resize(std::min(got, FileStart::max_bytes));
    start_.emplace(start_bytes_, got <= FileStart::max_bytes);
    rewind();
  }
  return *start_;
}

}  // namespace parray::input

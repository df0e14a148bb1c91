#include "cli/input/particles/packed_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <functional>
#include <system_error>

#include "cli/input/particles/tar_member.h"
#include "common/base/module.h"
#include "common/base/printable.h"
#include "common/base/text.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

std::string last_system_error() { return std::generic_category().message(errno); }

bool is_control(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte < 0x20 && c != '\t' && c != '\n' && c != '\r' && c != '\f' && c != '\v';
}

namespace fs = std::filesystem;

fs::path temporary_folder() {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing here changes the environment
  const char* const chosen = std::getenv("TMPDIR");
  return chosen == nullptr || *chosen == '\0' ? fs::path("/tmp") : fs::path(chosen);
}

[[noreturn]] void fail_to_keep(const fs::path& folder, const FilePlace& place) {
  place.fail("cannot be copied to " + printable(folder.string(), 4096) + " (" +
             last_system_error() + "): set TMPDIR to a folder with free space");
}

OpenFile nameless_file(const fs::path& folder, const FilePlace& place) {
  std::string name = (folder / "parray-XXXXXX").string();
  OpenFile file(mkostemp(name.data(), O_CLOEXEC));
  if (file.number() < 0) fail_to_keep(folder, place);
  unlink(name.c_str());
  return file;
}

bool write_all(int file, const char* from, std::size_t bytes) {
  while (bytes > 0) {
    const ssize_t done = write(file, from, bytes);
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) return false;
    from += done;
    bytes -= static_cast<std::size_t>(done);
  }
  return true;
}

/// Copies the bytes that `read(to, bytes)` returns, until it returns 0, into a temporary file
/// without a name. Throws InputError beyond limits::max_scene_file_bytes. Throws it also if the
/// temporary folder (TMPDIR, or /tmp) cannot store the bytes.
OpenFile temporary_copy(const std::function<std::size_t(char* to, std::size_t bytes)>& read,
                        const FilePlace& place) {
  const fs::path folder = temporary_folder();
  OpenFile file = nameless_file(folder, place);
  std::vector<char> block(std::size_t{1} << 18);
  std::uint64_t total = 0;
  while (const std::size_t got = read(block.data(), block.size())) {
    total += got;
    if (total > limits::max_scene_file_bytes) {
      place.fail("more than " + std::to_string(limits::max_scene_file_bytes) + " bytes: split it");
    }
    if (!write_all(file.number(), block.data(), got)) fail_to_keep(folder, place);
  }
  return file;
}

class Gzip : public Unpacker {
 public:
  explicit Gzip(int file) {
    constexpr unsigned buffer_bytes = 1U << 17;
    lseek(file, 0, SEEK_SET);
    const int copy = dup(file);  // a copy, because gzclose() closes its descriptor
    file_.reset(gzdopen(copy, "rb"));
    if (file_ == nullptr) {
      close(copy);
    } else {
      gzbuffer(file_.get(), buffer_bytes);
    }
  }

  std::ptrdiff_t read(char* to, std::size_t bytes) override {
    if (file_ == nullptr) return -1;
    constexpr std::size_t most_at_once = std::size_t{1} << 30;  // gzread counts in int
    std::size_t done = 0;
    while (done < bytes) {
      const auto part = static_cast<unsigned>(std::min(bytes - done, most_at_once));
      const int got = gzread(file_.get(), to + done, part);
      if (got <= 0) {
        int code = Z_OK;
        gzerror(file_.get(), &code);
        if (code != Z_OK && code != Z_STREAM_END) return -1;
        break;
      }
      done += static_cast<std::size_t>(got);
    }
    return static_cast<std::ptrdiff_t>(done);
  }

  [[nodiscard]] std::string problem() const override {
    int code = Z_ERRNO;
    std::string_view text = file_ == nullptr ? "" : gzerror(file_.get(), &code);
    if (code == Z_ERRNO) return std::generic_category().message(errno);
    const std::size_t name_end = text.find(": ");  // "<fd:3>: reason"
    if (name_end != std::string_view::npos) text.remove_prefix(name_end + 2);
    return std::string(text);
  }

 private:
  struct Close {
    void operator()(gzFile file) const { gzclose_r(file); }
  };
  std::unique_ptr<gzFile_s, Close> file_;
};

struct Packing {
  std::string_view name;
  std::string_view of_tar;  ///< name of a packed tar archive
  std::string_view signature;
  std::array<std::string_view, 2> extensions;
};

// RFC 1952; the bzip2 format; the .xz file format, 2.1.1; RFC 8878, 3.1.1.
constexpr std::array<Packing, 4> packings{
    {{"gzip", "tar.gz", "\x1f\x8b", {".gz", ".gzip"}},
     {"bzip2", "tar.bz2", "BZh", {".bz2", ".bzip2"}},
     {"xz", "tar.xz", {"\xfd\x37zXZ\0", 6}, {".xz", ".xz"}},
     {"zstd", "tar.zst", "\x28\xb5\x2f\xfd", {".zst", ".zstd"}}}};
constexpr std::string_view plain_tar = "tar";

/// Does the same as read(), at byte `at` of the file. If at < 0, reads from the current position.
std::size_t read_some(int file, char* to, std::size_t bytes, std::int64_t at,
                      const FilePlace& place) {
  for (;;) {
    const ssize_t got = at < 0 ? ::read(file, to, bytes) : pread(file, to, bytes, at);
    if (got >= 0) return static_cast<std::size_t>(got);
    if (errno != EINTR) place.fail("reading failed (" + last_system_error() + "): check the disk");
  }
}

/// Reads `bytes` bytes at byte `at` of the file, fewer only at its end. Returns their number.
std::size_t read_all(int file, char* to, std::size_t bytes, std::uint64_t at,
                     const FilePlace& place) {
  std::size_t done = 0;
  while (done < bytes) {
    const std::size_t got =
        read_some(file, to + done, bytes - done, static_cast<std::int64_t>(at + done), place);
    if (got == 0) break;
    done += got;
  }
  return done;
}

struct stat status_of(int file, const FilePlace& place) {
  struct stat status {};
  if (fstat(file, &status) != 0) {
    place.fail("cannot be opened (" + last_system_error() + "): check the path");
  }
  if (S_ISDIR(status.st_mode)) place.fail("is a directory: name a file in it");
  return status;
}

class PlainBytes : public Unpacker {
 public:
  PlainBytes(int file, FilePlace place) : file_(file), place_(std::move(place)) {}

  std::ptrdiff_t read(char* to, std::size_t bytes) override {
    const std::size_t got = read_all(file_, to, bytes, at_, place_);
    at_ += got;
    return static_cast<std::ptrdiff_t>(got);
  }

  [[nodiscard]] std::string problem() const override { return {}; }  // read() throws

 private:
  int file_;
  FilePlace place_;
  std::uint64_t at_ = 0;
};

/// Returns the bytes of a file without `packing`, which is empty or the name of a compression.
std::unique_ptr<Unpacker> bytes_without(std::string_view packing, int file,
                                        const FilePlace& place) {
  if (packing.empty()) return std::make_unique<PlainBytes>(file, place);
  if (packing == "gzip") return std::make_unique<Gzip>(file);
  static const auto unpack = reinterpret_cast<UnpackerEntry>(
      module_entry("unpack.so", unpacker_entry, "the module that unpacks compressed files",
                   "install ParRay again"));
  return std::unique_ptr<Unpacker>(unpack(file));
}

std::unique_ptr<Unpacker> unpacker_for(std::string_view packing, int file, const FilePlace& place) {
  const auto* const of_tar = std::ranges::find(packings, packing, &Packing::of_tar);
  if (packing != plain_tar && of_tar == packings.end()) return bytes_without(packing, file, place);
  return tar_member(bytes_without(packing == plain_tar ? "" : of_tar->name, file, place));
}

/// Returns whether a file with this compression is a tar archive that contains one file.
bool is_tar_of_one(std::string_view packing, int file, const FilePlace& place) {
  std::array<char, tar_block_bytes> block{};
  const std::ptrdiff_t got = bytes_without(packing, file, place)->read(block.data(), block.size());
  return got == std::ssize(block) && begins_tar({block.data(), block.size()}) &&
         has_one_file(*bytes_without(packing, file, place));
}

}  // namespace

FileStart::FileStart(std::string_view bytes, bool whole)
    : bytes_(bytes), whole_(whole), is_text_(std::ranges::none_of(bytes, is_control)) {
  constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
  if (bytes.starts_with(byte_order_mark)) bytes.remove_prefix(byte_order_mark.size());
  if (is_text_) split_lines(bytes);
}

void FileStart::split_lines(std::string_view text) {
  while (!text.empty()) {
    const std::size_t end = text.find_first_of("\r\n");
    if (end == std::string_view::npos) {
      if (whole_) lines_.push_back(text);
      return;
    }
    lines_.push_back(text.substr(0, end));
    text.remove_prefix(end);
    text.remove_prefix(text.starts_with("\r\n") ? 2 : 1);
  }
}

std::uint32_t FileStart::little_endian(std::size_t at) const {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) {
    if (at + i >= bytes_.size()) return 0;
    value = value << 8 | static_cast<unsigned char>(bytes_[at + i]);
  }
  return value;
}

std::uint32_t FileStart::big_endian(std::size_t at) const {
  const std::uint32_t value = little_endian(at);
  return value << 24 | (value & 0xFF00) << 8 | (value >> 8 & 0xFF00) | value >> 24;
}

bool FileStart::has_line(std::string_view text) const {
  return std::ranges::any_of(lines_, [&](std::string_view line) { return trimmed(line) == text; });
}

OpenFile::~OpenFile() {
  if (number_ >= 0) close(number_);
}

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
  if (file.number() < 0) place_.fail("is closed: name a file or send data through a pipe");
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
    file = temporary_copy(read, place_);
    status = status_of(file.number(), place_);
  }
  file_ = std::move(file);
  std::array<char, 6> first{};
  const std::size_t got = read_some(file_.number(), first.data(), first.size(), 0, place_);
  if (got == 0 || status.st_size == 0) place_.fail_incomplete("the file is empty");
  const std::string_view bytes(first.data(), got);
  const auto is_it = [&](const Packing& known) { return bytes.starts_with(known.signature); };
  const auto* const packing = std::ranges::find_if(packings, is_it);
  if (packing != packings.end()) packing_ = packing->name;
  if (is_tar_of_one(packing_, file_.number(), place_)) {
    packing_ = packing == packings.end() ? plain_tar : packing->of_tar;
  }
  if (packing_.empty()) {
    size_ = static_cast<std::uint64_t>(status.st_size);
  } else {
    rewind();
  }
}

void PackedFile::rewind() {
  position_ = total_ = 0;
  ++rewinds_;
  if (!packing_.empty()) unpacker_ = unpacker_for(packing_, file_.number(), place_);
}

std::size_t PackedFile::read_packed(char* to, std::size_t bytes) {
  const std::ptrdiff_t got = unpacker_->read(to, bytes);
  if (got >= 0) return static_cast<std::size_t>(got);
  place_.fail("damaged " + std::string(packing_) + " data (" + printable(unpacker_->problem()) +
              "): copy or compress the file again");
}

std::size_t PackedFile::read(char* to, std::size_t bytes) {
  const std::size_t done = packing_.empty() ? read_all(file_.number(), to, bytes, position_, place_)
                                            : read_packed(to, bytes);
  position_ += done;
  total_ += done;
  if (total_ > limits::max_scene_file_bytes) {
    place_.fail("contains more than " + std::to_string(limits::max_scene_file_bytes) +
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

const FileStart& PackedFile::start(std::size_t bytes) {
  if (!start_ || (!start_->whole() && start_->bytes().size() < bytes)) {
    rewind();
    start_bytes_.resize(bytes + 1);
    const std::size_t got = read(start_bytes_.data(), start_bytes_.size());
    start_bytes_.resize(std::min(got, bytes));
    start_.emplace(start_bytes_, got <= bytes);
    rewind();
  }
  return *start_;
}

}  // namespace parray::input

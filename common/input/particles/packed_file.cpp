#include "common/input/particles/packed_file.h"

#include <algorithm>
#include <cerrno>
#include <string>
#include <string_view>
#include <system_error>

#include "common/base/printable.h"
#include "common/scene/limits.h"

namespace parray {
namespace {

constexpr unsigned buffer_bytes = 1U << 17;

/// Refuses what is not a file before it is opened: a directory opens, and only reading it fails.
std::optional<std::uint64_t> size_of(const std::filesystem::path& path, const FilePlace& place) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) {
    place.fail("no such file: check the path");
  }
  if (error) place.fail("cannot be opened (" + error.message() + "): check the path");
  if (std::filesystem::is_directory(status)) {
    place.fail("is a directory: name the file of particles in it");
  }
  if (!std::filesystem::is_regular_file(status)) return {};
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) return {};
  return size;
}

}  // namespace

PackedFile::PackedFile(const std::filesystem::path& path) : place_{path.string()} {
  const std::optional<std::uint64_t> size = size_of(path, place_);
  errno = 0;
  file_.reset(gzopen(path.c_str(), "rbe"));
  if (file_ == nullptr) {
    place_.fail("cannot be opened (" + std::generic_category().message(errno) +
                "): check its permissions");
  }
  gzbuffer(file_.get(), buffer_bytes);
  if (size == 0U) place_.fail("the file is empty: is it complete?");
  if (gzdirect(file_.get()) != 0) size_ = size;
}

std::size_t PackedFile::read(char* to, std::size_t bytes) {
  constexpr std::size_t most_at_once = std::size_t{1} << 30;  // gzread counts in int
  std::size_t done = 0;
  while (done < bytes) {
    const auto part = static_cast<unsigned>(std::min(bytes - done, most_at_once));
    const int got = gzread(file_.get(), to + done, part);
    if (got <= 0) {
      check_error();
      break;
    }
    done += static_cast<std::size_t>(got);
  }
  total_ += done;
  if (total_ > limits::max_scene_file_bytes) {
    place_.fail("holds more than " + std::to_string(limits::max_scene_file_bytes) +
                " bytes: split it");
  }
  return done;
}

void PackedFile::check_error() const {
  int code = Z_OK;
  const char* text = gzerror(file_.get(), &code);
  if (code == Z_OK || code == Z_STREAM_END) return;
  if (code == Z_ERRNO) {
    place_.fail("reading failed (" + std::generic_category().message(errno) + "): check its disk");
  }
  std::string_view reason(text);  // "PATH: reason"
  if (reason.starts_with(place_.file + ": ")) reason.remove_prefix(place_.file.size() + 2);
  place_.fail("damaged gzip data (" + printable(reason) + "): copy or pack the file again");
}

}  // namespace parray

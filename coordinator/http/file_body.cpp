#include "coordinator/http/file_body.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "common/base/error.h"

namespace parray::http {
namespace {

std::uint64_t size_of(const std::filesystem::path& file) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  return error ? 0 : size;
}

}  // namespace

FileBody::FileBody(const std::filesystem::path& file, Budget& disk)
    : held_(disk.hold(size_of(file), Time(0), "another picture")) {
  const std::size_t size = size_of(file);
  file_ = open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  void* const at = size == 0 ? nullptr : mmap(nullptr, size, PROT_READ, MAP_SHARED, file_, 0);
  unlink(file.c_str());
  if (file_ < 0 || at == MAP_FAILED) {
    const int error = errno;
    if (file_ >= 0) close(file_);
    throw RunError("opening " + file.string() + ": " + std::generic_category().message(error));
  }
  bytes_ = {static_cast<const char*>(at), size};
}

FileBody::~FileBody() {
  if (!bytes_.empty()) munmap(const_cast<char*>(bytes_.data()), bytes_.size());
  close(file_);
}

}  // namespace parray::http

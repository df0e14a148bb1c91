#include "cli/output/picture/partial_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <fstream>
#include <string>
#include <system_error>

#include "common/base/error.h"

namespace parray::picture {
namespace {

namespace fs = std::filesystem;

std::string reason_of(int error) { return std::generic_category().message(error); }

[[noreturn]] void fail(const fs::path& target, int error) {
  throw RunError("writing " + target.string() + ": " + reason_of(error));
}

/// Waits for the disk. File systems report some failures only here, such as a full disk of a
/// server.
void flush_to_disk(const fs::path& file, const fs::path& target) {
  const int fd = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) fail(target, errno);
  const bool failed = fsync(fd) != 0 && errno != EINVAL;  // EINVAL: the file cannot be flushed
  const int error = errno;
  close(fd);
  if (failed) fail(target, error);
}

/// Creates an empty file and removes it. Returns the error, or 0. This thread takes no signal
/// meanwhile, because a signal that ends the program would leave the file behind.
int try_to_create(const fs::path& file) {
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  const int fd = open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  const int failure = fd < 0 ? errno : 0;
  if (fd >= 0) {
    close(fd);
    unlink(file.c_str());
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return failure;
}

}  // namespace

void check_output_path(const fs::path& path) {
  const std::string name = path.string();
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) throw InputError(name + " is a directory: name a file in it");
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw InputError(name + " is not a regular file: name another file");
  }
  if (!path.has_filename()) {
    throw InputError("'" + name + "' does not name a file: add a file name");
  }
  const fs::path directory = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (!fs::is_directory(directory, error)) {
    throw InputError(name + ": the directory " + directory.string() +
                     " does not exist: create it first");
  }
  // Only a trial shows permissions, read-only file systems and too long names.
  if (const int failure = try_to_create(PartialFile(path).path()); failure != 0) {
    throw InputError(name + ": cannot create a file in directory " + directory.string() + ": " +
                     reason_of(failure));
  }
}

PartialFile::PartialFile(fs::path target)
    : target_(std::move(target)),
      partial_(target_.parent_path() / ("." + target_.stem().string() + ".partial-" +
                                        std::to_string(getpid()) + target_.extension().string())) {}

PartialFile::~PartialFile() {
  std::error_code ignored;  // the file may not exist
  fs::remove(partial_, ignored);
}

void PartialFile::commit() {
  flush_to_disk(partial_, target_);
  show();
}

void PartialFile::show() {
  std::error_code error;
  fs::rename(partial_, target_, error);
  if (error) fail(target_, error.value());
}

void write_file(const fs::path& path, const std::function<void(std::ostream&)>& write) {
  PartialFile file(path);
  try {
    errno = 0;
    std::ofstream out;
    out.exceptions(std::ios::badbit | std::ios::failbit);
    out.open(file.path(), std::ios::binary);
    write(out);
    out.close();
  } catch (const std::ios_base::failure&) {
    fail(path, errno != 0 ? errno : EIO);
  }
  file.commit();
}

void write_text_file(const fs::path& path, const std::string& text) {
  write_file(path, [&](std::ostream& out) { out << text; });
}

}  // namespace parray::picture

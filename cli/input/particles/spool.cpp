#include "cli/input/particles/spool.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "common/base/printable.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

namespace fs = std::filesystem;

fs::path temporary_folder() {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing here changes the environment
  const char* const chosen = std::getenv("TMPDIR");
  return chosen == nullptr || *chosen == '\0' ? fs::path("/tmp") : fs::path(chosen);
}

OpenFile nameless_file(const fs::path& folder, const FilePlace& place) {
  std::string name = (folder / "parray-XXXXXX").string();
  OpenFile file(mkostemp(name.data(), O_CLOEXEC));
  if (file.number() < 0) {
    place.fail("cannot be kept in " + printable(folder.string(), 4096) + " (" +
               last_system_error() + "): set TMPDIR to a folder that has room");
  }
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

}  // namespace

std::string last_system_error() { return std::generic_category().message(errno); }

OpenFile::~OpenFile() {
  if (number_ >= 0) close(number_);
}

OpenFile spooled(const std::function<std::size_t(char* to, std::size_t bytes)>& read,
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
    if (!write_all(file.number(), block.data(), got)) {
      place.fail("cannot be kept in " + printable(folder.string(), 4096) + " (" +
                 last_system_error() + "): set TMPDIR to a folder that has room");
    }
  }
  return file;
}

}  // namespace parray::input

#include "cli/output/input_files.h"

#include <sys/stat.h>

#include <optional>

#include "common/base/error.h"
#include "common/base/printable.h"

namespace parray::output {
namespace {

namespace fs = std::filesystem;

/// Returns device and inode of the file to which the path leads. Nothing: there is no such file.
std::optional<std::pair<dev_t, ino_t>> identity_of(const fs::path& path) {
  struct stat facts {};
  if (stat(path.c_str(), &facts) != 0) return {};
  return std::pair(facts.st_dev, facts.st_ino);
}

fs::path full_name(const fs::path& path) { return fs::absolute(path).lexically_normal(); }

}  // namespace

void InputFiles::add(const fs::path& file) {
  if (file.empty()) return;
  names_.insert(full_name(file));
  if (const auto identity = identity_of(file == "-" ? "/dev/stdin" : file)) {
    identities_.insert(*identity);
  }
}

void InputFiles::check(const fs::path& output) const {
  if (output.empty()) return;
  const auto identity = identity_of(output);
  if ((identity && identities_.contains(*identity)) || names_.contains(full_name(output))) {
    throw InputError(printable(output.string(), 4096) +
                     " is an input file: name another output file");
  }
}

}  // namespace parray::output

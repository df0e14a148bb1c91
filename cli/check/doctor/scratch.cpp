#include "cli/check/doctor/scratch.h"

#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>

#include "common/base/error.h"

namespace parray::doctor {

namespace fs = std::filesystem;

namespace {

/// Returns the same directory as std::filesystem::temp_directory_path(), whose errors do not name
/// it.
fs::path temporary_place() {
  for (const char* variable : {"TMPDIR", "TMP", "TEMP", "TEMPDIR"}) {
    const char* const place = std::getenv(variable);  // NOLINT(concurrency-mt-unsafe)
    if (place != nullptr) return place;
  }
  return "/tmp";
}

}  // namespace

Scratch::~Scratch() {
  std::error_code ignored;
  if (made()) fs::remove_all(path_, ignored);
}

void Scratch::make() {
  const fs::path place = temporary_place();
  std::string name = (place / "parray-doctor-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) {
    throw RunError(place.string() + ": " + std::generic_category().message(errno));
  }
  path_ = name;
}

}  // namespace parray::doctor

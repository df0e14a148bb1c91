#include "cli/doctor/scratch.h"

#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>

#include "common/base/error.h"

namespace parray {

namespace fs = std::filesystem;

Scratch::~Scratch() {
  std::error_code ignored;
  if (made()) fs::remove_all(path_, ignored);
}

void Scratch::make() {
  fs::path place;
  try {
    place = fs::temp_directory_path();
  } catch (const fs::filesystem_error& error) {
    throw RunError(error.path1().string() + ": " + error.code().message());
  }
  std::string name = (place / "parray-doctor-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) {
    throw RunError(place.string() + ": " + std::generic_category().message(errno));
  }
  path_ = name;
}

}  // namespace parray

#include <cerrno>
#include <fstream>
#include <system_error>

#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/input/scene_builder.h"
#include "common/input/scene_file.h"
#include "common/scene/limits.h"

namespace parray {
namespace {

[[noreturn]] void fail_file(const std::string& name, const std::string& problem) {
  constexpr std::size_t longest_path = 4096;
  throw InputError(printable(name, longest_path) + ": " + problem);
}

/// Refuses what is not a file before it is opened: a directory opens, and only reading it fails.
void check_file(const std::filesystem::path& path, const std::string& name) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) {
    fail_file(name, "no such file: check the path");
  }
  if (error) fail_file(name, "cannot be opened (" + error.message() + "): check the path");
  if (std::filesystem::is_directory(status)) {
    fail_file(name, "is a directory: name the scene file in it");
  }
  if (!std::filesystem::is_regular_file(status)) return;  // a pipe has no size
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (!error && size > limits::max_scene_file_bytes) {
    fail_file(name, "has " + std::to_string(size) + " bytes, more than " +
                        std::to_string(limits::max_scene_file_bytes) + ": split the scene");
  }
}

}  // namespace

SceneFile read_scene(std::istream& input, const std::string& name, int threads) {
  SceneBuilder builder(name);
  const std::uint64_t start_line = parse_json(input, name, builder);
  SceneFile file = builder.finish(start_line);
  file.duplicates = remove_duplicates(file.scene, threads);
  return file;
}

SceneFile read_scene_file(const std::filesystem::path& path, int threads) {
  const std::string name = path.string();
  check_file(path, name);
  errno = 0;
  std::ifstream input(path, std::ios::binary);
  if (!input) {
    fail_file(name, "cannot be opened (" + std::generic_category().message(errno) +
                        "): check its permissions");
  }
  return read_scene(input, name, threads);
}

}  // namespace parray

#include "common/base/files.h"

#include <fstream>
#include <iterator>

namespace parray::base {

std::optional<std::string> read_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), {}};
  return in.is_open() && !in.bad() && !std::filesystem::is_directory(path)
             ? std::optional(std::move(bytes))
             : std::nullopt;
}

bool write_file(const std::filesystem::path& path, std::string_view bytes) {
  std::ofstream out(path, std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  return out.good();
}

}  // namespace parray::base

#include "common/base/files.h"

#include <array>
#include <cstdlib>
#include <fstream>
#include <system_error>

namespace parray::base {

std::optional<std::string> read_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string bytes;
  constexpr std::streamsize block_size = 1 << 14;
  std::array<char, block_size> block{};
  // read() catches the exceptions of the stream's buffer. An iterator would pass them on.
  while (in.read(block.data(), block_size) || in.gcount() > 0) {
    bytes.append(block.data(), static_cast<std::size_t>(in.gcount()));
  }
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

std::filesystem::path make_directory(const std::filesystem::path& start) {
  std::string name = start.string() + "XXXXXX";
  return mkdtemp(name.data()) == nullptr ? "" : name;
}

OwnedPath::~OwnedPath() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace parray::base

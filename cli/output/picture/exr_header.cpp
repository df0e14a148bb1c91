#include "cli/output/picture/exr_header.h"

#include <array>
#include <bit>
#include <cstdint>
#include <fstream>
#include <limits>

#include "common/base/error.h"

namespace parray::picture {
namespace {

/// 0 at the end of the file.
std::uint32_t next_number(std::ifstream& in) {
  std::array<char, sizeof(std::uint32_t)> bytes{};
  in.read(bytes.data(), bytes.size());
  return in ? std::bit_cast<std::uint32_t>(bytes) : 0;
}

void skip_text(std::ifstream& in) { in.ignore(std::numeric_limits<std::streamsize>::max(), '\0'); }

/// True: past a header's end, false: past that of the file. A header is attributes (name, type,
/// size, value) and a zero.
bool skip_header(std::ifstream& in, std::uint64_t file_bytes, const std::filesystem::path& path) {
  while (in.peek() > 0) {
    skip_text(in);
    skip_text(in);
    const std::uint32_t size = next_number(in);
    if (!in) return false;
    const std::uint64_t left = file_bytes - static_cast<std::uint64_t>(in.tellg());
    if (size > left) {
      throw InputError(path.string() + ": an attribute of " + std::to_string(size) +
                       " bytes where " + std::to_string(left) + " follow: is the file complete?");
    }
    in.seekg(size, std::ios::cur);
  }
  return in.get() == 0;
}

}  // namespace

void check_exr_attributes(const std::filesystem::path& path) {
  constexpr std::uint32_t magic = 20000630;
  constexpr std::uint32_t many_parts = 0x1000;  // each with a header; an empty one ends them
  std::error_code error;
  const std::uint64_t file_bytes = std::filesystem::file_size(path, error);
  std::ifstream in(path, std::ios::binary);
  if (error || next_number(in) != magic) return;
  const bool more = (next_number(in) & many_parts) != 0;
  while (skip_header(in, file_bytes, path) && more && in.peek() > 0) {
  }
}

}  // namespace parray::picture

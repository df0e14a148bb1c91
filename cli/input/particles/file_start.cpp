#include "cli/input/particles/file_start.h"

#include <algorithm>

namespace parray::input {
namespace {

bool is_control(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte < 0x20 && c != '\t' && c != '\n' && c != '\r' && c != '\f' && c != '\v';
}

}  // namespace

FileStart::FileStart(std::string_view bytes, bool whole)
    : bytes_(bytes), whole_(whole), is_text_(std::ranges::none_of(bytes, is_control)) {
  constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
  if (bytes.starts_with(byte_order_mark)) bytes.remove_prefix(byte_order_mark.size());
  if (is_text_) split_lines(bytes);
}

void FileStart::split_lines(std::string_view text) {
  while (!text.empty() && lines_.size() < max_lines) {
    const std::size_t end = text.find_first_of("\r\n");
    if (end == std::string_view::npos) {
      if (whole_) lines_.push_back(text);
      return;
    }
    lines_.push_back(text.substr(0, end));
    text.remove_prefix(end);
    text.remove_prefix(text.starts_with("\r\n") ? 2 : 1);
  }
}

std::uint32_t FileStart::little_endian(std::size_t at) const {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) {
    if (at + i >= bytes_.size()) return 0;
    value = value << 8 | static_cast<unsigned char>(bytes_[at + i]);
  }
  return value;
}

std::uint32_t FileStart::big_endian(std::size_t at) const {
  const std::uint32_t value = little_endian(at);
  return value << 24 | (value & 0xFF00) << 8 | (value >> 8 & 0xFF00) | value >> 24;
}

}  // namespace parray::input

#include "common/base/printable.h"

#include <array>
#include <charconv>
#include <cstdint>

namespace parray::base {
namespace {

unsigned char byte_at(std::string_view text, std::size_t i) {
  return static_cast<unsigned char>(text[i]);
}

bool is_harmless(char32_t c) {
  if (c < 0x20 || (c >= 0x7F && c < 0xA0)) return false;  // C0, DEL, C1
  if (c >= 0x200B && c <= 0x200F) return false;           // zero width, direction marks
  if (c >= 0x2028 && c <= 0x202E) return false;           // line ends, overrides
  if (c == 0x061C || c == 0x180E) return false;    // Arabic direction mark, Mongolian separator
  if (c >= 0xE0000 && c <= 0xE007F) return false;  // tags: an invisible copy of ASCII
  return !(c >= 0x2060 && c <= 0x206F) && c != 0xFEFF && c != 0xAD;  // isolates, BOM, soft hyphen
}

std::string escape(char kind, std::uint32_t value, int digits) {
  constexpr std::string_view hex = "0123456789abcdef";
  std::string out{'\\', kind};
  for (int shift = 4 * (digits - 1); shift >= 0; shift -= 4) out += hex[(value >> shift) & 0xFU];
  return out;
}

std::string escape_of(char32_t c) {
  if (c < 0x80) return escape('x', c, 2);
  return c <= 0xFFFF ? escape('u', c, 4) : escape('U', c, 8);
}

}  // namespace

CodePoint first_code_point(std::string_view text) {
  const unsigned char lead = byte_at(text, 0);
  if (lead < 0x80) return {1, lead};
  const std::size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < length) return {};
  char32_t value = lead & (0xFFU >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    const unsigned char next = byte_at(text, i);
    if ((next & 0xC0U) != 0x80U) return {};
    value = (value << 6) | (next & 0x3FU);
  }
  constexpr std::array<char32_t, 5> least{0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = value >= 0xD800 && value <= 0xDFFF;
  if (value < least[length] || value > 0x10FFFF || surrogate) return {};
  return {length, value};
}

std::string printable(std::string_view text, std::size_t max_bytes) {
  constexpr std::string_view ellipsis = "...";
  std::string out;
  std::size_t cut = 0;  // last place where `out` may end so that the ellipsis fits
  while (!text.empty()) {
    const CodePoint c = first_code_point(text);
    const std::size_t taken = c.length == 0 ? 1 : c.length;
    if (c.length == 0) {
      out += escape('x', byte_at(text, 0), 2);
    } else if (is_harmless(c.value)) {
      out += text.substr(0, taken);
    } else {
      out += escape_of(c.value);
    }
    if (out.size() > max_bytes) return out.substr(0, cut).append(ellipsis);
    if (out.size() + ellipsis.size() <= max_bytes) cut = out.size();
    text.remove_prefix(taken);
  }
  return out;
}

std::string number_text(double value) {
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return {buffer.data(), end};
}

}  // namespace parray::base

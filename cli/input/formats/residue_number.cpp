#include <charconv>

#include "cli/input/formats/atom_record.h"
#include "common/base/ascii.h"

namespace parray::input {
namespace {

/// All of `text`, in `base`.
std::optional<std::int64_t> whole_in(std::string_view text, int base) {
  std::int64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value, base);
  if (error != std::errc() || stop != end) return {};
  return value;
}

std::int64_t power(std::int64_t base, std::size_t exponent) {
  std::int64_t value = 1;
  for (std::size_t i = 0; i < exponent; ++i) value *= base;
  return value;
}

/// After 9...9 comes A0...0, in base 36.
std::optional<std::int64_t> hybrid_36_in(std::string_view text) {
  constexpr std::int64_t base = 36;
  constexpr std::int64_t first = 10;  // "A"
  for (const char c : text) {
    if (!ascii::is_upper(c) && !ascii::is_digit(c)) return {};
  }
  const auto value = whole_in(text, base);
  if (!value) return {};
  return *value - first * power(base, text.size() - 1) + power(10, text.size());
}

}  // namespace

std::optional<std::int32_t> residue_number_in(std::string_view text) {
  constexpr std::size_t most = 6;  // digits that fit
  constexpr std::size_t hybrid_width = 4;
  if (text.starts_with('+')) text.remove_prefix(1);
  if (text.empty() || text.size() > most) return {};
  std::optional<std::int64_t> value = whole_in(text, 10);
  if (!value && text.size() == hybrid_width && ascii::is_upper(text[0])) value = hybrid_36_in(text);
  if (!value && text[0] != '-') value = whole_in(text, 16);
  if (!value) return {};
  return static_cast<std::int32_t>(*value);
}

}  // namespace parray::input

#include "cli/input/color/text_range.h"

#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

/// Parses one end of a range. An empty text leaves `end` open. Returns false for an invalid text.
bool read_end(std::string_view text, std::optional<RangeEnd>& end) {
  text = trimmed(text);
  if (text.empty()) return true;
  const bool percent = text.ends_with('%');
  if (percent) text.remove_suffix(1);
  const std::optional<double> value = number_in(text);
  if (value) end = RangeEnd{*value, percent};
  return value.has_value();
}

std::string end_text(const std::optional<RangeEnd>& end) {
  return end ? number_text(end->value) + (end->percent ? "%" : "") : std::string();
}

}  // namespace

std::optional<TextRange> text_range(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) return {};
  TextRange range;
  if (!read_end(text.substr(0, colon), range.low) ||
      !read_end(text.substr(colon + 1), range.high) || range.open()) {
    return {};
  }
  return range;
}

std::string text_of(const TextRange& range) {
  if (range.open()) return {};
  return end_text(range.low) + ":" + end_text(range.high);
}

}  // namespace parray::input

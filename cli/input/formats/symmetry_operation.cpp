#include "cli/input/formats/symmetry_operation.h"

#include <charconv>
#include <cmath>
#include <cstddef>

namespace parray::input {
namespace {

bool starts_number(char c) { return (c >= '0' && c <= '9') || c == '.'; }

/// The characters of one of the three parts, blanks left out.
class Part {
 public:
  explicit Part(std::string_view text) : text_(text) {}

  char peek() {
    while (!text_.empty() && (text_[0] == ' ' || text_[0] == '\t')) text_.remove_prefix(1);
    return text_.empty() ? '\0' : text_[0];
  }
  bool take(char c) {
    if (peek() != c) return false;
    text_.remove_prefix(1);
    return true;
  }
  std::optional<double> number() {
    peek();
    double value = 0;
    const auto [stop, error] =
        std::from_chars(text_.data(), text_.data() + text_.size(), value, std::chars_format::fixed);
    if (error != std::errc()) return {};
    text_.remove_prefix(static_cast<std::size_t>(stop - text_.data()));
    return value;
  }
  /// 0 to 2 of x, y, z.
  std::optional<std::size_t> axis() {
    constexpr std::string_view letters = "xyzXYZ";
    const char c = peek();
    const std::size_t at = c == '\0' ? std::string_view::npos : letters.find(c);
    if (at == std::string_view::npos) return {};
    text_.remove_prefix(1);
    return at % 3;
  }

 private:
  std::string_view text_;
};

/// A number, which may be a fraction.
std::optional<double> fraction_in(Part& part) {
  const std::optional<double> number = part.number();
  if (!number || !part.take('/')) return number;
  const std::optional<double> denominator = part.number();
  if (!denominator || *denominator == 0) return {};
  return *number / *denominator;
}

/// Terms such as "-x", "+1/2", "2*x", "x/2": adds them to a row.
bool read_row(std::string_view text, double* row) {
  Part part(text);
  if (part.peek() == '\0') return false;
  while (part.peek() != '\0') {
    double factor = part.take('-') ? -1 : 1;
    if (factor > 0) part.take('+');
    std::optional<std::size_t> axis;
    if (starts_number(part.peek())) {
      const auto number = fraction_in(part);
      if (!number) return false;
      factor *= *number;
      const bool times = part.take('*');
      axis = part.axis();
      if (times && !axis) return false;
    } else {
      axis = part.axis();
      if (!axis) return false;
      if (part.take('/')) {
        const auto denominator = part.number();
        if (!denominator || *denominator == 0) return false;
        factor /= *denominator;
      }
    }
    if (!std::isfinite(factor)) return false;
    row[axis.value_or(3)] += factor;
  }
  return true;
}

}  // namespace

std::optional<SymmetryOperation> symmetry_operation_in(std::string_view text) {
  SymmetryOperation operation{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t comma = text.find(',');
    if ((comma == std::string_view::npos) != (i == 2)) return {};
    if (!read_row(text.substr(0, comma), operation.data() + 4 * i)) return {};
    if (i < 2) text.remove_prefix(comma + 1);
  }
  return operation;
}

}  // namespace parray::input

#include "cli/input/scene_file/sphere_text.h"

#include <charconv>

#include "common/base/ascii.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

/// Reads a text from front to back. After a function returns false, the position is undefined.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : at_(text.data()), end_(text.data() + text.size()) {}

  [[nodiscard]] const char* at() const { return at_; }
  [[nodiscard]] std::size_t newlines() const { return newlines_; }

  /// Skips blanks, then takes `c`.
  bool take(char c) {
    skip_blanks();
    if (at_ == end_ || *at_ != c) return false;
    ++at_;
    return true;
  }

  bool take_string(std::string_view& text) {
    if (!take('"')) return false;
    const char* const start = at_;
    while (at_ != end_ && *at_ >= ' ' && *at_ <= '~' && *at_ != '"' && *at_ != '\\') ++at_;
    text = {start, static_cast<std::size_t>(at_ - start)};
    return take('"');
  }

  bool take_number(double& number, NumberRange range) {
    skip_blanks();
    const char* const start = at_;
    if (!pass_number()) return false;
    const auto [stop, error] = std::from_chars(start, at_, number);
    number += 0.0;  // -0 + 0 is +0
    return error == std::errc() && stop == at_ && number >= range.least && number <= range.most;
  }

  bool take_vector(Vec3d& v) {
    return take('[') && take_number(v.x, ranges::coordinate) && take(',') &&
           take_number(v.y, ranges::coordinate) && take(',') &&
           take_number(v.z, ranges::coordinate) && take(']');
  }

 private:
  void skip_blanks() {
    for (; at_ != end_ && (*at_ == ' ' || *at_ == '\n' || *at_ == '\r' || *at_ == '\t'); ++at_) {
      newlines_ += *at_ == '\n' ? 1U : 0U;
    }
  }

  bool pass_digits() {
    const char* const start = at_;
    while (at_ != end_ && ascii::is_digit(*at_)) ++at_;
    return at_ != start;
  }

  bool pass(std::string_view either) {
    if (at_ == end_ || either.find(*at_) == std::string_view::npos) return false;
    ++at_;
    return true;
  }

  /// Skips a number by the grammar of RFC 8259, section 6, which is stricter than std::from_chars.
  bool pass_number() {
    pass("-");
    if (!pass("0") && !pass_digits()) return false;
    if (pass(".") && !pass_digits()) return false;
    if (!pass("eE")) return true;
    pass("+-");
    return pass_digits();
  }

  const char* at_;
  const char* end_;
  std::size_t newlines_ = 0;
};

}  // namespace

std::optional<SphereText> next_sphere_text(std::string_view text) {
  Scanner in(text);
  SphereText out;
  bool center = false;
  bool radius = false;
  bool material = false;
  if (!in.take(',') || !in.take('{')) return {};
  for (int member = 0; member < 3; ++member) {
    std::string_view key;
    if ((member > 0 && !in.take(',')) || !in.take_string(key) || !in.take(':')) return {};
    if (key == "center" && !center) {
      center = in.take_vector(out.sphere.center);
      if (!center) return {};
    } else if (key == "radius" && !radius) {
      radius = in.take_number(out.sphere.radius, ranges::length);
      if (!radius) return {};
    } else if (key == "material" && !material) {
      material = in.take_string(out.material);
      if (!material) return {};
    } else {
      return {};
    }
  }
  if (!in.take('}')) return {};
  out.bytes = static_cast<std::size_t>(in.at() - text.data());
  out.newlines = in.newlines();
  return out;
}

}  // namespace parray::input

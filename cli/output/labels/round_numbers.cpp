#include "cli/output/labels/round_numbers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <string_view>

namespace parray::labels {
namespace {

constexpr std::array<double, 4> steps = {1, 2, 5, 10};
constexpr double slack = 1e-6;  // tolerance for values that were floats: 0.1 as a float is 0.1

double power_below(double value) { return std::pow(10, std::floor(std::log10(value))); }

/// Formats a number with `decimals` decimals and a typographic minus sign.
std::string fixed(double value, int decimals) {
  std::array<char, 400> text{};
  static_cast<void>(std::snprintf(text.data(), text.size(), "%.*f", decimals, std::abs(value)));
  const std::string digits = text.data();
  const bool zero = digits.find_first_not_of("0.") == std::string::npos;
  return (value < 0 && !zero ? "\u2212" : "") + digits;
}

/// Returns the text of factor times 10^exponent. `factor`: 1, 2 or 5.
std::string text_of_mark(double factor, int exponent) {
  const bool is_short = exponent >= -3 && exponent <= 4;
  if (is_short) return fixed(factor * std::pow(10, exponent), std::max(0, -exponent));
  return (factor == 1 ? "" : fixed(factor, 0) + "\u00b7") + power_of_ten(exponent);
}

}  // namespace

double round_below(double value) {
  const double power = power_below(value);
  return power * *std::find_if(steps.rbegin(), std::prev(steps.rend()),
                               [&](double step) { return step * power <= value * (1 + slack); });
}

double round_above(double value) {
  const double power = power_below(value);
  return power * *std::find_if(steps.begin(), std::prev(steps.end()),
                               [&](double step) { return step * power >= value * (1 - slack); });
}

Ticks ticks_between(double low, double high, int most) {
  const double range =
      high / most - low / most;  // divides first, because the difference may overflow
  double step = round_above(range);
  if (!(step > 0)) {  // a share of the range is too small for a double
    return {{low}, {fixed(low, 0)}, 0};
  }
  const auto first = [&] { return std::ceil(low / step - slack); };
  const auto last = [&] { return std::floor(high / step + slack); };
  while (last() - first() >= most) step = round_above(1.5 * step);
  if (std::isinf(step)) return {{0}, {"0"}, 0};  // only a range around 0 is so wide
  const double largest = std::max(std::abs(low), std::abs(high));
  Ticks ticks;
  if (largest >= 1e5 || largest < 1e-2) {
    ticks.exponent = static_cast<int>(std::floor(std::log10(largest) + slack));
  }
  const double unit = std::pow(10, ticks.exponent);
  constexpr double most_decimals = 17;
  const int decimals = static_cast<int>(
      std::clamp(-std::floor(std::log10(step / unit) + slack), 0.0, most_decimals));
  const double count = last() - first();
  for (int i = 0; i <= count; ++i) {
    const double value = (first() + i) * step;
    ticks.values.push_back(std::clamp(value, low, high));
    ticks.texts.push_back(fixed(value / unit, decimals));
  }
  if (ticks.values.empty()) {  // at the ends of double's range there are no numbers between
    ticks.values = {low};
    ticks.texts = {fixed(low / unit, decimals)};
  }
  return ticks;
}

Ticks log_ticks_between(double low, double high, int most) {
  const auto first = static_cast<int>(std::floor(std::log10(low) + slack));
  const auto last = static_cast<int>(std::floor(std::log10(high) + slack));
  const auto marks = [&](std::initializer_list<double> factors, int stride) {
    Ticks ticks;
    for (int exponent = first; exponent <= last; exponent += stride) {
      for (const double factor : factors) {
        const double value = factor * std::pow(10, exponent);
        if (low - value > low * slack || value - high > high * slack) continue;  // no overflow
        ticks.values.push_back(std::clamp(value, low, high));
        ticks.texts.push_back(text_of_mark(factor, exponent));
      }
    }
    return ticks;
  };
  const auto room = static_cast<std::size_t>(most);
  Ticks ticks = marks({1, 2, 5}, 1);
  if (ticks.values.size() > room) ticks = marks({1}, 1 + (last - first) / most);
  return ticks.values.size() < 2 ? ticks_between(low, high, most) : ticks;
}

std::string power_of_ten(int exponent) {
  constexpr std::array<std::string_view, 10> raised = {"\u2070", "\u00b9", "\u00b2", "\u00b3",
                                                       "\u2074", "\u2075", "\u2076", "\u2077",
                                                       "\u2078", "\u2079"};
  std::string text = exponent < 0 ? "10\u207b" : "10";
  for (const char digit : std::to_string(std::abs(exponent))) {
    text += raised.at(static_cast<std::size_t>(digit - '0'));
  }
  return text;
}

}  // namespace parray::labels

#include "cli/check/doctor/floating_point.h"

#include <bit>
#include <cmath>
#include <string>
#include <type_traits>

#include "cli/output/text.h"
#include "common/base/cpu_count.h"
#include "common/math/float_mode.h"

namespace parray::doctor {
namespace {

/// What differs from IEEE 754's own mode; empty: nothing.
std::string oddities(unsigned control) {
  std::string text;
  const auto add = [&](unsigned bits, const char* name) {
    const bool odd = ((control ^ float_control::ieee) & bits) != 0;
    if (odd) text += (text.empty() ? "" : ", ") + std::string(name);
  };
  add(float_control::denormal_results, "denormal results become 0");
  add(float_control::denormal_operands, "denormal operands count as 0");
  add(float_control::rounding, "rounding is not to nearest");
  add(float_control::exceptions, "exceptions stop the program");
  return text;
}

template <typename Real>
Real computed(char operation, Real first, Real second) {
  // At run time, by the processor: no compiler may know the operands.
  const volatile Real a = first;
  const volatile Real b = second;
  switch (operation) {
    case '+':
      return a + b;
    case '-':
      return a - b;
    case '*':
      return a * b;
    case '/':
      return a / b;
    default:
      return std::sqrt(a);
  }
}

template <typename Real, typename Bits>
std::size_t wrong_of(std::span<const RoundingCase<Bits>> cases) {
  std::size_t wrong = 0;
  for (const RoundingCase<Bits>& c : cases) {
    const Real result =
        computed(c.operation, std::bit_cast<Real>(c.first), std::bit_cast<Real>(c.second));
    wrong += std::bit_cast<Bits>(result) == c.result ? 0 : 1;
  }
  return wrong;
}

}  // namespace

Finding check_float_mode(std::span<const unsigned> found) {
  std::string odd;
  std::size_t threads = 0;
  for (const unsigned control : found) {
    const std::string here = oddities(control);
    if (!here.empty()) {
      odd = here;
      ++threads;
    }
  }
  if (threads == 0) {
    return passed("round to nearest, denormals kept, in " + counted(found.size(), "thread"));
  }
  return warned(odd + ", in " + std::to_string(threads) + " of " + counted(found.size(), "thread") +
                    " as they start",
                "tracing sets its own mode; look for a library that was linked with -ffast-math "
                "(LD_PRELOAD?)");
}

Finding check_float_mode() {
  const int threads = usable_cpus();
  std::vector<unsigned> found(static_cast<std::size_t>(threads) + 1, float_control::ieee);
  found[0] = float_control::read();
#pragma omp parallel for num_threads(threads) schedule(static, 1)
  for (int i = 0; i < threads; ++i) {
    found[static_cast<std::size_t>(i) + 1] = float_control::read();
  }
  return check_float_mode(found);
}

Finding check_rounding(std::span<const RoundingCase<std::uint32_t>> singles,
                       std::span<const RoundingCase<std::uint64_t>> doubles) {
  std::size_t wrong_singles = 0;
  std::size_t wrong_doubles = 0;
#pragma omp parallel num_threads(usable_cpus()) reduction(+ : wrong_singles, wrong_doubles)
  {
    const FloatMode ieee;
    wrong_singles += wrong_of<float>(singles);
    wrong_doubles += wrong_of<double>(doubles);
  }
  const std::string cases = counted(singles.size() + doubles.size(), "hard case");
  if (wrong_singles + wrong_doubles == 0) {
    return passed("+ - x / sqrt are correctly rounded in f32 and f64 (" + cases + ")");
  }
  return failed("wrong results of + - x / sqrt: " + std::to_string(wrong_singles) + " in f32, " +
                    std::to_string(wrong_doubles) + " in f64, over all threads (" + cases + ")",
                "do not render on this machine: its processor, or an emulator of one, is not IEEE "
                "754");
}

Finding check_rounding() { return check_rounding(single_cases, double_cases); }

}  // namespace parray::doctor

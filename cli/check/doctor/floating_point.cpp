#include "cli/check/doctor/floating_point.h"

#include <string>

#include "cli/output/text.h"
#include "common/base/cpu_count.h"
#include "common/math/float_mode.h"

namespace parray::doctor {
namespace {

/// Returns the differences from the default mode of IEEE 754. Empty: none.
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

}  // namespace

CheckResult check_float_mode(std::span<const unsigned> found) {
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
                    " when they start",
                "tracing is not affected, because it sets its own mode; look for a library that "
                "was linked with -ffast-math (LD_PRELOAD?)");
}

CheckResult check_float_mode() {
  const int threads = usable_cpus();
  std::vector<unsigned> found(static_cast<std::size_t>(threads) + 1, float_control::ieee);
  found[0] = float_control::read();
#pragma omp parallel for num_threads(threads) schedule(static, 1)
  for (int i = 0; i < threads; ++i) found[static_cast<std::size_t>(i) + 1] = float_control::read();
  return check_float_mode(found);
}

}  // namespace parray::doctor

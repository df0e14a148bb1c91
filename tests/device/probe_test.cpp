#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>

#include "tests/bench/device_probe.h"
#include "tests/support/rooms.h"

/// The operands of random operations: whether they show what a device may compute wrongly.
namespace parray::bench {
namespace {

/// Numbers of operations with a property.
struct Seen {
  int denormal_operand = 0, denormal_product = 0, denormal_quotient = 0;
  int infinite = 0, not_a_number = 0, zero = 0;
  int fused = 0;  ///< a fused product and sum has other bits

  template <typename Real>
  void add(const ProbeOperands<Real>& x) {
    const auto is_denormal = [](Real value) { return std::fpclassify(value) == FP_SUBNORMAL; };
    denormal_operand += is_denormal(x.a) || is_denormal(x.b) ? 1 : 0;
    denormal_product += is_denormal(x.a * x.b) ? 1 : 0;
    denormal_quotient += is_denormal(x.a / x.b) ? 1 : 0;
    infinite += std::isinf(x.a) || std::isinf(x.b) ? 1 : 0;
    not_a_number += std::isnan(x.a) || std::isnan(x.b) ? 1 : 0;
    zero += x.a == 0 || x.b == 0 ? 1 : 0;
    const Real exact = ProbeContract::of(x);
    const Real together = std::fma(x.a, x.b, x.c);
    fused += exact != together && !(std::isnan(exact) && std::isnan(together)) ? 1 : 0;
  }
};

template <typename Real>
void check_operands() {
  constexpr int count = 10'000;
  Seen seen;
  for (std::uint64_t i = 0; i < count; ++i) seen.add(probe_operands<Real>(i));
  for (const int often : {seen.denormal_operand, seen.denormal_product, seen.denormal_quotient,
                          seen.infinite, seen.not_a_number, seen.zero}) {
    CHECK(often > count / 200);
    CHECK(often < count / 5);
  }
  CHECK(seen.fused > count / 10);
}

}  // namespace

TEST_CASE("random operations have denormal, infinite and other special numbers, and show fusing") {
  check_operands<float>();
  check_operands<double>();
}

TEST_CASE("roots are mostly of numbers that have one") {
  int real = 0;
  for (std::uint64_t i = 0; i < 10'000; ++i) {
    real += std::isnan(probe<double, ProbeRoot>(i)) ? 0 : 1;
  }
  CHECK(real > 6'500);
  CHECK(real < 8'500);
}

}  // namespace parray::bench

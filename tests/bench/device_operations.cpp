#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <iomanip>
#include <mutex>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "tests/bench/device_checks.h"
#include "tests/bench/device_probe.h"
#include "tests/bench/on_processors.h"

namespace parray::bench {
namespace {

constexpr std::uint64_t most_of_a_launch = 1 << 24;

/// Returns a number with all its digits and its bits.
template <typename Real>
std::string text_of(Real value) {
  std::ostringstream text;
  text << std::setprecision(17) << value << " (0x" << std::hex
       << std::bit_cast<typename ProbeBits<Real>::Word>(value) << ")";
  return text.str();
}

/// Returns whether two results are the same. All NaN are: IEEE 754 leaves their bits open, and no
/// picture depends on them.
template <typename Real>
bool same(Real a, Real b) {
  using Word = typename ProbeBits<Real>::Word;
  return std::bit_cast<Word>(a) == std::bit_cast<Word>(b) || (std::isnan(a) && std::isnan(b));
}

/// Compares results of a device with those of the CPU.
template <typename Real, typename Operation>
class Comparison {
 public:
  /// `results`: those of the operations from number `first` on.
  void add(std::uint64_t first, const std::vector<Real>& results) {
    constexpr std::size_t piece = 1 << 16;
    on_processors((results.size() + piece - 1) / piece, [&](std::size_t number) {
      const std::size_t end = std::min(results.size(), (number + 1) * piece);
      for (std::size_t i = number * piece; i < end; ++i) {
        if (!same(results[i], probe<Real, Operation>(first + i))) note(first + i, results[i]);
      }
    });
  }
  [[nodiscard]] std::uint64_t wrong() const { return wrong_; }
  [[nodiscard]] const std::string& example() const { return example_; }

 private:
  void note(std::uint64_t index, Real found) {
    const std::lock_guard lock(mutex_);
    if (wrong_++ > 0) return;
    const auto x = probe_operands<Real>(index);
    example_ = "operation " + std::to_string(index) + " of a = " + text_of(x.a) +
               ", b = " + text_of(x.b) + ", c = " + text_of(x.c) + " is " + text_of(found) +
               ", not " + text_of(probe<Real, Operation>(index));
  }

  std::mutex mutex_;
  std::uint64_t wrong_ = 0;
  std::string example_;
};

/// Computes `count` operations on the device.
template <typename Real, typename Operation>
Json check_operation(const std::string& name, std::uint64_t count, const test::CudaDevice& device,
                     const test::CudaModule& probes, Verdict& verdict) {
  const test::CudaKernel kernel = probes.kernel(name);
  const test::CudaMemory memory(device.driver(), std::min(count, most_of_a_launch) * sizeof(Real));
  Comparison<Real, Operation> comparison;
  std::vector<Real> results;
  for (std::uint64_t first = 0; first < count; first += most_of_a_launch) {
    const auto size = static_cast<std::uint32_t>(std::min(most_of_a_launch, count - first));
    results.resize(size);
    device.launch(kernel, size, 256, first, size, memory.address());
    memory.copy_out(std::as_writable_bytes(std::span(results)));
    comparison.add(first, results);
  }
  if (comparison.wrong() > 0) {
    verdict.wrong(name + ", " + comparison.example() + " (" + std::to_string(comparison.wrong()) +
                  " of " + std::to_string(count) + " operations differ)");
  }
  return {{"operation", name}, {"count", count}, {"wrong", comparison.wrong()}};
}

/// Returns how often each operation is computed: divisions and roots share `count`.
std::uint64_t count_of(const std::string& name, std::uint64_t count) {
  const bool hard = name.ends_with("div") || name.ends_with("sqrt");
  return std::max<std::uint64_t>(1, count / (hard ? 4 : 40));
}

}  // namespace

Json check_operations(std::uint64_t count, const test::CudaDevice& device,
                      const test::CudaModule& probes, Verdict& verdict) {
  Json figures = Json::array();
  std::uint64_t all = 0;
  std::uint64_t wrong = 0;
  const auto add = [&](Json operation) {
    all += operation["count"].get<std::uint64_t>();
    wrong += operation["wrong"].get<std::uint64_t>();
    figures.push_back(std::move(operation));
  };
#define PARRAY_PROBE(name, Real, Operation) \
  add(check_operation<Real, Operation>(#name, count_of(#name, count), device, probes, verdict));
  PARRAY_FOR_EACH_DEVICE_PROBE(PARRAY_PROBE)
#undef PARRAY_PROBE
  std::printf("operations: %llu random ones, %llu wrong\n", static_cast<unsigned long long>(all),
              static_cast<unsigned long long>(wrong));
  return figures;
}

}  // namespace parray::bench

#include "common/base/bands.h"

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <vector>

namespace parray::base {
namespace {

constexpr std::size_t least_items = 1U << 14;

constexpr const char* wait_policy = "OMP_WAIT_POLICY";
bool has_set_policy = false;

/// Lets threads without work sleep. By default they spin for milliseconds after each parallel
/// region, which takes processors from other programs. The priority places this function before
/// OpenMP's runtime, which is linked statically, reads the variable. A value of the user stays.
[[gnu::constructor(101)]] void let_idle_threads_sleep() {
  // NOLINTBEGIN(concurrency-mt-unsafe): there are no threads
  has_set_policy = getenv(wait_policy) == nullptr;
  setenv(wait_policy, "passive", 0);
  // NOLINTEND(concurrency-mt-unsafe)
}

}  // namespace

void forget_wait_policy() {
  if (has_set_policy) unsetenv(wait_policy);  // NOLINT(concurrency-mt-unsafe): see the header
}

void side_by_side(std::size_t count, int threads, const std::function<void(std::size_t)>& work) {
  if (count == 1) return work(0);
  std::vector<std::exception_ptr> failures(count);
  const auto caught = [&](std::size_t i) {
    try {
      work(i);
    } catch (...) {
      failures[i] = std::current_exception();
    }
  };
  if (threads > 0) {
#pragma omp parallel for num_threads(threads) schedule(dynamic, 1)
    for (std::size_t i = 0; i < count; ++i) caught(i);
  } else {
#pragma omp parallel for schedule(dynamic, 1)
    for (std::size_t i = 0; i < count; ++i) caught(i);
  }
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
}

Bands::Bands(std::size_t items, int threads)
    : items_(items),
      count_(std::clamp<std::size_t>(items / least_items, 1,
                                     static_cast<std::size_t>(std::max(threads, 1)))) {}

std::size_t Bands::begin(std::size_t band) const {
  return items_ / count_ * band + std::min(band, items_ % count_);
}

void Bands::run(const Work& work) const {
  side_by_side(count_, static_cast<int>(count_),
               [&](std::size_t band) { work(band, begin(band), end(band)); });
}

}  // namespace parray::base

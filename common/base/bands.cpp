#include "common/base/bands.h"

#include <omp.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <system_error>
#include <thread>
#include <vector>

namespace parray {
namespace {

constexpr std::size_t least_items = 1U << 14;

}  // namespace

// Threads of its own, which end with the work: those of OpenMP's teams go on spinning for a while,
// and what is to be done side by side here is often less than that.
void side_by_side(std::size_t count, int threads, const std::function<void(std::size_t)>& work) {
  if (count == 1) {
    work(0);
    return;
  }
  std::vector<std::exception_ptr> failures(count);
  std::atomic<std::size_t> next = 0;
  const auto go = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        work(i);
      } catch (...) {
        failures[i] = std::current_exception();
      }
    }
  };
  const int most = threads > 0 ? threads : omp_get_max_threads();
  {
    std::vector<std::jthread> helpers;
    try {
      while (helpers.size() + 1 < std::min(count, static_cast<std::size_t>(most))) {
        helpers.emplace_back(go);
      }
    } catch (const std::system_error&) {  // as many as there may be
    }
    go();
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

}  // namespace parray

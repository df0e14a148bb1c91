#include "common/base/bands.h"

#include <algorithm>
#include <exception>
#include <vector>

namespace parray {
namespace {

constexpr std::size_t least_items = 1U << 14;

}  // namespace

Bands::Bands(std::size_t items, int threads)
    : items_(items),
      count_(std::clamp<std::size_t>(items / least_items, 1,
                                     static_cast<std::size_t>(std::max(threads, 1)))) {}

std::size_t Bands::begin(std::size_t band) const {
  return items_ / count_ * band + std::min(band, items_ % count_);
}

void Bands::run(const Work& work) const {
  if (count_ == 1) {
    work(0, 0, items_);
    return;
  }
  std::vector<std::exception_ptr> failures(count_);
#pragma omp parallel for num_threads(static_cast <int>(count_)) schedule(static, 1)
  for (std::size_t band = 0; band < count_; ++band) {
    try {
      work(band, begin(band), end(band));
    } catch (...) {
      failures[band] = std::current_exception();
    }
  }
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
}

}  // namespace parray

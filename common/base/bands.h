#pragma once

#include <cstddef>
#include <functional>

#include "common/rooms.h"

namespace parray::base {

/// Calls work(i) for i from 0 to `count` - 1, side by side on `threads` threads; 0: on as many as
/// OpenMP gives the caller. On fewer where the system gives no more. Of what they throw, the first
/// one's is thrown again.
void side_by_side(std::size_t count, int threads, const std::function<void(std::size_t)>& work);

/// A range of items cut into contiguous bands, one for each thread. Whatever is put together in the
/// order of the bands, or in none (sums of integers, extremes), is the same for any number of them.
class Bands {
 public:
  /// At most `threads` bands, fewer where there are few items: a thread costs as much as thousands.
  Bands(std::size_t items, int threads);

  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] std::size_t begin(std::size_t band) const;
  [[nodiscard]] std::size_t end(std::size_t band) const { return begin(band + 1); }

  using Work = std::function<void(std::size_t band, std::size_t begin, std::size_t end)>;
  /// Does all bands side by side, and throws what the first one of them has thrown.
  void run(const Work& work) const;

 private:
  std::size_t items_;
  std::size_t count_;
};

}  // namespace parray::base

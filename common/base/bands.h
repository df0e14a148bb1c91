#pragma once

#include <cstddef>
#include <functional>

#include "common/rooms.h"

namespace parray::base {

/// Calls work(i) for i from 0 to `count` - 1 in parallel on `threads` threads; 0: as many as OpenMP
/// gives the caller. Uses fewer threads if the system grants fewer. All calls are made even if some
/// throw; then rethrows the exception of the call with the lowest i.
void side_by_side(std::size_t count, int threads, const std::function<void(std::size_t)>& work);

/// A range of items cut into contiguous bands, one per thread. A result that is combined in the
/// order of the bands, or independently of any order (sums of integers, extremes), is the same for
/// any number of bands.
class Bands {
 public:
  /// Makes at most `threads` bands, and fewer for few items: a thread costs as much as thousands of
  /// items.
  Bands(std::size_t items, int threads);

  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] std::size_t begin(std::size_t band) const;
  [[nodiscard]] std::size_t end(std::size_t band) const { return begin(band + 1); }

  using Work = std::function<void(std::size_t band, std::size_t begin, std::size_t end)>;
  /// Does all bands in parallel. Rethrows the exception of the first band that threw.
  void run(const Work& work) const;

 private:
  std::size_t items_;
  std::size_t count_;
};

}  // namespace parray::base

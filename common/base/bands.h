#pragma once

#include <cstddef>
#include <functional>

#include "common/rooms.h"

namespace parray::base {

/// Calls work(i) for i from 0 to `count` - 1 in parallel on `threads` threads; 0: as many as OpenMP
/// gives the caller. Uses fewer threads if the system grants fewer. Makes all calls even if some
/// throw, and returns after the last one. Rethrows the exception of the lowest i that threw.
void side_by_side(std::size_t count, int threads, const std::function<void(std::size_t)>& work);

/// Removes OMP_WAIT_POLICY from the environment if this program has set it for its own threads, so
/// that a command of the user does not inherit it. No other thread may use the environment.
void forget_wait_policy();

/// A range of items cut into contiguous bands, one per thread. A result that is combined in the
/// order of the bands, or independently of any order (sums of integers, extremes), is the same for
/// any number of bands.
class Bands {
 public:
  /// Makes a band per 16384 items, but at least one and at most `threads`. More threads for few
  /// items would cost more time than they save.
  Bands(std::size_t items, int threads);

  [[nodiscard]] std::size_t count() const { return count_; }
  /// Returns the first item of a band, and with end() the item after its last.
  [[nodiscard]] std::size_t begin(std::size_t band) const;
  [[nodiscard]] std::size_t end(std::size_t band) const { return begin(band + 1); }

  using Work = std::function<void(std::size_t band, std::size_t begin, std::size_t end)>;
  /// Calls `work` for all bands in parallel, as side_by_side() does with a thread for each.
  void run(const Work& work) const;

 private:
  std::size_t items_;
  std::size_t count_;
};

}  // namespace parray::base

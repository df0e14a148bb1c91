#pragma once

#include <cstddef>
#include <functional>

namespace parray {

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
  /// Does all bands side by side. Of what they throw, the first band's is thrown again.
  void run(const Work& work) const;

 private:
  std::size_t items_;
  std::size_t count_;
};

}  // namespace parray

#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

#include "common/math/float_mode.h"
#include "tests/support/rooms.h"

namespace parray::bench {

/// Calls work(i) once for each i in [0, count), on all processors. `work` throws nothing.
template <typename Work>
void on_processors(std::size_t count, const Work& work) {
  std::atomic<std::size_t> next = 0;
  const auto take = [&] {
    const FloatMode ieee;
    for (std::size_t i = next++; i < count; i = next++) work(i);
  };
  std::vector<std::jthread> helpers;
  const std::size_t processors = std::max(1U, std::thread::hardware_concurrency());
  for (std::size_t i = 1; i < std::min(processors, count); ++i) helpers.emplace_back(take);
  take();
}

}  // namespace parray::bench

#pragma once

#include <spdlog/logger.h>

#include <cstddef>

#include "proto/clock.h"

namespace parray::coordinator {

/// Files that this process has open now, and may open.
struct DescriptorUse {
  std::size_t open = 0;
  std::size_t most = 0;
};
DescriptorUse descriptor_use();

/// Warns when connections, also those of peers that say nothing, have taken nearly all files that
/// this process may open: new workers and clients are not heard then.
class DescriptorWatch {
 public:
  explicit DescriptorWatch(spdlog::logger& log) : log_(log) {}

  /// Looks every few seconds, however often it is called.
  void look(Time now);
  /// The same at once, at these numbers.
  void judge(const DescriptorUse& use);

 private:
  spdlog::logger& log_;
  Time look_at_{};
  bool told_ = false;
};

}  // namespace parray::coordinator

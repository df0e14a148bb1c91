#pragma once

#include <cstddef>

#include "common/log/logger.h"
#include "proto/clock.h"

namespace parray::coordinator {

/// Makes malloc reuse freed blocks of up to 64 MiB. Results take blocks of up to 32 MiB; otherwise
/// malloc would return each to the system, which clears every new one.
void keep_freed_blocks();

/// Raises the limit of open files of this process as far as the system allows. Each of `workers`
/// workers and `http` HTTP connections needs a file descriptor. Clients, files and ZeroMQ need up
/// to 256 more. Throws InputError if the raised limit is less than the sum of these three.
void allow_connections(std::size_t workers, std::size_t http);

/// Number of files that this process has open, and that it may open.
struct DescriptorUse {
  std::size_t open = 0;
  std::size_t most = 0;
};
/// Reads both numbers from the system.
DescriptorUse descriptor_use();

/// Warns when connections use nearly all files that this process may open. Then new workers and
/// clients cannot connect. Connections of silent peers count, too.
class DescriptorWatch {
 public:
  explicit DescriptorWatch(spdlog::logger& log) : log_(log) {}

  /// Checks at most every five seconds, however often it is called.
  void look(Time now);
  /// Checks these numbers now. Logs when the state changes.
  void check(const DescriptorUse& use);

 private:
  spdlog::logger& log_;
  Time look_at_{};
  bool warned_ = false;
};

}  // namespace parray::coordinator

#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "proto/window.h"

namespace parray::proto {

/// An operation on a window, as a message carries it. The bytes of a put travel beside it.
struct WindowRequest {
  enum class Operation : std::uint64_t { fetch_add, load, store, put };
  Operation operation = Operation::load;
  std::uint64_t place = 0;  ///< a word; for put a byte
  std::uint64_t value = 0;  ///< for fetch_add the delta, for put the number of bytes
};

/// Window whose owner performs every operation on request: for MPI libraries without one-sided
/// communication. Every operation is complete on return.
class RequestWindow final : public Window {
 public:
  /// Sends a request, and the bytes of a put, to the owner. Returns the owner's reply.
  using Ask =
      std::function<std::uint64_t(const WindowRequest& request, std::span<const std::byte> bytes)>;

  explicit RequestWindow(Ask ask) : ask_(std::move(ask)) {}
  std::uint64_t fetch_add(std::size_t word, std::uint64_t delta) override;
  std::uint64_t load(std::size_t word) override;
  void store(std::size_t word, std::uint64_t value) override;
  void put(std::size_t offset, std::span<const std::byte> bytes) override;

 private:
  Ask ask_;
};

/// Performs a request on the owner's memory and returns the reply: the earlier value of a word, or
/// 0. `receive` fills the bytes of a put. Throws RunError if the request reaches outside `memory`.
std::uint64_t perform(const WindowRequest& request, std::span<std::byte> memory,
                      const std::function<void(std::span<std::byte> bytes)>& receive);

}  // namespace parray::proto

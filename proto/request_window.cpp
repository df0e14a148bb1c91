#include "proto/request_window.h"

#include "common/base/error.h"

namespace parray::proto {

using Operation = WindowRequest::Operation;

std::uint64_t RequestWindow::fetch_add(std::size_t word, std::uint64_t delta) {
  return ask_({Operation::fetch_add, word, delta}, {});
}
std::uint64_t RequestWindow::load(std::size_t word) { return ask_({Operation::load, word, 0}, {}); }
void RequestWindow::store(std::size_t word, std::uint64_t value) {
  ask_({Operation::store, word, value}, {});
}
void RequestWindow::put(std::size_t offset, std::span<const std::byte> bytes) {
  ask_({Operation::put, offset, bytes.size()}, bytes);
}

std::uint64_t perform(const WindowRequest& request, std::span<std::byte> memory,
                      const std::function<void(std::span<std::byte> bytes)>& receive) {
  const auto [operation, place, value] = request;
  const bool fits = operation == Operation::put
                        ? place <= memory.size() && value <= memory.size() - place
                        : place < memory.size() / sizeof(std::uint64_t);
  LocalWindow window(memory);
  if (fits) {
    switch (operation) {
      case Operation::fetch_add:
        return window.fetch_add(place, value);
      case Operation::load:
        return window.load(place);
      case Operation::store:
        window.store(place, value);
        return 0;
      case Operation::put:
        receive(memory.subspan(place, value));
        return 0;
    }
  }
  throw RunError("impossible request to a window");
}

}  // namespace parray::proto

#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/rooms.h"

namespace parray::proto {

/// One part of a message, as it travels. Copies share the bytes, so that passing them on copies
/// nothing. Immutable. A default frame is empty.
class Frame {
 public:
  Frame() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): a frame is a string that can be shared
  Frame(std::string bytes) {
    auto owned = std::make_shared<const std::string>(std::move(bytes));
    view_ = *owned;
    owner_ = std::move(owned);
  }
  /// `view` must stay valid as long as `owner` lives.
  Frame(std::shared_ptr<const void> owner, std::string_view view)
      : owner_(std::move(owner)), view_(view) {}

  [[nodiscard]] std::string_view view() const { return view_; }
  [[nodiscard]] std::size_t size() const { return view_.size(); }
  [[nodiscard]] const std::shared_ptr<const void>& owner() const { return owner_; }

  friend bool operator==(const Frame& a, const Frame& b) { return a.view_ == b.view_; }

 private:
  std::shared_ptr<const void> owner_;
  std::string_view view_;
};

/// A message as it travels: the control frame (MessagePack) and, for some types of messages, the
/// bulk frame (raw data). See PROTOCOL.md.
using Frames = std::vector<Frame>;

}  // namespace parray::proto

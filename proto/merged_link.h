#pragma once

#include <optional>
#include <string_view>
#include <utility>

#include "proto/inproc_link.h"
#include "proto/link.h"

namespace parray::proto {

/// Joins two links of a coordinator into one: `outer`, to other processes, and `inner`, its end of
/// an InprocHub (inproc_link.h). The hub's `on_arrival` must wake `outer`. To tell the peers apart,
/// this link puts a mark that starts with a zero byte before the ids of the hub's peers. No peer of
/// `outer` (a ZeroMQ ROUTER) can choose such an id.
class MergedLink final : public Link {
 public:
  /// Both links must outlive this object.
  MergedLink(Link& outer, Link& inner) : outer_(outer), inner_(inner) {}

  [[nodiscard]] Envelope seal(Message message) const override {
    return outer_.seal(std::move(message));
  }

  bool send(const PeerId& to, Envelope content) override {
    return to.starts_with(mark) ? inner_.send(to.substr(mark.size()), std::move(content))
                                : outer_.send(to, std::move(content));
  }

  /// Receives from both links in turns, so that neither can block the other.
  std::optional<Delivery> receive() override {
    inner_first_ = !inner_first_;
    auto delivery = inner_first_ ? from_inner() : outer_.receive();
    if (delivery) return delivery;
    return inner_first_ ? outer_.receive() : from_inner();
  }

  void wait(Time timeout) override { outer_.wait(timeout); }
  void wake() noexcept override { outer_.wake(); }

 private:
  static constexpr std::string_view mark{"\0inproc ", 8};

  std::optional<Delivery> from_inner() {
    auto delivery = inner_.receive();
    if (delivery) delivery->peer.insert(0, mark);
    return delivery;
  }

  Link& outer_;
  Link& inner_;
  bool inner_first_ = false;
};

}  // namespace parray::proto

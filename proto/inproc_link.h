#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string_view>
#include <utility>

#include "proto/link.h"

namespace parray::proto {

/// Links a coordinator with any number of peers inside one process. `parray render` uses it in
/// place of ZeroMQ; the HTTP interface uses it in addition. Any thread may call connect() and
/// connect_as(); each end belongs to one thread.
class InprocHub {
 public:
  /// A sender's thread calls `on_arrival` after each message to the coordinator, dropped or not.
  explicit InprocHub(std::function<void()> on_arrival = {});
  ~InprocHub();
  InprocHub& operator=(InprocHub&&) = delete;

  /// Returns the coordinator's end, which lives as long as the hub.
  Link& coordinator();

  /// Returns a new end with the coordinator as its only peer. The coordinator sees its messages as
  /// sent by a default Sender (keys.h) with `ours` set: it may do everything. The end must not
  /// outlive the hub.
  std::unique_ptr<Link> connect();
  /// Returns an end like connect(), but the coordinator sees its messages as sent by `sender`. The
  /// seal() of this end encodes messages. So the coordinator's decoder checks every range, as in
  /// messages from other processes.
  std::unique_ptr<Link> connect_as(Sender sender);

 private:
  class Mailbox;
  class CoordinatorEnd;
  class PeerEnd;

  std::unique_ptr<Link> add_peer(Sender sender, bool encodes);

  const std::function<void()> on_arrival_;
  std::mutex mutex_;  // guards peers_ and next_id_
  std::map<PeerId, std::shared_ptr<Mailbox>> peers_;
  std::uint64_t next_id_ = 1;
  std::shared_ptr<Mailbox> inbox_;
  std::unique_ptr<CoordinatorEnd> coordinator_;
};

/// Joins two links of a coordinator into one: `outer`, to other processes, and `inner`, its end of
/// an InprocHub. The hub's `on_arrival` must wake `outer`. To tell the peers apart,
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

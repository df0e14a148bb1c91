#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>

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
  class StrangersEnd;

  std::pair<PeerId, std::shared_ptr<Mailbox>> add_peer();

  const std::function<void()> on_arrival_;
  std::mutex mutex_;  // guards peers_ and next_id_
  std::map<PeerId, std::shared_ptr<Mailbox>> peers_;
  std::uint64_t next_id_ = 1;
  std::shared_ptr<Mailbox> inbox_;
  std::unique_ptr<CoordinatorEnd> coordinator_;
};

}  // namespace parray::proto

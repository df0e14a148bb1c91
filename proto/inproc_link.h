#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>

#include "proto/link.h"

namespace parray::proto {

/// A coordinator's end and any number of others, inside one process: what `parray render` uses in
/// ZeroMQ's place. Any thread may connect(); each end belongs to one thread.
class InprocHub {
 public:
  /// `on_arrival` is called, by any thread, when something has come for the coordinator.
  explicit InprocHub(std::function<void()> on_arrival = {});
  ~InprocHub();
  InprocHub(const InprocHub&) = delete;
  InprocHub& operator=(const InprocHub&) = delete;

  /// The coordinator's end; lives as long as the hub.
  Link& coordinator();

  /// A new end whose one peer is the coordinator. Must not outlive the hub.
  std::unique_ptr<Link> connect();
  /// An end that speaks for `sender`. What it sends is encoded, so that the coordinator's decoder
  /// looks at every range as it does at messages from outside.
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

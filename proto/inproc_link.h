#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <map>
#include <memory>
#include <mutex>

#include "proto/link.h"

namespace parray {

/// A coordinator's end and any number of others, inside one process: what `parray render` uses in
/// ZeroMQ's place. Any thread may connect(); each end belongs to one thread.
class InprocHub {
 public:
  InprocHub();
  ~InprocHub();
  InprocHub(const InprocHub&) = delete;
  InprocHub& operator=(const InprocHub&) = delete;

  /// The coordinator's end; lives as long as the hub.
  Link& coordinator();

  /// A new end whose one peer is the coordinator. Must not outlive the hub.
  std::unique_ptr<Link> connect();

 private:
  class Mailbox;
  class CoordinatorEnd;
  class PeerEnd;

  std::mutex mutex_;  // guards peers_ and next_id_
  std::map<PeerId, std::shared_ptr<Mailbox>> peers_;
  std::uint64_t next_id_ = 1;
  std::shared_ptr<Mailbox> inbox_;
  std::unique_ptr<CoordinatorEnd> coordinator_;
};

}  // namespace parray

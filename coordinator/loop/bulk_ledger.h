#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>

#include "proto/frame.h"
#include "proto/link.h"

namespace parray::coordinator {

/// Limits the memory of large answers. An answer counts from the request until the link releases
/// the bytes, which takes long if the client reads slowly.
///
/// Not thread-safe, but any thread may destroy tickets. Reads no clock.
class BulkLedger {
 public:
  /// `most`: bytes of all answers. `most_of_peer`: answers that one client may have at a time.
  BulkLedger(std::uint64_t most, std::size_t most_of_peer)
      : most_(most), most_of_peer_(most_of_peer) {}

  /// Counts one answer until it is destroyed.
  using Ticket = std::shared_ptr<const void>;
  /// Admits an answer of `bytes` bytes to a client. `request`: its number, for serves(peer,
  /// request). Null: there is no room now, or the client has `most_of_peer` answers. A single
  /// answer may exceed the limit if no other answer is counted. Takes logarithmic time in the
  /// numbers of clients and of their answers.
  Ticket admit(const PeerId& peer, std::uint64_t bytes, std::uint64_t request = 0);
  /// Returns whether an answer to this client is counted.
  [[nodiscard]] bool serves(const PeerId& peer) const;
  /// Returns whether an answer to the client's request of this number is counted.
  [[nodiscard]] bool serves(const PeerId& peer, std::uint64_t request) const;
  /// Returns the bytes of all counted answers.
  [[nodiscard]] std::uint64_t bytes() const;

 private:
  /// The counted answers. Tickets may outlive the ledger and share this.
  struct UnderWay {
    std::mutex mutex;                                        // guards the members below
    std::map<PeerId, std::multiset<std::uint64_t>> answers;  ///< numbers of requests
    std::uint64_t bytes = 0;
  };
  struct Entry;

  std::uint64_t most_;
  std::size_t most_of_peer_;
  std::shared_ptr<UnderWay> under_way_ = std::make_shared<UnderWay>();
};

/// Returns the same bytes. The frame and its copies keep the ticket alive.
Frame with_ticket(Frame bytes, BulkLedger::Ticket ticket);

}  // namespace parray::coordinator

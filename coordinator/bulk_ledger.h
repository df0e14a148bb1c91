#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <string>

#include "proto/frame.h"
#include "proto/link.h"

namespace parray {

/// Bounds the memory of large answers, from when a client asks until the link has let go of the
/// bytes: a client that reads slowly has them wait for it.
///
/// No clock. One thread; tickets may end in any.
class BulkLedger {
 public:
  /// `most`: bytes in all. `most_of_peer`: answers of one client at a time.
  BulkLedger(std::uint64_t most, std::size_t most_of_peer)
      : most_(most), most_of_peer_(most_of_peer) {}

  /// Stands for an answer as long as it lives.
  using Ticket = std::shared_ptr<const void>;
  /// Null: there is no room now. A client that waits for nothing else gets one answer, however
  /// large, while nobody waits for any. Takes linear time in the answers under way.
  Ticket admit(const PeerId& peer, std::uint64_t bytes);
  /// Of all answers under way.
  [[nodiscard]] std::uint64_t bytes() const;

 private:
  struct Entry {
    PeerId peer;
    std::weak_ptr<const void> ticket;
    std::uint64_t bytes = 0;
  };

  std::uint64_t most_;
  std::size_t most_of_peer_;
  std::list<Entry> entries_;
};

/// The same bytes; they keep the ticket as long as anybody has them.
Frame with_ticket(Frame bytes, BulkLedger::Ticket ticket);

}  // namespace parray

#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "proto/frame.h"
#include "proto/link.h"

namespace parray::coordinator {

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
  /// large, while nobody waits for any. Takes time that grows with the logarithm of the number of
  /// clients.
  Ticket admit(const PeerId& peer, std::uint64_t bytes);
  /// Of all answers under way.
  [[nodiscard]] std::uint64_t bytes() const;

 private:
  /// What is under way. Tickets outlive the ledger.
  struct UnderWay {
    std::mutex mutex;  // guards the two below
    std::map<PeerId, std::size_t> answers;
    std::uint64_t bytes = 0;
  };
  struct Entry;

  std::uint64_t most_;
  std::size_t most_of_peer_;
  std::shared_ptr<UnderWay> under_way_ = std::make_shared<UnderWay>();
};

/// The same bytes; they keep the ticket as long as anybody has them.
Frame with_ticket(Frame bytes, BulkLedger::Ticket ticket);

}  // namespace parray::coordinator

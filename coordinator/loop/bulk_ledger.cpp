#include "coordinator/loop/bulk_ledger.h"

#include <string_view>
#include <utility>

namespace parray::coordinator {

/// One counted answer. Its destructor subtracts it.
struct BulkLedger::Entry {
  std::shared_ptr<UnderWay> under_way;
  PeerId peer;
  std::uint64_t bytes = 0;
  std::uint64_t request = 0;

  Entry(std::shared_ptr<UnderWay> all, PeerId of, std::uint64_t size, std::uint64_t number)
      : under_way(std::move(all)), peer(std::move(of)), bytes(size), request(number) {}
  ~Entry() {
    const std::scoped_lock lock(under_way->mutex);
    under_way->bytes -= bytes;
    const auto answers = under_way->answers.find(peer);
    answers->second.erase(answers->second.find(request));
    if (answers->second.empty()) under_way->answers.erase(answers);
  }
  Entry& operator=(Entry&&) = delete;
};

BulkLedger::Ticket BulkLedger::admit(const PeerId& peer, std::uint64_t bytes,
                                     std::uint64_t request) {
  {
    const std::scoped_lock lock(under_way_->mutex);
    auto& answers = under_way_->answers;
    const auto of_peer = answers.find(peer);
    if ((of_peer != answers.end() && of_peer->second.size() >= most_of_peer_) ||
        (!answers.empty() && under_way_->bytes + bytes > most_)) {
      return nullptr;
    }
    answers[peer].insert(request);
    under_way_->bytes += bytes;
  }
  return std::make_shared<const Entry>(under_way_, peer, bytes, request);
}

bool BulkLedger::serves(const PeerId& peer) const {
  const std::scoped_lock lock(under_way_->mutex);
  return under_way_->answers.contains(peer);
}

bool BulkLedger::serves(const PeerId& peer, std::uint64_t request) const {
  const std::scoped_lock lock(under_way_->mutex);
  const auto of_peer = under_way_->answers.find(peer);
  return of_peer != under_way_->answers.end() && of_peer->second.contains(request);
}

std::uint64_t BulkLedger::bytes() const {
  const std::scoped_lock lock(under_way_->mutex);
  return under_way_->bytes;
}

Frame with_ticket(Frame bytes, BulkLedger::Ticket ticket) {
  using Held = std::pair<Frame, BulkLedger::Ticket>;
  const std::string_view view = bytes.view();
  return {std::make_shared<const Held>(std::move(bytes), std::move(ticket)), view};
}

}  // namespace parray::coordinator

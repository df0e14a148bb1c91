#include "coordinator/bulk_ledger.h"

#include <algorithm>
#include <string_view>
#include <utility>

namespace parray {

BulkLedger::Ticket BulkLedger::admit(const PeerId& peer, std::uint64_t bytes) {
  std::erase_if(entries_, [](const Entry& entry) { return entry.ticket.expired(); });
  const auto of_peer = static_cast<std::size_t>(
      std::ranges::count_if(entries_, [&](const Entry& entry) { return entry.peer == peer; }));
  if (of_peer >= most_of_peer_ || (!entries_.empty() && this->bytes() + bytes > most_)) {
    return nullptr;
  }
  const Ticket ticket = std::make_shared<char>();
  entries_.push_back({peer, ticket, bytes});
  return ticket;
}

std::uint64_t BulkLedger::bytes() const {
  std::uint64_t sum = 0;
  for (const Entry& entry : entries_) {
    sum += entry.ticket.expired() ? 0 : entry.bytes;
  }
  return sum;
}

Frame with_ticket(Frame bytes, BulkLedger::Ticket ticket) {
  using Held = std::pair<Frame, BulkLedger::Ticket>;
  const std::string_view view = bytes.view();
  return {std::make_shared<const Held>(std::move(bytes), std::move(ticket)), view};
}

}  // namespace parray

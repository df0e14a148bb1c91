#include "coordinator/http/seats.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <utility>

namespace parray::http {

Seats::Admission Seats::enter(Time now, ConnectionId id, const std::string& address) {
  const auto of_address = of_address_.find(address);
  const bool crowded = of_address != of_address_.end() && of_address->second >= limits_.of_address;
  Admission admission;
  if (crowded || ordinary_ >= limits_.connections) {
    admission.displaced = first_to_go(false, crowded ? &address : nullptr);
    admission.reserve = !admission.displaced;
  }
  if (admission.reserve && seats_.size() - ordinary_ >= limits_.reserve) {
    admission.displaced = first_to_go(true, nullptr);
    if (!admission.displaced) {
      admission.displaced = id;
      return admission;
    }
  }
  if (admission.displaced) leave(*admission.displaced);
  seats_[id] = {address, admission.reserve, Phase::idle, now};
  if (!admission.reserve) {
    ++ordinary_;
    ++of_address_[address];
  }
  return admission;
}

void Seats::leave(ConnectionId id) {
  const auto found = seats_.find(id);
  if (found == seats_.end()) return;
  if (!found->second.reserve) {
    --ordinary_;
    const auto count = of_address_.find(found->second.address);
    if (--count->second == 0) of_address_.erase(count);
  }
  seats_.erase(found);
}

void Seats::begins_head(Time now, ConnectionId id) {
  if (seats_.at(id).phase == Phase::idle) begin(Phase::head, now, id);
}

void Seats::begin(Phase phase, Time now, ConnectionId id) {
  Seat& seat = seats_.at(id);
  seat.phase = phase;
  seat.since = now;
}

std::vector<ConnectionId> Seats::late(Time now) const {
  std::vector<ConnectionId> found;
  for (const auto& [id, seat] : seats_) {
    if (now >= deadline(seat)) found.push_back(id);
  }
  return found;
}

/// Returns the connection to close first: those whose last answer was sent, then those that have
/// not sent a request, the oldest first. `address`: null for all addresses.
std::optional<ConnectionId> Seats::first_to_go(bool reserve, const std::string* address) const {
  std::optional<ConnectionId> found;
  std::pair first(true, never);
  for (const auto& [id, seat] : seats_) {
    const bool eligible = seat.phase != Phase::asked && seat.reserve == reserve &&
                          (address == nullptr || seat.address == *address);
    const std::pair rank(seat.phase != Phase::ended, seat.since);
    if (eligible && rank < first) {
      found = id;
      first = rank;
    }
  }
  return found;
}

Time Seats::deadline(const Seat& seat) const {
  if (seat.phase == Phase::asked || seat.phase == Phase::ended) return never;
  if (seat.reserve) return seat.since + limits_.reserve_time;
  return seat.since + (seat.phase == Phase::head ? limits_.head_time : limits_.idle_time);
}

std::string owner_of_address(const std::string& address) {
  std::array<unsigned char, sizeof(in6_addr)> bytes{};
  if (inet_pton(AF_INET6, address.c_str(), bytes.data()) != 1) return address;
  constexpr std::array<unsigned char, 12> mapped = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff};
  if (std::equal(mapped.begin(), mapped.end(), bytes.begin())) return address;
  std::fill(bytes.begin() + bytes.size() / 2, bytes.end(), static_cast<unsigned char>(0));
  std::array<char, INET6_ADDRSTRLEN> text{};
  inet_ntop(AF_INET6, bytes.data(), text.data(), text.size());
  return text.data();
}

}  // namespace parray::http

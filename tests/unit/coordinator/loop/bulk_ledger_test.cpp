#include "coordinator/loop/bulk_ledger.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "tests/support/rooms.h"

namespace parray {

TEST_CASE("the ledger limits the answers of one client and the bytes of all clients") {
  BulkLedger ledger(1000, 2);
  auto first = ledger.admit("ann", 300);
  const auto second = ledger.admit("ann", 300);
  REQUIRE(first);
  REQUIRE(second);
  CHECK_FALSE(ledger.admit("ann", 1));
  CHECK_FALSE(ledger.admit("bob", 500));
  const auto third = ledger.admit("bob", 400);
  CHECK(third);
  CHECK(ledger.bytes() == 1000);
  first.reset();
  CHECK(ledger.bytes() == 700);
  CHECK(ledger.admit("ann", 300));
}

TEST_CASE("an answer counts until all copies of its bytes are gone") {
  BulkLedger ledger(1000, 1);
  Frame frame = with_ticket(std::string("bytes"), ledger.admit("ann", 5));
  std::vector<Frame> queue{frame};
  frame = Frame();
  CHECK(queue.front().view() == "bytes");
  CHECK(ledger.bytes() == 5);
  CHECK_FALSE(ledger.admit("ann", 5));
  queue.clear();
  CHECK(ledger.bytes() == 0);
  CHECK(ledger.admit("ann", 5));
}

TEST_CASE("the ledger knows which requests of a client it serves") {
  BulkLedger ledger(1000, 3);
  auto first = ledger.admit("ann", 5, 1);
  const auto again = ledger.admit("ann", 5, 1);
  auto second = ledger.admit("ann", 5, 2);
  CHECK(ledger.serves("ann", 1));
  CHECK(ledger.serves("ann", 2));
  CHECK_FALSE(ledger.serves("ann", 3));
  CHECK_FALSE(ledger.serves("bob", 1));
  first.reset();
  second.reset();
  CHECK(ledger.serves("ann", 1));
  CHECK_FALSE(ledger.serves("ann", 2));
}

TEST_CASE("an answer above the limit is admitted if it is the only one") {
  BulkLedger ledger(1000, 2);
  auto large = ledger.admit("ann", 5000);
  CHECK(large);
  CHECK_FALSE(ledger.admit("bob", 1));
  large.reset();
  CHECK(ledger.admit("bob", 1));
}

TEST_CASE("admitting an answer does not take linear time in the number of answers") {
  constexpr std::size_t many = 200'000;  // quadratic time would take minutes
  BulkLedger ledger(many, many);
  std::vector<BulkLedger::Ticket> tickets;
  for (std::size_t i = 0; i < many; ++i) {
    tickets.push_back(ledger.admit(i % 2 == 0 ? "ann" : "client " + std::to_string(i), 1));
    REQUIRE(tickets.back());
  }
  CHECK(ledger.bytes() == many);
  CHECK_FALSE(ledger.admit("bob", 1));
  tickets.clear();
  CHECK(ledger.bytes() == 0);
}

TEST_CASE("a ticket may outlive its ledger") {
  BulkLedger::Ticket ticket;
  {
    BulkLedger ledger(1000, 2);
    ticket = ledger.admit("ann", 1);
  }
  ticket.reset();
}

}  // namespace parray

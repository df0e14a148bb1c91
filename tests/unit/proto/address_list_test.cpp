#include "proto/address_list.h"

#include <doctest/doctest.h>

#include "common/base/error.h"
#include "tests/support/rooms.h"

namespace parray {

TEST_CASE("a list leaves a silent address 5 s after the first unanswered message") {
  AddressList list("a,b");
  CHECK(list.current() == "a");
  CHECK_FALSE(list.move_on(seconds(100)));  // nothing was asked
  list.sent(seconds(100), 10);
  list.sent(seconds(104), 10);
  CHECK_FALSE(list.move_on(seconds(104)));
  CHECK(list.move_on(seconds(106)));
  CHECK(list.current() == "b");
  CHECK_FALSE(list.move_on(seconds(1000)));
}

TEST_CASE("an answer restarts the patience, and large messages extend it") {
  AddressList list("a,b");
  list.sent(seconds(0), 10);
  list.heard();
  CHECK_FALSE(list.move_on(seconds(50)));
  list.sent(seconds(60), 100'000'000);  // 10 s
  CHECK_FALSE(list.move_on(seconds(74)));
  CHECK(list.move_on(seconds(76)));
}

TEST_CASE("each round without an answer doubles the patience, up to 80 s") {
  AddressList list("a,b,c");
  Time now{};
  for (const Time patience :
       {seconds(5), seconds(10), seconds(20), seconds(40), seconds(80), seconds(80)}) {
    for (const char* const address : {"a", "b", "c"}) {
      CHECK(list.current() == address);
      list.sent(now, 1);
      CHECK_FALSE(list.move_on(now + patience - seconds(1)));
      now += patience + seconds(1);
      CHECK(list.move_on(now));
    }
  }
  list.heard();
  list.sent(now, 1);
  CHECK(list.move_on(now + seconds(6)));
}

TEST_CASE("a list never leaves its only address") {
  AddressList list("a");
  list.sent(seconds(0), 10);
  CHECK_FALSE(list.move_on(seconds(1000)));
}

TEST_CASE("a list with an empty or repeated address is refused") {
  for (const char* const text : {"", ",", "a,", ",a", "a,,b", "a,b,a"}) {
    CHECK_THROWS_AS(AddressList{text}, InputError);
  }
}

TEST_CASE("an address has a port from 1 to 65535, in digits and without signs") {
  for (const char* const good :
       {"tcp://a:1", "tcp://a:65535", "tcp://[::1]:7400", "ipc:///tmp/a"}) {
    CAPTURE(good);
    CHECK(has_port(good));
    CHECK(AddressList(good).current() == good);
  }
  for (const char* const bad :
       {"tcp://a:0", "tcp://a:65536", "tcp://a:99999", "tcp://a:-1", "tcp://a:+1", "tcp://a:75x",
        "tcp://a:99999999999", "tcp://a:", "tcp://a:*", "tcp://a"}) {
    CAPTURE(bad);
    CHECK_FALSE(has_port(bad));
    CHECK_THROWS_AS(AddressList{bad}, InputError);
  }
}

}  // namespace parray

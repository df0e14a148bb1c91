#include "coordinator/loop/farm_watch.h"

#include <doctest/doctest.h>

#include "tests/support/rooms.h"

namespace parray {
namespace {

TEST_CASE("the newest 200 events are kept, the newest first") {
  FarmWatch watch;
  for (int i = 0; i < 500; ++i) {
    watch.note({seconds(i), FarmEventKind::joined, "w" + std::to_string(i), 0, "joined"});
  }
  REQUIRE(watch.events().size() == 200);
  CHECK(watch.events().front().worker == "w499");
  CHECK(watch.events().back().worker == "w300");
}

TEST_CASE("the text of an event is short and printable") {
  FarmWatch watch;
  watch.note({Time(0), FarmEventKind::left, "w", 0, "\x1b[2J" + std::string(5000, 'x')});
  CHECK(watch.events().front().text.size() <= 300);
  CHECK(watch.events().front().text.find('\x1b') == std::string::npos);
}

TEST_CASE("ten thousand cancelled frames of a series are one event") {
  FarmWatch watch;
  watch.note({Time(0), FarmEventKind::job_failed, "", 3, "failed"});
  for (int i = 0; i < 10000; ++i) {
    watch.note({seconds(i), FarmEventKind::job_cancelled, "", 7, "cancelled", 1});
  }
  REQUIRE(watch.events().size() == 2);
  CHECK(watch.events().front().frames == 10000);
  CHECK(watch.events().front().at == seconds(9999));
}

TEST_CASE("single jobs stay separate events") {
  FarmWatch watch;
  for (int i = 0; i < 3; ++i) watch.note({seconds(i), FarmEventKind::job_done, "", 7, "done"});
  CHECK(watch.events().size() == 3);
}

TEST_CASE("a worker that left is remembered for an hour, or until it joins again") {
  FarmWatch watch;
  watch.note_left({seconds(0), "w1", "host", "key a", "silent", true});
  watch.note_left({seconds(10), "w2", "host", "key b", "stopped", false});
  watch.note_joined("w2");
  REQUIRE(watch.left().size() == 1);
  CHECK(watch.left().front().name == "w1");
  watch.forget_old(seconds(3600));
  CHECK(watch.left().size() == 1);
  watch.forget_old(seconds(3601));
  CHECK(watch.left().empty());
  for (int i = 0; i < 1000; ++i) watch.note_left({seconds(i), "w" + std::to_string(i)});
  CHECK(watch.left().size() == 200);
}

TEST_CASE("invented users do not fill the memory: accounts without time are dropped first") {
  FarmWatch watch;
  watch.account("ann").thread_seconds = 5;
  for (int i = 0; i < 5000; ++i) watch.account("user " + std::to_string(i));
  CHECK(watch.accounts().size() == FarmWatch::most_users);
  CHECK(watch.account("ann").thread_seconds == 5);
}

TEST_CASE("thread-seconds survive in the store, and a damaged note is ignored") {
  FarmWatch watch;
  watch.account("ann").thread_seconds = 12.5;
  watch.account("nobody");
  FarmWatch later;
  later.restore_accounts(watch.accounts_text());
  CHECK(later.account("ann").thread_seconds == 12.5);
  CHECK(later.accounts().size() == 1);
  for (const char* damaged :
       {"", "[]", "7", "{\"ann\":", R"({"ann": -3, "bob": "x", "c": null})"}) {
    FarmWatch fresh;
    fresh.restore_accounts(damaged);
    CHECK(fresh.accounts().empty());
  }
}

TEST_CASE("the state is noted once for each ten seconds, also after a pause, for an hour") {
  FarmWatch watch;
  CHECK(watch.gauges_due(seconds(95)));
  watch.note_gauges(seconds(95), {1, 2, 3});
  CHECK(watch.gauges().empty());  // no interval has ended
  CHECK_FALSE(watch.gauges_due(seconds(99)));
  CHECK(watch.gauges_due(seconds(100)));
  watch.note_gauges(seconds(125), {4, 5, 6});
  REQUIRE(watch.gauges().size() == 3);
  CHECK(watch.gauges().back().queued == 6);
  CHECK(watch.end_of_history() == 12);
  watch.note_gauges(std::chrono::hours(1000), {});
  CHECK(watch.gauges().size() == 360);
}

}  // namespace
}  // namespace parray

#include <doctest/doctest.h>

#include <algorithm>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/base/error.h"
#include "coordinator/http/budget.h"
#include "coordinator/http/connection.h"
#include "coordinator/http/exchange.h"
#include "coordinator/http/framing.h"
#include "coordinator/http/places.h"
#include "coordinator/http/seats.h"
#include "coordinator/http/turns.h"
#include "coordinator/jobs/job_index.h"
#include "tests/support/rooms.h"

namespace parray::http {
namespace {

int status_of_head(const std::string& text) {
  try {
    parse_head(text);
  } catch (const Problem& problem) {
    return problem.status();
  }
  return 200;
}

TEST_CASE("end_of_head finds the empty line, however the bytes are split") {
  const std::string text = "GET / HTTP/1.1\r\nHost: a\r\n\r\nGET";
  const std::size_t end = text.size() - 3;
  CHECK(end_of_head(text, 0) == end);
  for (std::size_t there = 1; there <= end; ++there) {
    CHECK(end_of_head(text.substr(0, there), there - 1).has_value() == (there == end));
  }
  CHECK_FALSE(end_of_head("GET / HTTP/1.1\n\n", 0));
}

TEST_CASE("parse_head reads method, target, fields and the length of the body") {
  const RequestHead get = parse_head("GET /a?b=c HTTP/1.1\r\nHOST:  x:1 \r\nEmpty:\r\n\r\n");
  CHECK(get.method == "GET");
  CHECK(get.target == "/a?b=c");
  CHECK(get.path() == "/a");
  CHECK(get.field("host") == "x:1");
  CHECK(get.field("empty").empty());
  CHECK_FALSE(get.has_body());
  CHECK_FALSE(get.closes);
  const RequestHead post = parse_head("POST / HTTP/1.1\r\nContent-Length: 17\r\n\r\n");
  CHECK(post.length == 17);
  CHECK(post.has_body());
  CHECK(parse_head("POST / HTTP/1.1\r\nTransfer-Encoding: Chunked\r\n\r\n").chunked);
  CHECK(parse_head("GET / HTTP/1.1\r\nConnection: Close\r\n\r\n").closes);
  CHECK(parse_head("GET / HTTP/1.0\r\n\r\n").closes);
}

TEST_CASE("parse_head finds the option close in every field Connection") {
  const auto closes = [](const std::string& fields) {
    return parse_head("GET / HTTP/1.1\r\n" + fields + "\r\n\r\n").closes;
  };
  CHECK(closes("Connection: close, TE"));
  CHECK(closes("Connection: TE ,\tClose"));
  CHECK(closes("Connection: keep-alive\r\nConnection: close"));
  CHECK_FALSE(closes("Connection: closed, not-close"));
  CHECK_FALSE(closes("Close: close"));
}

TEST_CASE("parse_head refuses ambiguous heads") {
  const std::string post = "POST / HTTP/1.1\r\n";
  for (const char* field :
       {"Content-Length: 2\r\nContent-Length: 2", "Content-Length: -1", "Content-Length: +1",
        "Content-Length: 1, 1", "Content-Length:", "Content-Length: 99999999999999999999",
        "Content-Length: 0x1", "Content-Length : 1", " Content-Length: 1", "no colon", ": a",
        "a: b\nc: d", "a: b\rc: d", "Content-Length: 1\r\nTransfer-Encoding: chunked",
        "Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked", "Host: a\r\nHost: a",
        "Host: a\r\nHost: b"}) {
    CHECK_MESSAGE(status_of_head(post + field + "\r\n\r\n") == 400, field);
  }
  CHECK(status_of_head(post + "Transfer-Encoding: gzip\r\n\r\n") == 501);
  for (const char* line : {"GET", "GET /", "GET  / HTTP/1.1", "GET / / HTTP/1.1", "G(T / HTTP/1.1",
                           " GET / HTTP/1.1", "", "GET /\x01 HTTP/1.1"}) {
    CHECK_MESSAGE(status_of_head(std::string(line) + "\r\n\r\n") == 400, line);
  }
  CHECK(status_of_head(std::string("GET /\0 HTTP/1.1\r\n\r\n", 19)) == 400);
  CHECK(status_of_head("GET / HTTP/2.0\r\n\r\n") == 505);
}

TEST_CASE("a target in absolute form becomes a path, and its host replaces the field Host") {
  const auto read = [](const std::string& target) {
    return parse_head("GET " + target + " HTTP/1.1\r\nHost: field\r\n\r\n");
  };
  CHECK(read("http://a:1/b?c=http://d").target == "/b?c=http://d");
  CHECK(read("http://a:1/b").field("host") == "a:1");
  CHECK(read("HTTPS://a?b").target == "/?b");
  CHECK(read("http://a").target == "/");
  CHECK(read("/b").field("host") == "field");
  CHECK(read("ftp://a/b").target == "ftp://a/b");
  CHECK(read("http").target == "http");  // not a path: the caller refuses it
  CHECK(read("https:").target == "https:");
  CHECK(status_of_head("GET http:///b HTTP/1.1\r\n\r\n") == 400);
  CHECK(status_of_head("GET http://user@a/b HTTP/1.1\r\n\r\n") == 400);
}

TEST_CASE("text_of returns the same head without Expect") {
  const std::string text = "PUT /a HTTP/1.1\r\nhost: b\r\ncontent-length: 3\r\n";
  const RequestHead head = parse_head(text + "Expect: 100-Continue\r\n\r\n");
  CHECK(head.expects);
  CHECK(text_of(head) == text + "\r\n");
  const RequestHead old = parse_head("GET / HTTP/1.0\r\nConnection: keep-alive\r\n\r\n");
  CHECK(old.old);
  CHECK(text_of(old) == "GET / HTTP/1.0\r\nconnection: close\r\n\r\n");
  CHECK(status_of_head("PUT / HTTP/1.0\r\nTransfer-Encoding: chunked\r\n\r\n") == 400);
  CHECK_FALSE(parse_head("PUT / HTTP/1.0\r\nExpect: 100-continue\r\n\r\n").expects);
}

struct Decoded {
  std::string data;
  std::size_t used = 0;
  bool done = false;
  int status = 200;
};

/// Decodes `text` in pieces of `piece` bytes.
Decoded decode_chunks(const std::string& text, std::size_t piece) {
  Decoded decoded;
  ChunkDecoder decoder;
  try {
    for (std::size_t there = 0; there < text.size() && !decoder.done();) {
      there = std::min(there + piece, text.size());
      const std::string_view input = std::string_view(text).substr(0, there);
      for (std::size_t used = 1; used > 0;) {
        const ChunkDecoder::Step step = decoder.step(input.substr(decoded.used));
        used = step.used;
        decoded.used += used;
        decoded.data += step.data;
      }
    }
  } catch (const Problem& problem) {
    decoded.status = problem.status();
  }
  decoded.done = decoder.done();
  return decoded;
}

TEST_CASE("a chunked body is decoded to its end, however the bytes are split") {
  const std::string body =
      "5\r\nhello\r\n00A;x=\"y\"\r\n, 0\r\nworld\r\n000\r\nX: 1\r\nHost: a\r\n\r\n";
  for (std::size_t piece = 1; piece <= body.size() + 9; ++piece) {
    const Decoded decoded = decode_chunks(body + "GET / HTT", piece);
    CHECK(decoded.data == "hello, 0\r\nworld");
    CHECK(decoded.done);
    CHECK(decoded.used == body.size());
  }
  const Decoded unfinished = decode_chunks(body.substr(0, body.size() - 1), 100);
  CHECK(unfinished.status == 200);
  CHECK_FALSE(unfinished.done);
  CHECK(decode_chunks("ffffffffffffffff\r\nabc", 100).data == "abc");
}

TEST_CASE("the longest permitted line of a chunked body is accepted, however the bytes are split") {
  const std::string longest = "0;" + std::string(1022, 'e') + "\r\n\r\n";
  const std::string longer = "0;" + std::string(1023, 'e') + "\r\n\r\n";
  for (const std::size_t piece : {1U, 2U, 5U, 1025U, 2000U}) {
    CHECK_MESSAGE(decode_chunks(longest, piece).done, piece);
    CHECK_MESSAGE(decode_chunks(longer, piece).status == 400, piece);
  }
}

TEST_CASE("a chunked body with wrong framing is refused") {
  const std::string end = "\r\n0\r\n\r\n";
  for (const char* size : {"+1", "-1", " 1", "1 ", "\t1", "0x1", "1 ;a", "", ";a", "g", "1g",
                           "00000000000000001", "10000000000000000", "1\n", "1;\x01", "1\r"}) {
    CHECK_MESSAGE(decode_chunks(size + ("\r\na" + end), 1).status == 400, size);
  }
  CHECK(decode_chunks("1\r\nab" + end, 1).status == 400);
  CHECK(decode_chunks("2\r\na\r\n\r\n", 1).status == 400);
  CHECK(decode_chunks("0\r\nno field\r\n\r\n", 1).status == 400);
  CHECK(decode_chunks("0\r\nGET / HTTP/1.1\r\nHost: a\r\n\r\n", 1).status == 400);
  CHECK(decode_chunks("1;" + std::string(2000, 'a'), 100).status == 400);
  std::string trailer = "0\r\n";
  for (int i = 0; i < 1000; ++i) trailer += "field: x\r\n";
  CHECK(decode_chunks(trailer, 100).status == 400);
}

TEST_CASE("a pace expires for a side that is slower than the rate, however evenly bytes arrive") {
  const auto seconds_until_over = [](std::size_t bytes_a_second) {
    Pace pace(seconds(10), 1000);
    int waited = 0;
    while (!pace.over() && waited < 1000) {
      pace.waited(seconds(1));
      pace.moved(bytes_a_second);
      ++waited;
    }
    return waited;
  };
  CHECK(seconds_until_over(0) == 10);
  CHECK(seconds_until_over(1) <= 11);
  CHECK(seconds_until_over(500) <= 20);
  CHECK(seconds_until_over(1000) == 1000);
  CHECK(seconds_until_over(5000) == 1000);
}

TEST_CASE("transferred bytes restore at most the full patience") {
  Pace pace(seconds(10), 1000);
  pace.moved(1'000'000);
  CHECK(pace.left() == seconds(10));
  pace.waited(seconds(4));
  pace.moved(1000);
  CHECK(pace.left() == seconds(7));
}

constexpr SeatLimits few{.connections = 4, .of_address = 3, .reserve = 2};

TEST_CASE("a connection has one deadline for the whole head and one for idle time") {
  Seats seats{few};
  seats.enter(seconds(0), 1, "a");
  seats.enter(seconds(0), 2, "a");
  seats.begins_head(seconds(1), 1);
  seats.begins_head(seconds(9), 1);  // the same head continues
  CHECK(seats.late(seconds(10)).empty());
  CHECK(seats.late(seconds(11)) == std::vector<ConnectionId>{1});
  seats.has_asked(1);
  CHECK(seats.late(seconds(15)) == std::vector<ConnectionId>{2});
  seats.leave(2);
  CHECK(seats.late(seconds(1000)).empty());
  seats.awaits_head(seconds(1000), 1);
  CHECK(seats.late(seconds(1014)).empty());
  CHECK(seats.late(seconds(1015)) == std::vector<ConnectionId>{1});
}

TEST_CASE("the longest idle connection of an address makes room for its next connection") {
  Seats seats{few};
  for (ConnectionId id = 1; id <= 3; ++id) CHECK_FALSE(seats.enter(seconds(id), id, "a").displaced);
  seats.has_asked(1);
  const auto next = seats.enter(seconds(4), 4, "a");
  CHECK(next.displaced == 2);
  CHECK_FALSE(next.reserve);
  CHECK_FALSE(seats.enter(seconds(5), 5, "b").displaced);
  CHECK(seats.enter(seconds(6), 6, "c").displaced == 3);  // the limit of all is four
}

TEST_CASE("if all connections have sent requests, new ones get the reserve for a short time") {
  Seats seats{few};
  for (ConnectionId id = 1; id <= 3; ++id) {
    seats.enter(seconds(0), id, "a");
    seats.has_asked(id);
  }
  CHECK(seats.enter(seconds(1), 4, "a").reserve);
  CHECK_FALSE(seats.enter(seconds(1), 5, "b").reserve);
  CHECK(seats.enter(seconds(2), 6, "a").reserve);
  CHECK(seats.enter(seconds(2), 7, "a").displaced == 4);  // the reserve is full
  CHECK(seats.late(seconds(4)) == std::vector<ConnectionId>{6, 7});
  seats.has_asked(6);
  seats.has_asked(7);
  CHECK(seats.enter(seconds(3), 8, "a").displaced == 8);  // no seat is free
  seats.leave(1);
  CHECK_FALSE(seats.enter(seconds(4), 9, "a").reserve);
}

TEST_CASE("connections with their last answer make room before idle connections") {
  Seats seats{few};
  for (ConnectionId id = 1; id <= 3; ++id) {
    seats.enter(seconds(0), id, "a");
    seats.has_asked(id);
  }
  for (ConnectionId id = 4; id <= 5; ++id) {
    CHECK(seats.enter(seconds(1), id, "a").reserve);
    seats.has_asked(id);
    seats.has_ended(seconds(2), id);
  }
  CHECK(seats.late(seconds(100)).empty());
  CHECK(seats.enter(seconds(3), 6, "a").displaced == 4);
  CHECK(seats.enter(seconds(4), 7, "a").displaced == 5);  // not 6, which has not sent a request
  seats.has_ended(seconds(5), 2);
  const auto next = seats.enter(seconds(6), 8, "a");
  CHECK(next.displaced == 2);
  CHECK_FALSE(next.reserve);
}

TEST_CASE("an IPv6 address counts as its /64 network") {
  CHECK(owner_of_address("10.1.2.3") == "10.1.2.3");
  CHECK(owner_of_address("2001:db8:1:2:3:4:5:6") == owner_of_address("2001:db8:1:2::9"));
  CHECK(owner_of_address("2001:db8:1:2::9") != owner_of_address("2001:db8:1:3::9"));
  CHECK(owner_of_address("::ffff:10.1.2.3") != owner_of_address("::ffff:10.1.2.4"));
}

TEST_CASE("names take turns, independent of the number of their waiting items") {
  Turns<std::string> turns(2);
  for (const char* item : {"a1", "a2", "a3", "a4"}) turns.push("a", item);
  turns.push("b", "b1");
  turns.push("b", "b2");
  CHECK(turns.take() == "a1");
  CHECK(turns.take() == "b1");
  turns.push("c", "c1");
  CHECK(turns.take() == "c1");
  CHECK(turns.take() == "a2");
  CHECK(turns.take() == "b2");
  CHECK_FALSE(turns.take());  // a has reached its limit of items in progress
  CHECK(turns.waiting() == 2);
  turns.ended("a");
  CHECK(turns.take() == "a3");
  turns.ended("b");
  turns.ended("b");
  CHECK_FALSE(turns.take());
}

TEST_CASE("a submit token contains the name of the job and a digest of the content") {
  CHECK(name_in_token("http-a#12") == "http-a");
  CHECK(name_in_token("abc") == "abc");
  CHECK(may_be_same_content("a#1", "a#1"));
  CHECK_FALSE(may_be_same_content("a#1", "a#2"));
  CHECK(may_be_same_content("a", "a#2"));  // tokens without a digest match any content
}

TEST_CASE("a budget is exceeded only by a single large item") {
  Budget budget(100);
  {
    const auto most = budget.hold(60, Time(0), "one");
    CHECK_THROWS_AS(budget.hold(41, Time(0), "another"), Problem);
    CHECK_NOTHROW(budget.hold(40, Time(0), "another"));
  }
  const auto large = budget.hold(1000, Time(0), "a large one");
  CHECK_THROWS_AS(budget.hold(1, Time(0), "another"), Problem);
}

TEST_CASE("hold() waits until memory is released") {
  Budget budget(100);
  std::optional<Budget::Hold> first(budget.hold(100, Time(0), "one"));
  std::thread waiting([&] { CHECK_NOTHROW(budget.hold(50, seconds(60), "another")); });
  first.reset();
  waiting.join();
}

/// Records the order in which owners get the only place.
class Queue {
 public:
  explicit Queue(Places& places) : places_(places) {}
  ~Queue() { wait(); }
  Queue& operator=(Queue&&) = delete;

  /// Returns when the owner waits for a place.
  void add(const std::string& owner) {
    const std::size_t before = places_.waiting();
    threads_.emplace_back([this, owner] {
      const Places::Entry entry(places_, owner);
      const Places::Place place(entry);
      order_.push_back(owner);  // guarded by the place
    });
    while (places_.waiting() == before) std::this_thread::yield();
  }
  void wait() {
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
  }
  [[nodiscard]] const std::vector<std::string>& order() const { return order_; }

 private:
  Places& places_;
  std::vector<std::string> order_;
  std::vector<std::thread> threads_;
};

TEST_CASE("owners get places by turns, and none after stop()") {
  Places places("things", {.places = 1, .of_one = 1, .inside = 4, .one_inside = 3});
  Queue queue(places);
  {
    const Places::Entry first(places, "a");
    const Places::Place held(first);
    queue.add("a");
    queue.add("a");
    CHECK_THROWS_AS(Places::Entry(places, "a"),
                    Problem);  // the limit of one owner is three entries
    queue.add("b");
    CHECK_THROWS_AS(Places::Entry(places, "c"), Problem);  // the limit of all is four entries
  }
  queue.wait();
  CHECK(queue.order() == std::vector<std::string>{"b", "a", "a"});
  const Places::Entry late(places, "c");
  places.stop();
  CHECK_THROWS_AS(Places::Place{late}, RunError);
}

}  // namespace
}  // namespace parray::http

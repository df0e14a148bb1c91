#include "worker/message_source.h"

#include <doctest/doctest.h>

#include <optional>

#include "tests/support/rooms.h"

namespace parray {
namespace {

/// Returns the last message of type M that the worker sends.
template <typename M>
std::optional<M> sent(MessageSource& source) {
  std::optional<M> found;
  for (Delivery& delivery : source.take_outbox()) {
    Message message = delivery.content.open();
    if (M* m = std::get_if<M>(&message)) found = *m;
  }
  return found;
}

WorkerOptions named() {
  WorkerOptions options;
  options.name = "one";
  options.instance = "1";
  return options;
}

TEST_CASE("a worker says what its machine is when it joins, and its load with each heartbeat") {
  WorkerOptions options = named();
  options.release = "9.9";
  options.processors = 64;
  options.memory_bytes = 1000;
  options.load = [] { return 2.5; };
  MessageSource source(options);
  source.tick(Time(0), {});
  const auto hello = sent<msg::Hello>(source);
  REQUIRE(hello);
  CHECK(hello->release == "9.9");
  CHECK(hello->processors == 64);
  CHECK(hello->memory_bytes == 1000);
  source.receive(Time(0), {}, encode(msg::Welcome{}));
  source.tick(Time(0), {});
  CHECK(sent<msg::Heartbeat>(source)->load == 2.5);
}

TEST_CASE("a worker sends the last lines of its log to its coordinator only") {
  WorkerOptions options = named();
  options.recent_log = [] {
    return std::vector<std::string>{"serving", "\x1b[2J" + std::string(900, 'x')};
  };
  MessageSource source(options);
  source.receive(Time(0), {}, encode(msg::ShowLog{8, "one"}));
  Delivery answer = source.take_outbox().at(0);
  const auto log = std::get<msg::Log>(decode(answer.content.frames()));
  CHECK(log.request == 8);
  REQUIRE(log.lines.size() == 2);
  CHECK(log.lines[0] == "serving");
  CHECK(log.lines[1].size() <= 500);
  CHECK(log.lines[1].find('\x1b') == std::string::npos);

  source.receive(Time(0), "another worker", encode(msg::ShowLog{9, "one"}));
  CHECK_FALSE(sent<msg::Log>(source));
}

TEST_CASE("a worker without a log answers with no lines") {
  MessageSource source(named());
  source.receive(Time(0), {}, encode(msg::ShowLog{8, "one"}));
  CHECK(sent<msg::Log>(source)->lines.empty());
}

}  // namespace
}  // namespace parray

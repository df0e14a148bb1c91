// A worker that answers the request for its log with anything but a log harms nobody.
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "tests/support/rooms.h"
#include "tests/support/served.h"
#include "tests/support/service.h"

namespace parray::test {
namespace {

CoordinatorOptions patient() {
  CoordinatorOptions options;
  options.silence = seconds(20);
  options.fingerprint = "same";
  return options;
}

Frames log_with(std::uint64_t request, const nlohmann::json& lines) {
  const nlohmann::json map = {
      {"v", protocol_version}, {"type", "log"}, {"request", request}, {"lines", lines}};
  std::string bytes;
  nlohmann::json::to_msgpack(map, bytes);
  return {Frame(std::move(bytes))};
}

}  // namespace

TEST_CASE("huge, malformed and foreign logs are dropped, and the client gets an error") {
  const Server server(patient());
  Speaker worker(server);
  worker.say(msg::Hello{protocol_version, "w", "w", 1, 1, trace_version, "same"});
  worker.hear<msg::Welcome>();
  Speaker client(server);
  client.say(msg::ShowLog{7, "w"});
  const std::uint64_t number = worker.hear<msg::ShowLog>().request;

  worker.say_raw(log_with(number, std::vector<std::string>(1000, std::string(1000, 'x'))));
  worker.say_raw(log_with(number, std::vector<std::string>(101, "x")));
  worker.say_raw(log_with(number, std::vector<std::string>{std::string(501, 'x')}));
  worker.say_raw(log_with(number, std::vector<std::string>{"\x1b[2J"}));
  worker.say_raw(log_with(number, std::vector<std::string>{"\xff"}));
  worker.say_raw(log_with(number, "text"));
  worker.say_raw(log_with(number, nlohmann::json::array({nlohmann::json::array({1, 2})})));
  worker.say_raw({Frame(std::string(std::size_t{64} << 20, 'x'))});
  Frames bulk = log_with(number, std::vector<std::string>{"x"});
  bulk.emplace_back(std::string(1000, 'x'));
  worker.say_raw(bulk);
  worker.say(msg::Log{number + 1, {"nobody asked for this"}});
  client.say(msg::Log{number, {"the client itself"}});

  client.say(msg::ListWorkers{8});  // requests of others are answered meanwhile
  CHECK(client.hear<msg::Workers>().total == 1);
  const auto error = client.hear<msg::Error>();
  CHECK(error.request == 7);
  CHECK(error.message.find("'w' did not send its log") != std::string::npos);

  client.say(msg::ShowLog{9, "w"});  // the worker may still answer properly
  worker.say(msg::Log{worker.hear<msg::ShowLog>().request, {"serving"}});
  CHECK(client.hear<msg::Log>().lines == std::vector<std::string>{"serving"});
}

}  // namespace parray::test

#include "cli/check/doctor/messages.h"

#include <zmq.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "cli/output/text.h"
#include "common/process/stop_signal.h"
#include "proto/keys.h"
#include "proto/zmq_link.h"

namespace parray::doctor {
namespace {

constexpr const char* loopback = "tcp://127.0.0.1:*";
constexpr const char* loopback_remedy = "check whether a firewall or a sandbox blocks 127.0.0.1";
constexpr std::size_t most_bytes = 1 << 20;

/// Waits for a message of `link`, and returns it. Returns nothing if none comes before `end`.
std::optional<Delivery> next_message(Link& link, const Clock& clock, Time end) {
  for (;;) {
    if (auto delivery = link.receive()) return delivery;
    const Time left = end - clock.now();
    if (left <= Time(0)) return {};
    check_interrupted();
    link.wait(std::min(left, Time(milliseconds(50))));
  }
}

}  // namespace

CheckResult check_messages(Time patience) {
  const SteadyClock clock;
  const Time begin = clock.now();
  const Time end = begin + patience;
  ZmqServer server(loopback, most_bytes);
  const auto worker = zmq_connect(server.endpoint(), most_bytes, Time(0));
  const Frames question{std::string("a control frame"), std::string(100'000, 'b')};
  worker->send({}, question);
  const auto arrived = next_message(server.link(), clock, end);
  if (!arrived || arrived->content.frames() != question) {
    return failed("no message arrived over " + server.endpoint(), loopback_remedy);
  }
  const Frames reply{std::string("an answer")};
  server.link().send(arrived->peer, reply);
  const auto answer = next_message(*worker, clock, end);
  if (!answer || answer->content.frames() != reply) {
    return failed("no answer arrived over " + server.endpoint(), loopback_remedy);
  }
  return passed("a message and its answer over " + server.endpoint() + " took " +
                duration_text(to_seconds(clock.now() - begin)));
}

CheckResult check_keys(Time patience, const std::filesystem::path& directory, KeyTrial trial) {
  if (zmq_has("curve") == 0) {
    return failed("this ZeroMQ was built without CURVE, so it cannot encrypt",
                  "install a libzmq with libsodium (Debian: libzmq5)");
  }
  const std::filesystem::path keys = directory / "keys";
  make_farm_keys(keys);
  const MemberKey known = read_member_key(keys, "admin");
  MemberKey unknown{known.coordinator, make_key_pair()};
  if (trial == KeyTrial::accepts_anybody) {
    add_member_key(keys, Role::client, "stranger");
    unknown = read_member_key(keys, "stranger");
  } else if (trial == KeyTrial::refuses_everybody) {
    remove_member_key(keys, "admin");
  }
  ZmqServer server(loopback, most_bytes, keys);
  const auto guest = zmq_connect(server.endpoint(), most_bytes, Time(0), known);
  const auto stranger = zmq_connect(server.endpoint(), most_bytes, Time(0), unknown);
  const Frames greeting{std::string("from the guest")};
  guest->send({}, greeting);
  stranger->send({}, Frames{std::string("from the stranger")});

  const SteadyClock clock;
  bool heard = false;
  bool invaded = false;
  Time end = clock.now() + patience;
  while (const auto message = next_message(server.link(), clock, end)) {
    const bool own = message->content.frames() == greeting;
    if (own && !heard) {
      // No other message may come in this time.
      end = std::min(end, clock.now() + milliseconds(300));
    }
    heard = heard || own;
    invaded = invaded || !own;
  }
  const char* const remedy = "reinstall libzmq (Debian: libzmq5) and libsodium";
  if (invaded) return failed("the server accepts a client with an unknown key", remedy);
  if (!heard) return failed("the server refuses a client with a known key", remedy);
  return passed("CURVE: the server accepts a known key, encrypted, and refuses an unknown one");
}

}  // namespace parray::doctor

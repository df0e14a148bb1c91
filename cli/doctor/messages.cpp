#include "cli/doctor/messages.h"

#include <array>
#include <string>
#include <utility>
#include <vector>
#include <zmq.hpp>
#include <zmq_addon.hpp>

#include "cli/output/text.h"
#include "common/process/stop_signal.h"
#include "proto/zmq_link.h"

namespace parray {
namespace {

constexpr const char* loopback = "tcp://127.0.0.1:*";
constexpr const char* loopback_remedy =
    "see whether a firewall or a sandbox keeps programs from 127.0.0.1";
constexpr std::size_t most_bytes = 1 << 20;

/// Waits until `link` has a message; nothing if none comes before `end`.
std::optional<Delivery> next_message(Link& link, const Clock& clock, Time end) {
  for (;;) {
    if (auto delivery = link.receive()) return delivery;
    const Time left = end - clock.now();
    if (left <= Time(0)) return {};
    check_interrupted();
    link.wait(std::min(left, Time(milliseconds(50))));
  }
}

/// Fresh; as 40 characters each (Z85).
struct KeyPair {
  KeyPair() {
    std::array<char, 41> open_text{};
    std::array<char, 41> secret_text{};
    if (zmq_curve_keypair(open_text.data(), secret_text.data()) != 0) throw zmq::error_t();
    open = open_text.data();
    secret = secret_text.data();
  }
  std::string open;
  std::string secret;
};

/// A server with keys, its authenticator (ZAP, https://rfc.zeromq.org/spec/27) and two clients, of
/// which it knows one; driven by one thread.
class CurveTrial {
 public:
  explicit CurveTrial(KeyTrial trial) : trial_(trial) {
    authenticator_.bind("inproc://zeromq.zap.01");
    server_.set(zmq::sockopt::curve_server, true);
    server_.set(zmq::sockopt::curve_secretkey, server_keys_.secret);
    server_.set(zmq::sockopt::zap_domain, "parray");
    for (zmq::socket_t* socket : {&authenticator_, &server_, &friend_, &stranger_}) {
      socket->set(zmq::sockopt::linger, 0);
    }
    server_.bind(loopback);
    join(friend_, friend_keys_, "from the friend");
    join(stranger_, stranger_keys_, "from the stranger");
  }

  /// Until both clients have been judged and the friend's message is there and back, or `patience`
  /// is over; then a moment more, in which the stranger's must not arrive.
  void run(Time patience) {
    const SteadyClock clock;
    const Time end = clock.now() + patience;
    while (clock.now() < end && !(refused_ > 0 && answered_)) {
      step();
    }
    const Time later = clock.now() + milliseconds(100);
    while (clock.now() < later) {
      step();
    }
  }

  [[nodiscard]] bool friend_was_heard() const { return answered_; }
  [[nodiscard]] bool stranger_was_heard() const { return stranger_heard_; }
  [[nodiscard]] bool stranger_was_refused() const { return refused_ > 0; }

 private:
  void join(zmq::socket_t& client, const KeyPair& keys, const char* text) {
    client.set(zmq::sockopt::curve_serverkey, server_keys_.open);
    client.set(zmq::sockopt::curve_publickey, keys.open);
    client.set(zmq::sockopt::curve_secretkey, keys.secret);
    client.connect(server_.get(zmq::sockopt::last_endpoint));
    client.send(zmq::buffer(std::string(text)), zmq::send_flags::dontwait);
  }

  void step() {
    check_interrupted();
    std::array<zmq::pollitem_t, 3> items{{{authenticator_.handle(), 0, ZMQ_POLLIN, 0},
                                          {server_.handle(), 0, ZMQ_POLLIN, 0},
                                          {friend_.handle(), 0, ZMQ_POLLIN, 0}}};
    zmq::poll(items, milliseconds(20));
    if ((items[0].revents & ZMQ_POLLIN) != 0) judge();
    if ((items[1].revents & ZMQ_POLLIN) != 0) answer();
    if ((items[2].revents & ZMQ_POLLIN) != 0) {
      zmq::message_t echo;
      answered_ = friend_.recv(echo, zmq::recv_flags::dontwait).has_value() &&
                  echo.to_string_view() == "from the friend";
    }
  }

  /// Version, request, domain, address, identity, mechanism, the client's public key.
  void judge() {
    std::vector<zmq::message_t> request;
    if (!zmq::recv_multipart(authenticator_, std::back_inserter(request))) return;
    bool known = false;
    if (request.size() == 7 && request[5].to_string_view() == "CURVE" && request[6].size() == 32) {
      std::array<char, 41> text{};
      zmq_z85_encode(text.data(), request[6].data<std::uint8_t>(), request[6].size());
      known = text.data() == friend_keys_.open;
    }
    known = (known || trial_ == KeyTrial::accepts_anybody) && trial_ != KeyTrial::refuses_everybody;
    refused_ += known ? 0 : 1;
    const std::string serial = request.size() > 1 ? request[1].to_string() : "";
    const std::array<std::string, 6> reply{
        "1.0", serial, known ? "200" : "400", known ? "OK" : "unknown key", "", ""};
    zmq::send_multipart(authenticator_, std::array{zmq::buffer(reply[0]), zmq::buffer(reply[1]),
                                                   zmq::buffer(reply[2]), zmq::buffer(reply[3]),
                                                   zmq::buffer(reply[4]), zmq::buffer(reply[5])});
  }

  /// Sends back what has come.
  void answer() {
    std::vector<zmq::message_t> message;
    if (!zmq::recv_multipart(server_, std::back_inserter(message)) || message.size() != 2) return;
    stranger_heard_ = stranger_heard_ || message[1].to_string_view() == "from the stranger";
    zmq::send_multipart(server_, message, zmq::send_flags::dontwait);
  }

  KeyTrial trial_;
  KeyPair server_keys_;
  KeyPair friend_keys_;
  KeyPair stranger_keys_;
  zmq::context_t context_{1};
  zmq::socket_t authenticator_{context_, zmq::socket_type::rep};
  zmq::socket_t server_{context_, zmq::socket_type::router};
  zmq::socket_t friend_{context_, zmq::socket_type::dealer};
  zmq::socket_t stranger_{context_, zmq::socket_type::dealer};
  int refused_ = 0;
  bool answered_ = false;
  bool stranger_heard_ = false;
};

}  // namespace

Finding check_messages(Time patience) {
  const SteadyClock clock;
  const Time begin = clock.now();
  const Time end = begin + patience;
  ZmqServer server(loopback, most_bytes);
  const auto worker = zmq_connect(server.endpoint(), most_bytes, Time(0));
  const Frames question{std::string("a control frame"), std::string(100'000, 'b')};
  worker->send({}, question);
  const auto arrived = next_message(server.link(), clock, end);
  if (!arrived || arrived->content.frames() != question) {
    return failed("no message came through " + server.endpoint(), loopback_remedy);
  }
  const Frames reply{std::string("an answer")};
  server.link().send(arrived->peer, reply);
  const auto answer = next_message(*worker, clock, end);
  if (!answer || answer->content.frames() != reply) {
    return failed("no answer came back through " + server.endpoint(), loopback_remedy);
  }
  return passed("there and back over " + server.endpoint() + " in " +
                duration_text(to_seconds(clock.now() - begin)));
}

Finding check_keys(Time patience, KeyTrial trial) {
  if (zmq_has("curve") == 0) {
    return failed("this ZeroMQ was built without CURVE: nothing can be encrypted",
                  "install a libzmq with libsodium (Debian: libzmq5)");
  }
  CurveTrial curve(trial);
  curve.run(patience);
  const char* const remedy = "reinstall libzmq (Debian: libzmq5) and libsodium";
  if (curve.stranger_was_heard()) {
    return failed("a client whose key is not known was let in", remedy);
  }
  if (!curve.friend_was_heard()) {
    return failed("a client whose key is known was not let in", remedy);
  }
  if (!curve.stranger_was_refused()) {
    return failed("the authenticator was not asked about a client whose key is not known", remedy);
  }
  return passed("CURVE: a known key is let in, encrypted; an unknown one is refused");
}

}  // namespace parray

#include "proto/zmq_link.h"

#include <algorithm>
#include <array>
#include <functional>
#include <utility>
#include <vector>
#include <zmq_addon.hpp>

#include "common/base/error.h"
#include "common/scene/scene_chunks.h"
#include "proto/zmq_socket.h"

namespace parray::proto {
namespace {

/// Decides which peers are admitted when libzmq asks (ZAP, https://rfc.zeromq.org/spec/27), and
/// identifies the admitted ones.
class Authenticator {
 public:
  /// Returns the owner of a key; nothing if the key is unknown.
  using Known = std::function<std::optional<Sender>(const std::string& key)>;

  Authenticator(zmq::context_t& context, Known known)
      : known_(std::move(known)), socket_(context, zmq::socket_type::rep) {
    socket_.set(zmq::sockopt::linger, 0);
    socket_.bind("inproc://zeromq.zap.01");
  }

  void* handle() { return socket_.handle(); }

  /// Answers the pending requests.
  void serve() {
    // Version, serial, domain, address, identity, mechanism, the client's public key.
    std::vector<zmq::message_t> question;
    while (zmq::recv_multipart(socket_, std::back_inserter(question), zmq::recv_flags::dontwait)) {
      std::string key;
      if (question.size() == 7 && question[5].to_string_view() == "CURVE" &&
          question[6].size() == 32) {
        std::array<char, 41> text{};
        zmq_z85_encode(text.data(), question[6].data<std::uint8_t>(), question[6].size());
        key = text.data();
      }
      const bool known = known_(key).has_value();
      const std::array<std::string, 6> answer{"1.0",
                                              question.size() > 1 ? question[1].to_string() : "",
                                              known ? "200" : "400",
                                              known ? "OK" : "unknown key",
                                              key,
                                              ""};
      zmq::send_multipart(socket_, std::array{zmq::buffer(answer[0]), zmq::buffer(answer[1]),
                                              zmq::buffer(answer[2]), zmq::buffer(answer[3]),
                                              zmq::buffer(answer[4]), zmq::buffer(answer[5])});
      question.clear();
    }
  }

  /// Returns the sender of an admitted connection; the list may have changed since.
  Sender sender_of(const char* key) {
    const auto found = key == nullptr ? std::nullopt : known_(key);
    return found.value_or(Sender{Role::none, ""});
  }

 private:
  const Known known_;
  zmq::socket_t socket_;
};

/// Keeps requests from waiting for thousands of handshakes.
constexpr int threads_of_a_server = 4;

class ZmqLink final : public Link {
 public:
  ZmqLink(zmq::socket_type type, std::size_t max_message_bytes, Time linger)
      : context_(type == zmq::socket_type::router ? threads_of_a_server : 1),
        socket_(context_, type, max_message_bytes, linger) {}

  ZmqSocket& socket() { return socket_; }

  /// Call it before the socket is bound.
  void admit_only(const std::filesystem::path& keys, Admits admits) {
    const KeyPair own = read_coordinator_key(keys);
    Authenticator::Known known = [open = own.open](const std::string& key) {
      return key == open ? std::optional(Sender{}) : std::nullopt;
    };
    if (admits == Admits::members) {
      known = [list = std::make_shared<AllowList>(keys), clock = SteadyClock()](
                  const std::string& key) { return list->find(clock.now(), key); };
    }
    authenticator_.emplace(context_, std::move(known));
    socket_.serve_as(own);
    socket_.raw().set(zmq::sockopt::zap_domain, "parray");
    socket_.identify_by([this](const char* key) { return authenticator_->sender_of(key); });
  }

  bool send(const PeerId& to, Envelope content) override { return socket_.send(to, content); }

  std::optional<Delivery> receive() override {
    if (authenticator_) authenticator_->serve();
    return socket_.receive();
  }

  void wait(Time timeout) override {
    std::vector<zmq::pollitem_t> items{{socket_.raw().handle(), 0, ZMQ_POLLIN, 0}};
    if (authenticator_) items.push_back({authenticator_->handle(), 0, ZMQ_POLLIN, 0});
    wake_up_.poll(std::move(items), timeout);
  }

  void wake() noexcept override { wake_up_.raise(); }

 private:
  zmq::context_t context_;
  std::optional<Authenticator> authenticator_;
  ZmqSocket socket_;
  WakeUp wake_up_;
};

/// Limits for the requests and answers between workers.
constexpr std::size_t most_asked_bytes = 1U << 12;
constexpr std::size_t most_answered_bytes = most_chunk_bytes + most_asked_bytes;

/// First byte of the id of a worker that asked; no address begins with it.
constexpr char asker = '<';

class Mesh final : public Link {
 public:
  Mesh(const std::string& coordinator, const std::optional<MemberKey>& key, bool sharing)
      : coordinator_(context_, zmq::socket_type::dealer, default_max_message_bytes, seconds(1)) {
    if (key) coordinator_.speak_as(key->own, key->coordinator);
    AddressList addresses(coordinator);
    const bool here = std::ranges::all_of(addresses.all(), is_loopback);
    coordinator_.connect(std::move(addresses));
    if (sharing) share(here ? "tcp://127.0.0.1:*" : "tcp://*:*");
  }

  [[nodiscard]] std::uint32_t port() const { return port_; }
  [[nodiscard]] const std::string& key() const { return own_.open; }

  bool send(const PeerId& to, Envelope content) override {
    if (to.empty()) return coordinator_.send({}, content);
    if (to.front() == asker) return asked_ && asked_->send(to.substr(1), content);
    return connect(to) && source_->socket.send({}, content);
  }

  /// Receives from each socket in turns, so that none can block the others.
  std::optional<Delivery> receive() override {
    for (int i = 0; i < 3; ++i) {
      turn_ = (turn_ + 1) % 3;
      if (auto delivery = receive_from(turn_)) return delivery;
    }
    return {};
  }

  void wait(Time timeout) override {
    std::vector<zmq::pollitem_t> items{{coordinator_.raw().handle(), 0, ZMQ_POLLIN, 0}};
    if (asked_) items.push_back({asked_->raw().handle(), 0, ZMQ_POLLIN, 0});
    if (source_) items.push_back({source_->socket.raw().handle(), 0, ZMQ_POLLIN, 0});
    wake_up_.poll(std::move(items), timeout);
  }

  void wake() noexcept override { wake_up_.raise(); }

 private:
  struct Source {
    PeerId id;
    ZmqSocket socket;
  };

  void share(const std::string& endpoint) {
    own_ = make_key_pair();
    asked_.emplace(context_, zmq::socket_type::router, most_asked_bytes, Time(0));
    asked_->serve_as(own_);
    try {
      asked_->raw().bind(endpoint);
    } catch (const zmq::error_t& error) {
      throw RunError("opening a port to share scenes with other workers (" + endpoint +
                     ") failed: " + error.what() + ": use --sharing off");
    }
    const std::string bound = asked_->raw().get(zmq::sockopt::last_endpoint);
    port_ = static_cast<std::uint32_t>(std::stoul(bound.substr(bound.rfind(':') + 1)));
  }

  /// Connects to `to`; see peer_at(). Returns false if `to` is not such an id.
  bool connect(const PeerId& to) {
    if (source_ && source_->id == to) return true;
    source_.reset();
    const std::size_t space = to.find(' ');
    if (space == std::string::npos || own_.open.empty()) return false;
    ZmqSocket socket(context_, zmq::socket_type::dealer, most_answered_bytes, Time(0));
    try {
      socket.speak_as(own_, to.substr(space + 1));
      socket.raw().connect(to.substr(0, space));
    } catch (const zmq::error_t&) {
      return false;
    }
    source_.emplace(Source{to, std::move(socket)});
    return true;
  }

  std::optional<Delivery> receive_from(int which) {
    if (which == 0) return coordinator_.receive();
    auto delivery = which == 1 ? (asked_ ? asked_->receive() : std::nullopt)
                               : (source_ ? source_->socket.receive() : std::nullopt);
    if (delivery) delivery->peer = which == 1 ? asker + delivery->peer : source_->id;
    return delivery;
  }

  zmq::context_t context_{1};
  ZmqSocket coordinator_;
  KeyPair own_;                     ///< key made for this process; empty: no sharing
  std::optional<ZmqSocket> asked_;  ///< socket for requests of other workers
  std::uint32_t port_ = 0;
  std::optional<Source> source_;  ///< the worker that this one asks
  WakeUp wake_up_;
  int turn_ = 0;
};

}  // namespace

bool is_loopback(const std::string& endpoint) {
  constexpr std::array<std::string_view, 3> prefixes = {
      "tcp://[::1]:", "tcp://localhost:", "ipc://"};
  for (const std::string_view prefix : prefixes) {
    if (endpoint.starts_with(prefix)) return true;
  }
  constexpr std::string_view net = "tcp://127.";
  const std::size_t colon = endpoint.rfind(':');  // the host must be digits: 127.example is a name
  return endpoint.starts_with(net) && colon >= net.size() &&
         endpoint.find_first_not_of("0123456789.", net.size()) == colon;
}

ZmqServer::ZmqServer(const std::string& endpoint, std::size_t max_message_bytes,
                     const std::filesystem::path& keys, Admits admits) {
  auto link = std::make_unique<ZmqLink>(zmq::socket_type::router, max_message_bytes, seconds(1));
  if (!keys.empty()) link->admit_only(keys, admits);
  try {
    link->socket().raw().bind(endpoint);
  } catch (const zmq::error_t& error) {
    throw RunError("binding " + endpoint + " failed: " + error.what() +
                   ": use another address or port");
  }
  endpoint_ = link->socket().raw().get(zmq::sockopt::last_endpoint);
  link_ = std::move(link);
}

std::unique_ptr<Link> zmq_connect(const std::string& addresses, std::size_t max_message_bytes,
                                  Time linger, const std::optional<MemberKey>& key) {
  auto link = std::make_unique<ZmqLink>(zmq::socket_type::dealer, max_message_bytes, linger);
  if (key) link->socket().speak_as(key->own, key->coordinator);
  link->socket().connect(AddressList(addresses));
  return link;
}

ZmqMesh open_mesh(const std::string& coordinator, const std::optional<MemberKey>& key,
                  bool sharing) {
  auto mesh = std::make_unique<Mesh>(coordinator, key, sharing);
  const std::uint32_t port = mesh->port();
  std::string open = mesh->key();
  return {std::move(mesh), port, std::move(open)};
}

}  // namespace parray::proto

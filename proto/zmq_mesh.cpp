#include <algorithm>
#include <utility>
#include <vector>

#include "common/base/error.h"
#include "common/scene/scene_chunks.h"
#include "proto/zmq_link.h"
#include "proto/zmq_socket.h"

namespace parray::proto {
namespace {

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

ZmqMesh open_mesh(const std::string& coordinator, const std::optional<MemberKey>& key,
                  bool sharing) {
  auto mesh = std::make_unique<Mesh>(coordinator, key, sharing);
  const std::uint32_t port = mesh->port();
  std::string open = mesh->key();
  return {std::move(mesh), port, std::move(open)};
}

}  // namespace parray::proto

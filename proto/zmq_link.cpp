#include "proto/zmq_link.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <random>
#include <utility>
#include <zmq.hpp>
#include <zmq_addon.hpp>

#include "common/base/error.h"

namespace parray {
namespace {

/// A file descriptor that another thread can make readable, to end a poll.
class WakeUp {
 public:
  WakeUp() : fd_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
    if (fd_ < 0) {
      throw RunError("creating an eventfd failed: out of file descriptors?");
    }
  }
  ~WakeUp() { close(fd_); }
  WakeUp(const WakeUp&) = delete;
  WakeUp& operator=(const WakeUp&) = delete;

  [[nodiscard]] int fd() const { return fd_; }
  void raise() const noexcept {
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = write(fd_, &one, sizeof one);  // full means: raised
  }
  void clear() const {
    std::uint64_t count = 0;
    [[maybe_unused]] const auto got = read(fd_, &count, sizeof count);
  }

 private:
  int fd_;
};

/// Decides who is let in, as libzmq asks (ZAP, https://rfc.zeromq.org/spec/27), and who whoever has
/// been let in is.
class Authenticator {
 public:
  Authenticator(zmq::context_t& context, const std::filesystem::path& keys)
      : list_(keys), socket_(context, zmq::socket_type::rep) {
    socket_.set(zmq::sockopt::linger, 0);
    socket_.bind("inproc://zeromq.zap.01");
  }

  void* handle() { return socket_.handle(); }

  /// Answers what has been asked.
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
      const bool known = list_.find(clock_.now(), key).has_value();
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

  /// Of a message that has come through a connection that was let in; the list may have changed.
  Sender sender_of(zmq::message_t& part) {
    const char* const key = zmq_msg_gets(part.handle(), "User-Id");
    const auto found = key == nullptr ? std::nullopt : list_.find(clock_.now(), key);
    return found.value_or(Sender{Role::none, ""});
  }

 private:
  const SteadyClock clock_;
  AllowList list_;
  zmq::socket_t socket_;
};

class ZmqLink final : public Link {
 public:
  ZmqLink(zmq::socket_type type, std::size_t max_message_bytes, Time linger)
      : socket_(context_, type), router_(type == zmq::socket_type::router) {
    const auto linger_ms = std::chrono::duration_cast<milliseconds>(linger).count();
    socket_.set(zmq::sockopt::linger, static_cast<int>(linger_ms));
    socket_.set(zmq::sockopt::maxmsgsize, static_cast<std::int64_t>(max_message_bytes));
    socket_.set(zmq::sockopt::sndhwm, most_waiting);
    socket_.set(zmq::sockopt::rcvhwm, most_waiting);
    // A machine that is gone without a word holds no file descriptor for ever.
    socket_.set(zmq::sockopt::tcp_keepalive, 1);
    socket_.set(zmq::sockopt::tcp_keepalive_idle, 20);
    socket_.set(zmq::sockopt::tcp_keepalive_intvl, 5);
    socket_.set(zmq::sockopt::tcp_keepalive_cnt, 4);
    // Nor is one whose answers are lost on the way waited for, ever longer, as TCP would: a fresh connection finds
    // a way that is open again at once.
    socket_.set(zmq::sockopt::tcp_maxrt, 10000);
    socket_.set(zmq::sockopt::connect_timeout, 3000);
    if (router_) {
      // Without it, messages for a peer that is gone or slow vanish in silence.
      socket_.set(zmq::sockopt::router_mandatory, true);
      // A peer that comes back under its old name takes its place over.
      socket_.set(zmq::sockopt::router_handover, true);
    } else {
      socket_.set(zmq::sockopt::routing_id, random_id());
    }
  }

  zmq::socket_t& socket() { return socket_; }

  /// Before it is bound.
  void admit_only(const std::filesystem::path& keys) {
    const KeyPair own = read_coordinator_key(keys);
    authenticator_.emplace(context_, keys);
    socket_.set(zmq::sockopt::curve_server, true);
    socket_.set(zmq::sockopt::curve_secretkey, own.secret);
    socket_.set(zmq::sockopt::zap_domain, "parray");
  }
  /// Before it is connected.
  void use(const MemberKey& key) {
    socket_.set(zmq::sockopt::curve_serverkey, key.coordinator);
    socket_.set(zmq::sockopt::curve_publickey, key.own.open);
    socket_.set(zmq::sockopt::curve_secretkey, key.own.secret);
  }

  bool send(const PeerId& to, Envelope content) override {
    std::vector<zmq::message_t> parts;
    if (router_) {
      parts.emplace_back(to.data(), to.size());
    }
    for (const Frame& frame : content.frames()) {
      parts.push_back(part_of(frame));
    }
    try {
      return zmq::send_multipart(socket_, parts, zmq::send_flags::dontwait).has_value();
    } catch (const zmq::error_t& error) {
      if (error.num() == EHOSTUNREACH || error.num() == EINTR) {
        return false;
      }
      throw RunError(std::string("sending a message: ") + error.what());
    }
  }

  /// A message of more frames than any has is dropped as it is read, some frames a call, so that
  /// nobody else waits for its end: each call delivers a message without frames, which is none.
  std::optional<Delivery> receive() override {
    if (authenticator_) {
      authenticator_->serve();
    }
    Delivery delivery;
    Frames frames;
    bool more = true;
    for (std::size_t i = 0; more && i < most_parts; ++i) {
      zmq::message_t part;
      while (!receive_part(part)) {
        if (i == 0 && !dropping_) {
          return {};
        }  // else it was a signal: the frames of a message arrive all at once
      }
      more = part.more();
      if (authenticator_) {
        delivery.sender = authenticator_->sender_of(part);
      }
      if (router_ && i == 0 && !dropping_) {
        delivery.peer = part.to_string();
      } else if (!dropping_) {
        frames.push_back(frame_of(std::move(part)));
      }
    }
    if (more || dropping_) {
      frames.clear();
    }
    dropping_ = more;
    delivery.content = std::move(frames);
    return delivery;
  }

  void wait(Time timeout) override {
    std::vector<zmq::pollitem_t> items{{socket_.handle(), 0, ZMQ_POLLIN, 0},
                                       {nullptr, wake_up_.fd(), ZMQ_POLLIN, 0}};
    if (authenticator_) {
      items.push_back({authenticator_->handle(), 0, ZMQ_POLLIN, 0});
    }
    // Rounded up, so that a deadline below a millisecond is slept for, not spun for.
    const auto ms = std::chrono::ceil<milliseconds>(timeout);
    try {
      zmq::poll(items, ms);
    } catch (const zmq::error_t& error) {
      if (error.num() != EINTR) {  // a signal ends the wait, as its handler wants
        throw RunError(std::string("waiting for messages: ") + error.what());
      }
    }
    if ((items[1].revents & ZMQ_POLLIN) != 0) {
      wake_up_.clear();
    }
  }

  void wake() noexcept override { wake_up_.raise(); }

 private:
  static constexpr int most_waiting = 1000;  // messages a peer
  static constexpr std::size_t most_parts = 16;

  /// False: nothing is there.
  bool receive_part(zmq::message_t& part) {
    try {
      return socket_.recv(part, zmq::recv_flags::dontwait).has_value();
    } catch (const zmq::error_t& error) {
      if (error.num() == EINTR) {
        return false;
      }
      throw RunError(std::string("receiving a message: ") + error.what());
    }
  }

  /// The socket holds the frame until it is sent; small ones are cheaper to copy.
  static zmq::message_t part_of(const Frame& frame) {
    constexpr std::size_t small = 4096;
    if (frame.size() <= small) {
      return {frame.view().data(), frame.size()};
    }
    auto held = std::make_unique<std::shared_ptr<const void>>(frame.owner());
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast): ZeroMQ does not write to what it sends
    return {const_cast<char*>(frame.view().data()), frame.size(),
            [](void* /*data*/, void* hint) {
              delete static_cast<std::shared_ptr<const void>*>(hint);  // NOLINT: its C interface
            },
            held.release()};
  }

  static Frame frame_of(zmq::message_t part) {
    const auto held = std::make_shared<const zmq::message_t>(std::move(part));
    return {held, {static_cast<const char*>(held->data()), held->size()}};
  }

  /// Fresh for every link: a process that restarts is another peer.
  static std::string random_id() {
    std::random_device device;
    std::string id = "p";  // ids that begin with a zero byte are ZeroMQ's own
    for (int i = 0; i < 16; ++i) {
      id += static_cast<char>('a' + device() % 26);
    }
    return id;
  }

  zmq::context_t context_{1};
  std::optional<Authenticator> authenticator_;
  zmq::socket_t socket_;
  WakeUp wake_up_;
  bool router_;
  bool dropping_ = false;  ///< the rest of a message
};

}  // namespace

bool is_loopback(const std::string& endpoint) {
  constexpr std::array<std::string_view, 3> prefixes = {
      "tcp://[::1]:", "tcp://localhost:", "ipc://"};
  for (const std::string_view prefix : prefixes) {
    if (endpoint.starts_with(prefix)) {
      return true;
    }
  }
  constexpr std::string_view net = "tcp://127.";
  const std::size_t colon = endpoint.rfind(':');  // the host must be digits: 127.example is a name
  return endpoint.starts_with(net) && colon >= net.size() &&
         endpoint.find_first_not_of("0123456789.", net.size()) == colon;
}

class ZmqServer::Impl {
 public:
  Impl(const std::string& endpoint, std::size_t max_message_bytes,
       const std::filesystem::path& keys)
      : link_(zmq::socket_type::router, max_message_bytes, seconds(1)) {
    if (!keys.empty()) {
      link_.admit_only(keys);
    }
    try {
      link_.socket().bind(endpoint);
    } catch (const zmq::error_t& error) {
      throw RunError("binding " + endpoint + ": " + error.what());
    }
    endpoint_ = link_.socket().get(zmq::sockopt::last_endpoint);
  }

  ZmqLink& link() { return link_; }
  [[nodiscard]] const std::string& endpoint() const { return endpoint_; }

 private:
  ZmqLink link_;
  std::string endpoint_;
};

ZmqServer::ZmqServer(const std::string& endpoint, std::size_t max_message_bytes,
                     const std::filesystem::path& keys)
    : impl_(std::make_unique<Impl>(endpoint, max_message_bytes, keys)) {}
ZmqServer::~ZmqServer() = default;
Link& ZmqServer::link() { return impl_->link(); }
const std::string& ZmqServer::endpoint() const { return impl_->endpoint(); }

std::unique_ptr<Link> zmq_connect(const std::string& endpoint, std::size_t max_message_bytes,
                                  Time linger, const std::optional<MemberKey>& key) {
  auto link = std::make_unique<ZmqLink>(zmq::socket_type::dealer, max_message_bytes, linger);
  if (key) {
    link->use(*key);
  }
  try {
    link->socket().connect(endpoint);
  } catch (const zmq::error_t& error) {
    throw InputError("cannot connect to '" + endpoint + "': " + error.what() +
                     "; an address looks like tcp://127.0.0.1:7400");
  }
  return link;
}

}  // namespace parray

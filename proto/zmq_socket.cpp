#include "proto/zmq_socket.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <random>
#include <utility>
#include <vector>
#include <zmq_addon.hpp>

#include "common/base/error.h"

namespace parray::proto {
namespace {

constexpr int most_waiting = 1000;  // messages per peer
constexpr std::size_t most_parts = 16;

/// The socket holds the frame until it is sent; copying a small frame is cheaper.
zmq::message_t part_of(const Frame& frame) {
  constexpr std::size_t small = 4096;
  if (frame.size() <= small) return {frame.view().data(), frame.size()};
  auto held = std::make_unique<std::shared_ptr<const void>>(frame.owner());
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast): ZeroMQ does not write to what it sends
  return {const_cast<char*>(frame.view().data()), frame.size(),
          [](void* /*data*/, void* hint) {
            delete static_cast<std::shared_ptr<const void>*>(hint);  // NOLINT: its C interface
          },
          held.release()};
}

Frame frame_of(zmq::message_t part) {
  const auto held = std::make_shared<const zmq::message_t>(std::move(part));
  return {held, {static_cast<const char*>(held->data()), held->size()}};
}

/// Makes a new id for every socket: a process that restarts is a different peer.
std::string random_id() {
  std::random_device device;
  std::string id = "p";  // ids that begin with a zero byte are ZeroMQ's own
  for (int i = 0; i < 16; ++i) id += static_cast<char>('a' + device() % 26);
  return id;
}

/// Returns the address of the machine from which a part came. Peers of a socket file (ipc://) are
/// on this machine. ZeroMQ calls their address ":USER:GROUP:PROCESS".
std::string address_of(zmq::message_t& part) {
  const char* const peer = zmq_msg_gets(part.handle(), "Peer-Address");
  return peer == nullptr || *peer == '\0' || *peer == ':' ? "localhost" : peer;
}

}  // namespace

ZmqSocket::ZmqSocket(zmq::context_t& context, zmq::socket_type type, std::size_t max_message_bytes,
                     Time linger)
    : socket_(context, type), router_(type == zmq::socket_type::router) {
  const auto linger_ms = std::chrono::duration_cast<milliseconds>(linger).count();
  socket_.set(zmq::sockopt::linger, static_cast<int>(linger_ms));
  socket_.set(zmq::sockopt::maxmsgsize, static_cast<std::int64_t>(max_message_bytes));
  socket_.set(zmq::sockopt::sndhwm, most_waiting);
  socket_.set(zmq::sockopt::rcvhwm, most_waiting);
  // A machine that vanished silently must not hold a file descriptor for ever.
  socket_.set(zmq::sockopt::tcp_keepalive, 1);
  socket_.set(zmq::sockopt::tcp_keepalive_idle, 20);
  socket_.set(zmq::sockopt::tcp_keepalive_intvl, 5);
  socket_.set(zmq::sockopt::tcp_keepalive_cnt, 4);
  // A connection with lost answers is closed early, too. TCP would wait longer and longer, but a
  // new connection finds a restored path at once.
  socket_.set(zmq::sockopt::tcp_maxrt, 10000);
  socket_.set(zmq::sockopt::connect_timeout, 3000);
  if (router_) {
    // Without this option, messages for a vanished or slow peer are lost silently.
    socket_.set(zmq::sockopt::router_mandatory, true);
    // A peer that returns under its old id replaces its old connection.
    socket_.set(zmq::sockopt::router_handover, true);
  } else {
    socket_.set(zmq::sockopt::routing_id, random_id());
  }
}

void ZmqSocket::serve_as(const KeyPair& own) {
  socket_.set(zmq::sockopt::curve_server, true);
  socket_.set(zmq::sockopt::curve_secretkey, own.secret);
}

void ZmqSocket::speak_as(const KeyPair& own, const std::string& server) {
  socket_.set(zmq::sockopt::curve_serverkey, server);
  socket_.set(zmq::sockopt::curve_publickey, own.open);
  socket_.set(zmq::sockopt::curve_secretkey, own.secret);
}

void ZmqSocket::connect(AddressList addresses) {
  for (const std::string& address : addresses.all()) {
    connect_to(address);  // so that a bad address is reported now
    if (address != addresses.current()) socket_.disconnect(address);
  }
  addresses_ = std::move(addresses);
}

void ZmqSocket::connect_to(const std::string& address) {
  try {
    socket_.connect(address);
  } catch (const zmq::error_t& error) {
    throw InputError("cannot connect to '" + address + "': " + error.what() +
                     ": write an address like tcp://127.0.0.1:7400");
  }
}

void ZmqSocket::leave_silent_address() {
  if (!addresses_) return;
  const std::string left = addresses_->current();
  if (addresses_->move_on(clock_.now())) {
    socket_.disconnect(left);
    connect_to(addresses_->current());
  }
}

bool ZmqSocket::send(const PeerId& to, const Envelope& content) {
  std::vector<zmq::message_t> parts;
  if (router_) parts.emplace_back(to.data(), to.size());
  std::size_t bytes = 0;
  for (const Frame& frame : content.frames()) {
    parts.push_back(part_of(frame));
    bytes += frame.size();
  }
  if (addresses_) addresses_->sent(clock_.now(), bytes);
  try {
    return zmq::send_multipart(socket_, parts, zmq::send_flags::dontwait).has_value();
  } catch (const zmq::error_t& error) {
    if (error.num() == EHOSTUNREACH || error.num() == EINTR) return false;
    throw RunError(std::string("sending a message: ") + error.what());
  }
}

std::optional<Delivery> ZmqSocket::receive() {
  Delivery delivery;
  Frames frames;
  bool more = true;
  for (std::size_t i = 0; more && i < most_parts; ++i) {
    zmq::message_t part;
    while (!receive_part(part)) {
      if (i == 0 && !dropping_) {
        leave_silent_address();
        return {};
      }  // otherwise a signal interrupted the call: the frames of a message arrive all at once
    }
    more = part.more();
    if (router_ && !more) {  // the last part: ZeroMQ may not know the connection of the first one
      Sender& sender = delivery.sender;
      sender = identify_(zmq_msg_gets(part.handle(), "User-Id"));
      sender.address = address_of(part);
      const bool near = sender.address == "localhost" || sender.address.starts_with("127.") ||
                        sender.address.starts_with("::");
      sender.ours = near && own_peers_.has(zmq_msg_get(part.handle(), ZMQ_SRCFD));
    }
    if (router_ && i == 0 && !dropping_) {
      delivery.peer = part.to_string();
    } else if (!dropping_) {
      frames.push_back(frame_of(std::move(part)));
    }
  }
  if (more || dropping_) frames.clear();
  dropping_ = more;
  if (addresses_) addresses_->heard();
  delivery.content = std::move(frames);
  return delivery;
}

/// Returns false if no part has arrived.
bool ZmqSocket::receive_part(zmq::message_t& part) {
  try {
    return socket_.recv(part, zmq::recv_flags::dontwait).has_value();
  } catch (const zmq::error_t& error) {
    if (error.num() == EINTR) return false;
    throw RunError(std::string("receiving a message: ") + error.what());
  }
}

WakeUp::WakeUp() : fd_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (fd_ < 0) {
    throw RunError("creating an eventfd failed: raise the limit of file descriptors (ulimit -n)");
  }
}

WakeUp::~WakeUp() { close(fd_); }

void WakeUp::raise() const noexcept {
  if (raised_.exchange(true)) return;
  const std::uint64_t one = 1;
  // If the counter is full, it is already raised.
  [[maybe_unused]] const auto written = write(fd_, &one, sizeof one);
}

void WakeUp::poll(std::vector<zmq::pollitem_t> items, Time timeout) const {
  items.push_back({nullptr, fd_, ZMQ_POLLIN, 0});
  try {
    // Rounded up, so that a deadline below a millisecond sleeps instead of spinning.
    zmq::poll(items, std::chrono::ceil<milliseconds>(timeout));
  } catch (const zmq::error_t& error) {
    if (error.num() != EINTR) {  // a signal ends the wait, as its handler intends
      throw RunError(std::string("waiting for messages: ") + error.what());
    }
  }
  if ((items.back().revents & ZMQ_POLLIN) != 0) {
    std::uint64_t count = 0;
    [[maybe_unused]] const auto got = ::read(fd_, &count, sizeof count);
    raised_ = false;  // reset before the caller looks for messages
  }
}

}  // namespace parray::proto

#include "coordinator/http/server.h"

#include <exception>
#include <utility>

#include "common/base/error.h"
#include "common/base/host_port.h"
#include "common/base/printable.h"
#include "coordinator/http/conversation.h"
#include "coordinator/http/doorman.h"
#include "coordinator/http/handler_pool.h"
#include "coordinator/http/listener.h"

namespace parray::http {
namespace {

HostPort parse_address(const std::string& address) {
  if (const auto parsed = parse_host_port(address)) return *parsed;
  throw InputError("--http " + printable(address) +
                   ": is no address to serve: write HOST:PORT, as 127.0.0.1:7480");
}

Listener bind_address(const std::string& address) {
  const HostPort wanted = parse_address(address);
  if (const auto listener = listen_at(wanted.host, wanted.port)) return *listener;
  throw RunError("--http " + printable(address) +
                 ": cannot be bound: is another program there, or is it no address of this "
                 "machine?");
}

std::string address_text(const HostPort& at) {
  const bool six = at.host.find(':') != std::string::npos;
  return (six ? "[" + at.host + "]" : at.host) + ":" + std::to_string(at.port);
}

/// One address does not get all threads of a kind.
std::size_t three_quarters(std::size_t threads) { return threads - threads / 4; }

}  // namespace

class Server::Impl {
 public:
  Impl(const std::string& address, const ServerLimits& limits, Callbacks callbacks)
      : answer_(std::move(callbacks.answer)),
        listener_(bind_address(address)),
        address_(address_text({parse_address(address).host, listener_.port})),
        doorman_(listener_.socket, limits.seats,
                 {std::move(callbacks.at_door),
                  [this](Doorman::Guest guest, const RequestHead& head) {
                    HandlerPool& pool = pool_for(*guest, head);
                    pool.give(std::move(guest));
                  },
                  std::move(callbacks.warn)}),
        requests_(limits.threads, limits.threads, [this] { return make_handler(); }),
        bodies_(limits.bodies, three_quarters(limits.bodies), [this] { return make_handler(); }),
        readiness_(2, 2, [this] { return make_handler(); }) {}

  /// First of all nobody has a connection any more: who waits for one finds it cut.
  ~Impl() { doorman_.stop(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void start() { doorman_.start(); }
  [[nodiscard]] const std::string& address() const { return address_; }

 private:
  HandlerPool& pool_for(const Connection& guest, const RequestHead& head) {
    if (!guest.is_whole()) return bodies_;
    return head.path() == "/readyz" ? readiness_ : requests_;
  }

  HandlerPool::Handler make_handler() {
    const auto conversation = std::make_shared<Conversation>(answer_);
    return [this, conversation](const HandlerPool::Guest& guest) {
      bool keep = false;
      try {
        keep = conversation->answer(*guest);
        std::size_t ignored = 0;
        guest->flush(ignored);  // what the other side does not take now is the doorman's
      } catch (const std::exception&) {
        guest->cut();  // there is no memory for an answer
      }
      doorman_.give_back(guest, keep);
    };
  }

  const std::function<Reply(const Request&)> answer_;
  const Listener listener_;
  const std::string address_;
  Doorman doorman_;
  HandlerPool requests_;
  HandlerPool bodies_;
  HandlerPool readiness_;
};

Server::Server(const std::string& address, const ServerLimits& limits, Callbacks callbacks)
    : impl_(std::make_unique<Impl>(address, limits, std::move(callbacks))) {}
Server::~Server() = default;
void Server::start() { impl_->start(); }
const std::string& Server::address() const { return impl_->address(); }

}  // namespace parray::http

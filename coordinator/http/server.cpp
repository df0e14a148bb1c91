#include "coordinator/http/server.h"

#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <exception>
#include <system_error>
#include <utility>

#include "common/base/error.h"
#include "common/base/host_port.h"
#include "common/base/printable.h"
#include "coordinator/http/conversation.h"

namespace parray::http {

HostPort parse_address(const std::string& address) {
  if (const auto parsed = parse_host_port(address)) return *parsed;
  throw InputError(
      "--http " + printable(address) +
      " is not an address to serve: write HOST:PORT, such as 127.0.0.1:7480 or [::1]:7480");
}

namespace {

Listener bind_address(const std::string& address) {
  const HostPort wanted = parse_address(address);
  if (const auto listener = listen_at(wanted.host, wanted.port)) return *listener;
  throw RunError("--http " + printable(address) +
                 " cannot be bound: another program may use it, it may not be an address of this "
                 "machine, or the port needs the rights of root");
}

std::string address_text(const HostPort& at) {
  const bool six = at.host.find(':') != std::string::npos;
  return (six ? "[" + at.host + "]" : at.host) + ":" + std::to_string(at.port);
}

/// Limit of threads for requests with large bodies. Must exceed most_uploads (upload_reader.h).
constexpr std::size_t body_threads = 40;
/// Limit per address, so that one address cannot use all.
constexpr std::size_t body_threads_of_address = 30;

}  // namespace

void HandlerPool::give(SharedConnection connection) {
  const std::scoped_lock lock(mutex_);
  const std::string owner = owner_of_address(connection->address());
  turns_.push(owner, std::move(connection));
  if (idle_ < turns_.waiting() && threads_.size() < most_) {
    try {
      threads_.emplace_back([this] { work(); });
    } catch (const std::system_error&) {
      // Existing threads do the work. Without any, the next call tries again.
    }
  }
  given_.notify_one();
}

HandlerPool::~HandlerPool() {
  {
    const std::scoped_lock lock(mutex_);
    stopped_ = true;
  }
  given_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void HandlerPool::work() {
  constexpr int low = 5;
  setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), low);
  const Handler handle = make_handler_();
  std::unique_lock lock(mutex_);
  while (!stopped_) {
    std::optional<SharedConnection> connection = turns_.take();
    if (!connection) {
      ++idle_;
      given_.wait(lock);
      --idle_;
      continue;
    }
    const std::string owner = owner_of_address((*connection)->address());
    lock.unlock();
    handle(*connection);
    connection.reset();
    lock.lock();
    turns_.ended(owner);
    if (turns_.waiting() > 0) given_.notify_one();  // a request of this owner may begin now
  }
}

Server::Server(const std::string& address, std::size_t threads, const SeatLimits& seats,
               Answer answer, ConnectionManager::Callbacks callbacks)
    : answer_(std::move(answer)),
      answered_(callbacks.answered),
      listener_(bind_address(address)),
      address_(address_text({parse_address(address).host, listener_.port})),
      manager_(listener_.socket, seats, std::move(callbacks),
               [this](SharedConnection connection, const RequestHead& head) {
                 HandlerPool& pool = !connection->is_whole()    ? bodies_
                                     : head.path() == "/readyz" ? readiness_
                                                                : requests_;
                 pool.give(std::move(connection));
               }),
      requests_(threads, threads, [this] { return make_handler(); }),
      bodies_(body_threads, body_threads_of_address, [this] { return make_handler(); }),
      readiness_(2, 2, [this] { return make_handler(); }) {}

/// Cuts the connections first, so that handlers that wait for a connection end.
Server::~Server() { manager_.stop(); }

HandlerPool::Handler Server::make_handler() {
  return
      [this, answer = make_conversation(answer_, answered_)](const SharedConnection& connection) {
        bool keep = false;
        try {
          keep = answer(*connection);
          std::size_t ignored = 0;
          connection->flush(ignored);  // the connection manager sends the rest
        } catch (const std::exception&) {
          connection->cut();  // memory is short, or a stream has failed
        }
        manager_.give_back(connection, keep);
      };
}

}  // namespace parray::http

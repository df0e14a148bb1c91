#include "coordinator/http/connection_manager.h"

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <exception>
#include <system_error>
#include <utility>

#include "common/base/error.h"

namespace parray::http {
namespace {

constexpr ConnectionId listener_id = 0;
constexpr ConnectionId wake_id = 1;
constexpr ConnectionId first_id = 2;

constexpr std::size_t most_at_once = std::size_t{1} << 14;       // bytes per connection and read
constexpr std::size_t most_input_bytes = std::size_t{1} << 25;   // all connections together
constexpr std::size_t most_output_bytes = std::size_t{1} << 26;  // all connections together
// Closing a connection while bytes arrive destroys the last answer. So the manager reads and drops
// what arrives after the answer, until nothing arrives for drain_pause.
constexpr Time drain_pause = seconds(1);
constexpr Time drain_time = seconds(10);
constexpr std::size_t most_drained = std::size_t{1} << 24;

}  // namespace

ConnectionManager::ConnectionManager(int listener, SeatLimits limits, Callbacks callbacks,
                                     HandOver hand_over)
    : listener_(listener),
      wake_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
      poll_(epoll_create1(EPOLL_CLOEXEC)),
      callbacks_(std::move(callbacks)),
      hand_over_(std::move(hand_over)),
      seats_(limits),
      next_id_(first_id) {
  epoll_event wake{EPOLLIN, {.u64 = wake_id}};
  if (wake_ < 0 || poll_ < 0 || epoll_ctl(poll_, EPOLL_CTL_ADD, wake_, &wake) != 0) {
    throw RunError("--http: watching connections failed: " +
                   std::generic_category().message(errno) + ": raise ulimit -n, or free memory");
  }
}

ConnectionManager::~ConnectionManager() {
  stop();
  for (const int socket : {listener_, wake_, poll_}) close(socket);
}

void ConnectionManager::start() {
  thread_ = std::thread([this] { run(); });
}

void ConnectionManager::stop() {
  if (!thread_.joinable()) return;
  stopped_ = true;
  eventfd_write(wake_, 1);
  thread_.join();
}

void ConnectionManager::give_back(SharedConnection connection, bool keep) {
  {
    const std::scoped_lock lock(mutex_);
    returned_.emplace_back(std::move(connection), keep);
  }
  eventfd_write(wake_, 1);
}

void ConnectionManager::run() {
  const SteadyClock clock;
  constexpr Time sweep = milliseconds(200);
  Time sweep_at = clock.now() + sweep;
  listen(true);
  while (!stopped_) {
    std::array<epoll_event, 64> events{};
    const int timeout =
        entries_.empty() && listens_ ? -1 : static_cast<int>(sweep / milliseconds(1));
    const int count = epoll_wait(poll_, events.data(), static_cast<int>(events.size()), timeout);
    const Time now = clock.now();
    for (int i = 0; i < count; ++i) {
      const ConnectionId id = events.at(static_cast<std::size_t>(i)).data.u64;
      try {
        handle(now, id);
      } catch (const std::exception& error) {  // out of memory: other connections continue
        callbacks_.warn(std::string("HTTP: a connection was closed: ") + error.what());
        remove(id);
      }
    }
    if (now < sweep_at) continue;
    sweep_at = now + sweep;
    remove_late(now);
    listen(true);
  }
  for (const auto& [id, entry] : entries_) entry.connection->cut();
}

void ConnectionManager::handle(Time now, ConnectionId id) {
  if (id == listener_id) {
    accept_all(now);
  } else if (id == wake_id) {
    take_back(now);
  } else if (const auto found = entries_.find(id); found != entries_.end()) {
    Entry& entry = found->second;
    const bool reads = entry.phase == Phase::reading || entry.phase == Phase::draining;
    if (!reads || receive(now, id, entry)) proceed(now, id);
  }
}

void ConnectionManager::accept_all(Time now) {
  constexpr int most = 64;  // per call, so that open connections get their turn
  for (int i = 0; i < most; ++i) {
    std::optional<Arrival> arrival = accept_at(listener_);
    if (!arrival) {
      if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM) {
        callbacks_.warn(
            "HTTP: new connections wait: no file descriptors or memory are left: raise ulimit -n, "
            "or lower --http-connections");
        listen(false);  // until the next sweep
      }
      return;
    }
    add_connection(now, arrival->socket, std::move(arrival->address));
  }
}

void ConnectionManager::add_connection(Time now, int socket, std::string address) {
  const ConnectionId id = next_id_++;
  const auto connection = std::make_shared<Connection>(socket, id, std::move(address));
  const auto admission = seats_.enter(now, id, owner_of_address(connection->address()));
  if (admission.displaced || admission.reserve) {
    callbacks_.warn(
        "HTTP: the limit of connections is reached: see --http-connections and "
        "--http-connections-per-address");
  }
  if (admission.displaced) remove(*admission.displaced);
  if (admission.displaced == id) return;
  Entry& entry = entries_.emplace(id, Entry{connection}).first->second;
  entry.reserve = admission.reserve;
  watch(id, entry, EPOLLIN);
  if (receive(now, id, entry)) proceed(now, id);  // a request is often here already
}

void ConnectionManager::take_back(Time now) {
  eventfd_t ignored = 0;
  eventfd_read(wake_, &ignored);
  decltype(returned_) returned;
  {
    const std::scoped_lock lock(mutex_);
    returned = std::exchange(returned_, {});
  }
  for (const auto& [connection, keep] : returned) {
    const auto found = entries_.find(connection->id());
    if (found == entries_.end()) continue;
    Entry& entry = found->second;
    entry.keep = entry.keep && keep;
    entry.phase = Phase::writing;
    entry.waits_since = now;
    entry.pace.restart();
    recount(entry, connection->input().size());
    proceed(now, connection->id());
  }
}

/// Receives bytes. Returns false if the connection was removed or has nothing to process.
bool ConnectionManager::receive(Time now, ConnectionId id, Entry& entry) {
  const bool first = entry.connection->input().empty();
  const Connection::Moved moved = entry.connection->receive(most_at_once);
  if (moved == Connection::Moved::none) return false;
  if (entry.phase == Phase::draining) {
    entry.drained += entry.connection->input().size();
    entry.drains_until = std::min(now + drain_pause, entry.drain_end);
    entry.connection->consume(entry.connection->input().size());
    if (moved == Connection::Moved::ended || entry.drained > most_drained) remove(id);
    return false;
  }
  entry.ended = moved == Connection::Moved::ended;
  if (entry.ended && !entry.head) {
    remove(id);
    return false;
  }
  if (first) seats_.begins_head(now, id);
  recount(entry, entry.connection->input().size());
  if (input_bytes_ <= most_input_bytes) return true;
  callbacks_.warn("HTTP: a connection was closed: incomplete requests take too much memory");
  remove(id);
  return false;
}

/// Processes a connection until it has to wait.
void ConnectionManager::proceed(Time now, ConnectionId id) {
  for (;;) {
    const auto found = entries_.find(id);
    if (found == entries_.end()) return;
    Entry& entry = found->second;
    const bool goes_on = entry.phase == Phase::reading   ? next_request(now, id, entry)
                         : entry.phase == Phase::writing ? write(now, id, entry)
                                                         : false;
    if (!goes_on) return;
  }
}

/// Reads and dispatches the next request. Returns true if there is an answer to send.
bool ConnectionManager::next_request(Time now, ConnectionId id, Entry& entry) {
  try {
    if ((!entry.head && !read_head(entry)) || awaits_body(entry)) {
      watch(id, entry, EPOLLIN);
      return false;
    }
    seats_.has_asked(id);
    entry.connection->set_whole(is_complete(entry));
    dispatch(id, entry);
  } catch (const Problem& problem) {
    refuse(entry, problem);
  }
  if (entry.phase != Phase::writing) return false;
  entry.waits_since = now;
  return true;
}

/// Reads the head into entry.head. Returns false if it is incomplete. Throws Problem.
bool ConnectionManager::read_head(Entry& entry) {
  Connection& connection = *entry.connection;
  // A server ignores an empty line before a request (RFC 9112, section 2.2).
  if (entry.searched == 0 && connection.input().starts_with("\r\n")) connection.consume(2);
  const std::string_view input = connection.input();
  const auto end = end_of_head(input, std::exchange(entry.searched, input.size()));
  if (end.value_or(input.size()) > most_head_bytes) {
    throw Problem(431,
                  "the URL and headers of the request have more than 65536 bytes: shorten them");
  }
  if (!end) return false;
  entry.head = parse_head(input.substr(0, *end));
  entry.chunks = {};
  entry.decoded = *end;
  entry.sent_continue = false;
  return true;
}

/// Returns whether the input holds the whole request. Throws Problem 400.
bool ConnectionManager::is_complete(Entry& entry) {
  const std::string_view input = entry.connection->input();
  if (!entry.head->chunked) {
    return input.size() - entry.head->bytes >= entry.head->length.value_or(0);
  }
  std::size_t used = 1;
  while (used > 0 && !entry.chunks.done()) {
    used = entry.chunks.step(input.substr(entry.decoded)).used;
    entry.decoded += used;
  }
  return entry.chunks.done();
}

/// Returns whether to wait for the body here. Small bodies are read here; handlers read large ones.
bool ConnectionManager::awaits_body(Entry& entry) {
  const RequestHead& head = *entry.head;
  const std::size_t there = entry.connection->input().size() - head.bytes;
  if (entry.ended || is_complete(entry) || std::max(there, head.length.value_or(0)) > small_body) {
    return false;
  }
  if (head.expects && there == 0 && !std::exchange(entry.sent_continue, true)) {
    entry.connection->put(continue_line);
    std::size_t ignored = 0;
    entry.connection->flush(ignored);  // the rest is sent with the answer
  }
  return true;
}

void ConnectionManager::dispatch(ConnectionId id, Entry& entry) {
  const RequestHead head = std::move(*std::exchange(entry.head, {}));
  entry.searched = 0;
  entry.keep = !head.closes && !entry.reserve;
  auto reply = callbacks_.answer_early(head, entry.connection->address(), entry.reserve);
  if (!reply && output_bytes_ > most_output_bytes) {
    reply = problem_reply(Problem(503, "slow readers hold too many answers: try again later", 0,
                                  {{"Retry-After", "5"}}));
  }
  if (reply) {
    entry.keep = entry.keep && !head.has_body();
    entry.connection->consume(head.bytes);
    recount(entry, entry.connection->input().size());
    put_answer(entry, *reply, head.method != "HEAD");
    return;
  }
  watch(id, entry, 0);
  recount(entry, 0);
  entry.phase = Phase::answered_elsewhere;
  hand_over_(entry.connection, head);
}

void ConnectionManager::refuse(Entry& entry, const Problem& problem) {
  seats_.has_asked(entry.connection->id());
  entry.keep = false;
  put_answer(entry, problem_reply(problem), true);
}

void ConnectionManager::put_answer(Entry& entry, const Reply& reply, bool with_body) {
  std::string head = "HTTP/1.1 " + std::to_string(reply.status) + " " +
                     std::string(reason_of(reply.status)) + "\r\n";
  for (const auto& [name, value] : fields_of(reply)) head += name + ": " + value + "\r\n";
  head += "Content-Type: " + reply.type +
          "\r\nContent-Length: " + std::to_string(reply.body->size()) + "\r\n";
  callbacks_.answered(reply.status);
  entry.connection->put(head + (entry.keep ? "\r\n" : "Connection: close\r\n\r\n"));
  if (with_body) entry.connection->put(*reply.body);
  entry.pace.restart();
  entry.phase = Phase::writing;
}

/// Sends output. Returns true if all was sent and the next request may be read.
bool ConnectionManager::write(Time now, ConnectionId id, Entry& entry) {
  std::size_t bytes = 0;
  const Connection::Moved moved = entry.connection->flush(bytes);
  entry.pace.waited(now - std::exchange(entry.waits_since, now));
  entry.pace.moved(bytes);
  recount_output(entry, entry.connection->output_memory());
  if (moved == Connection::Moved::ended) {
    remove(id);
    return false;
  }
  if (moved == Connection::Moved::none) {
    watch(id, entry, EPOLLOUT);
    return false;
  }
  watch(id, entry, EPOLLIN);
  if (entry.keep) {
    entry.phase = Phase::reading;
    seats_.awaits_head(now, id);
    if (!entry.connection->input().empty()) seats_.begins_head(now, id);
    return true;
  }
  entry.connection->end_output();
  entry.phase = Phase::draining;
  entry.drains_until = now + drain_pause;
  entry.drain_end = now + drain_time;
  seats_.has_ended(now, id);
  return false;
}

void ConnectionManager::remove(ConnectionId id) {
  seats_.leave(id);
  const auto found = entries_.find(id);
  if (found == entries_.end()) return;
  recount(found->second, 0);
  recount_output(found->second, 0);
  watch(id, found->second, 0);
  found->second.connection->cut();
  entries_.erase(found);
}

void ConnectionManager::remove_late(Time now) {
  for (const ConnectionId id : seats_.late(now)) {
    Entry& entry = entries_.at(id);
    const bool silent = entry.connection->input().empty();
    if (!silent && entry.phase == Phase::reading) {
      const std::string part = entry.head ? "the body" : "the headers";
      refuse(entry,
             Problem(408, part + " of the request did not arrive within " +
                              (entry.reserve ? "2" : "10") + " seconds: send the request faster"));
      entry.waits_since = now;
      proceed(now, id);
    } else if (entry.phase == Phase::reading) {
      remove(id);
    }
  }
  std::vector<ConnectionId> slow;
  for (const auto& [id, entry] : entries_) {
    const bool slow_reader =
        entry.phase == Phase::writing && now - entry.waits_since >= entry.pace.left();
    const bool drained = entry.phase == Phase::draining && now >= entry.drains_until;
    if (slow_reader || drained) slow.push_back(id);
  }
  for (const ConnectionId id : slow) remove(id);
}

/// Sets the epoll events of the connection; 0: none.
void ConnectionManager::watch(ConnectionId id, Entry& entry, std::uint32_t events) const {
  if (events == entry.watched) return;
  epoll_event event{events, {.u64 = id}};
  const int change = events == 0          ? EPOLL_CTL_DEL
                     : entry.watched == 0 ? EPOLL_CTL_ADD
                                          : EPOLL_CTL_MOD;
  epoll_ctl(poll_, change, entry.connection->socket(), &event);
  entry.watched = events;
}

void ConnectionManager::listen(bool on) {
  if (on == std::exchange(listens_, on)) return;
  epoll_event event{EPOLLIN, {.u64 = listener_id}};
  epoll_ctl(poll_, on ? EPOLL_CTL_ADD : EPOLL_CTL_DEL, listener_, &event);
}

/// Records that the connection holds `bytes` received bytes.
void ConnectionManager::recount(Entry& entry, std::size_t bytes) {
  input_bytes_ += bytes;
  input_bytes_ -= std::exchange(entry.counted, bytes);
}

/// Records that the connection holds `bytes` of memory that wait to be sent.
void ConnectionManager::recount_output(Entry& entry, std::size_t bytes) {
  output_bytes_ += bytes;
  output_bytes_ -= std::exchange(entry.output, bytes);
}

}  // namespace parray::http

#include "coordinator/http/doorman.h"

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <exception>
#include <utility>

#include "common/base/error.h"
#include "coordinator/http/conversation.h"
#include "coordinator/http/listener.h"

namespace parray::http {
namespace {

constexpr ConnectionId listener_id = 0;
constexpr ConnectionId wake_id = 1;
constexpr ConnectionId first_id = 2;

constexpr std::size_t most_at_once = std::size_t{1} << 14;       // bytes read of one connection
constexpr std::size_t most_input_bytes = std::size_t{1} << 25;   // of all connections
constexpr std::size_t most_output_bytes = std::size_t{1} << 26;  // likewise
// A connection that is closed while bytes come in takes its last answer with it. So what comes
// after the answer is read and dropped, until it stops for drain_pause.
constexpr Time drain_pause = seconds(1);
constexpr Time drain_time = seconds(10);
constexpr std::size_t most_drained = std::size_t{1} << 24;

std::string head_text(const Reply& reply, bool keep) {
  std::string text = "HTTP/1.1 " + std::to_string(reply.status) + " " +
                     std::string(reason_of(reply.status)) + "\r\n";
  for (const auto& [name, value] : fields_of(reply)) text += name + ": " + value + "\r\n";
  text += "Content-Type: " + reply.type +
          "\r\nContent-Length: " + std::to_string(reply.body->size()) + "\r\n";
  return text + (keep ? "\r\n" : "Connection: close\r\n\r\n");
}

}  // namespace

Doorman::Doorman(int listener, SeatLimits limits, Callbacks callbacks)
    : listener_(listener),
      wake_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
      poll_(epoll_create1(EPOLL_CLOEXEC)),
      callbacks_(std::move(callbacks)),
      seats_(limits),
      next_id_(first_id) {
  epoll_event wake{EPOLLIN, {.u64 = wake_id}};
  if (wake_ < 0 || poll_ < 0 || epoll_ctl(poll_, EPOLL_CTL_ADD, wake_, &wake) != 0) {
    throw RunError("--http: out of file descriptors: raise ulimit -n");
  }
}

Doorman::~Doorman() {
  stop();
  for (const int socket : {listener_, wake_, poll_}) close(socket);
}

void Doorman::start() {
  thread_ = std::thread([this] { run(); });
}

void Doorman::stop() {
  if (!thread_.joinable()) return;
  stopped_ = true;
  eventfd_write(wake_, 1);
  thread_.join();
}

void Doorman::give_back(Guest guest, bool keep) {
  {
    const std::scoped_lock lock(mutex_);
    returned_.push_back({std::move(guest), keep});
  }
  eventfd_write(wake_, 1);
}

void Doorman::run() {
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
      } catch (const std::exception& error) {  // out of memory: the others stay
        callbacks_.warn(std::string("HTTP: a connection was closed: ") + error.what());
        remove(id);
      }
    }
    if (now < sweep_at) continue;
    sweep_at = now + sweep;
    remove_late(now);
    listen(true);
  }
  for (const auto& [id, entry] : entries_) entry.guest->cut();
}

void Doorman::handle(Time now, ConnectionId id) {
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

void Doorman::accept_all(Time now) {
  constexpr int most = 64;  // before the others have a turn
  for (int i = 0; i < most; ++i) {
    std::optional<Arrival> arrival = accept_at(listener_);
    if (arrival) {
      welcome(now, arrival->socket, std::move(arrival->address));
    } else {
      const bool exhausted =
          errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM;
      if (exhausted) {
        callbacks_.warn("HTTP: no connection can be accepted: out of file descriptors or memory");
        listen(false);  // until the next sweep
      }
      return;
    }
  }
}

void Doorman::welcome(Time now, int socket, std::string address) {
  const ConnectionId id = next_id_++;
  const auto guest = std::make_shared<Connection>(socket, id, std::move(address));
  const auto admission = seats_.enter(now, id, owner_of_address(guest->address()));
  if (admission.displaced || admission.reserve) {
    callbacks_.warn(
        "HTTP: as many connections are there as may be: see --http-connections and "
        "--http-connections-per-address");
  }
  if (admission.displaced) remove(*admission.displaced);
  if (admission.displaced == id) return;
  Entry& entry = entries_.emplace(id, Entry{guest, usual_pace()}).first->second;
  entry.reserve = admission.reserve;
  watch(id, entry, EPOLLIN);
  if (receive(now, id, entry)) proceed(now, id);  // what it asks for often comes with it
}

void Doorman::take_back(Time now) {
  eventfd_t ignored = 0;
  eventfd_read(wake_, &ignored);
  std::vector<Returned> returned;
  {
    const std::scoped_lock lock(mutex_);
    returned = std::exchange(returned_, {});
  }
  for (const auto& [guest, keep] : returned) {
    const auto found = entries_.find(guest->id());
    if (found == entries_.end()) continue;
    Entry& entry = found->second;
    entry.keep = entry.keep && keep;
    entry.phase = Phase::writing;
    entry.waits_since = now;
    entry.pace.restart();
    recount(entry, guest->input().size());
    proceed(now, guest->id());
  }
}

/// False: it is gone, or nothing has changed.
bool Doorman::receive(Time now, ConnectionId id, Entry& entry) {
  const bool first = entry.guest->input().empty();
  const Connection::Moved moved = entry.guest->receive(most_at_once);
  if (moved == Connection::Moved::none) return false;
  if (entry.phase == Phase::draining) {
    entry.drained += entry.guest->input().size();
    entry.drains_until = std::min(now + drain_pause, entry.drain_end);
    entry.guest->consume(entry.guest->input().size());
    if (moved == Connection::Moved::ended || entry.drained > most_drained) remove(id);
    return false;
  }
  entry.ended = moved == Connection::Moved::ended;
  if (entry.ended && !entry.head) {
    remove(id);
    return false;
  }
  if (first) seats_.begins_head(now, id);
  recount(entry, entry.guest->input().size());
  if (input_bytes_ <= most_input_bytes) return true;
  callbacks_.warn("HTTP: too much has come in of requests that are not whole");
  remove(id);
  return false;
}

/// Does what can be done with it until something has to be waited for.
void Doorman::proceed(Time now, ConnectionId id) {
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

/// True: there is something to send.
bool Doorman::next_request(Time now, ConnectionId id, Entry& entry) {
  try {
    if ((!entry.head && !read_head(entry)) || awaits_body(entry)) {
      watch(id, entry, EPOLLIN);
      return false;
    }
    seats_.has_asked(id);
    entry.guest->set_whole(has_come(entry));
    dispatch(id, entry);
  } catch (const Problem& problem) {
    refuse(entry, problem);
  }
  if (entry.phase != Phase::writing) return false;
  entry.waits_since = now;
  return true;
}

/// False: more of it has to come.
bool Doorman::read_head(Entry& entry) {
  Connection& guest = *entry.guest;
  // An empty line before a request is to be overlooked (RFC 9112, section 2.2).
  if (entry.searched == 0 && guest.input().starts_with("\r\n")) guest.consume(2);
  const std::string_view input = guest.input();
  const auto end = end_of_head(input, std::exchange(entry.searched, input.size()));
  if (end.value_or(input.size()) > most_head_bytes) {
    throw Problem(431, "the head of the request is longer than 65536 bytes");
  }
  if (!end) return false;
  entry.head = parse_head(input.substr(0, *end));
  entry.chunks = {};
  entry.decoded = *end;
  entry.told_to_go_on = false;
  return true;
}

/// Whether all of the request is in the input. Throws Problem 400.
bool Doorman::has_come(Entry& entry) {
  const std::string_view input = entry.guest->input();
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

/// Whether to wait for the body, which is small as far as is known.
bool Doorman::awaits_body(Entry& entry) {
  const RequestHead& head = *entry.head;
  const std::size_t there = entry.guest->input().size() - head.bytes;
  if (entry.ended || has_come(entry) || std::max(there, head.length.value_or(0)) > small_body) {
    return false;
  }
  if (head.expects && there == 0 && !std::exchange(entry.told_to_go_on, true)) {
    entry.guest->put(go_on);
    std::size_t ignored = 0;
    entry.guest->flush(ignored);  // what does not go now goes with the answer
  }
  return true;
}

void Doorman::dispatch(ConnectionId id, Entry& entry) {
  const RequestHead head = std::move(*std::exchange(entry.head, {}));
  entry.searched = 0;
  entry.keep = !head.closes && !entry.reserve;
  auto reply = callbacks_.at_door(head, entry.guest->address(), entry.reserve);
  if (!reply && output_bytes_ > most_output_bytes) {
    reply = problem_reply(Problem(503, "too many answers wait for slow readers: try again later", 0,
                                  {{"Retry-After", "5"}}));
  }
  if (reply) {
    entry.keep = entry.keep && !head.has_body();
    entry.guest->consume(head.bytes);
    recount(entry, entry.guest->input().size());
    entry.guest->put(head_text(*reply, entry.keep));
    if (head.method != "HEAD") entry.guest->put(*reply->body);
    entry.pace.restart();
    entry.phase = Phase::writing;
    return;
  }
  watch(id, entry, 0);
  recount(entry, 0);
  entry.phase = Phase::answered_elsewhere;
  callbacks_.hand_over(entry.guest, head);
}

void Doorman::refuse(Entry& entry, const Problem& problem) {
  const Reply reply = problem_reply(problem);
  seats_.has_asked(entry.guest->id());
  entry.keep = false;
  entry.guest->put(head_text(reply, false));
  entry.guest->put(*reply.body);
  entry.pace.restart();
  entry.phase = Phase::writing;
}

/// True: all has been sent, and the next request may be there.
bool Doorman::write(Time now, ConnectionId id, Entry& entry) {
  std::size_t bytes = 0;
  const Connection::Moved moved = entry.guest->flush(bytes);
  entry.pace.waited(now - std::exchange(entry.waits_since, now));
  entry.pace.moved(bytes);
  recount_output(entry, entry.guest->output_memory());
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
    if (!entry.guest->input().empty()) seats_.begins_head(now, id);
    return true;
  }
  entry.guest->end_output();
  entry.phase = Phase::draining;
  entry.drains_until = now + drain_pause;
  entry.drain_end = now + drain_time;
  seats_.has_ended(now, id);
  return false;
}

void Doorman::remove(ConnectionId id) {
  seats_.leave(id);
  const auto found = entries_.find(id);
  if (found == entries_.end()) return;
  recount(found->second, 0);
  recount_output(found->second, 0);
  watch(id, found->second, 0);
  found->second.guest->cut();
  entries_.erase(found);
}

void Doorman::remove_late(Time now) {
  for (const ConnectionId id : seats_.late(now)) {
    Entry& entry = entries_.at(id);
    const bool silent = entry.guest->input().empty();
    if (!silent && entry.phase == Phase::reading) {
      refuse(entry, Problem(408, "the request did not come within 10 seconds"));
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

/// 0: none.
void Doorman::watch(ConnectionId id, Entry& entry, std::uint32_t events) const {
  if (events == entry.watched) return;
  epoll_event event{events, {.u64 = id}};
  const int change = events == 0          ? EPOLL_CTL_DEL
                     : entry.watched == 0 ? EPOLL_CTL_ADD
                                          : EPOLL_CTL_MOD;
  epoll_ctl(poll_, change, entry.guest->socket(), &event);
  entry.watched = events;
}

void Doorman::listen(bool on) {
  if (on == std::exchange(listens_, on)) return;
  epoll_event event{EPOLLIN, {.u64 = listener_id}};
  epoll_ctl(poll_, on ? EPOLL_CTL_ADD : EPOLL_CTL_DEL, listener_, &event);
}

/// It holds so many bytes now.
void Doorman::recount(Entry& entry, std::size_t bytes) {
  input_bytes_ += bytes;
  input_bytes_ -= std::exchange(entry.counted, bytes);
}

/// So many bytes of memory wait to be sent.
void Doorman::recount_output(Entry& entry, std::size_t bytes) {
  output_bytes_ += bytes;
  output_bytes_ -= std::exchange(entry.output, bytes);
}

}  // namespace parray::http

#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "coordinator/http/connection.h"
#include "coordinator/http/exchange.h"
#include "coordinator/http/framing.h"
#include "coordinator/http/seats.h"

namespace parray::http {

/// Owns all connections that no handler is answering. Its thread accepts connections, reads heads
/// and small bodies of requests, sends answers, and closes connections that are too slow or send
/// too much. It never blocks on a connection, so that a connection needs a thread only while a
/// request is being answered.
class ConnectionManager {
 public:
  struct Callbacks {
    /// Returns a reply to send at once, or nothing if the request is handed over. Called by the
    /// manager's thread; must not block. `reserve`: the connection is one of SeatLimits::reserve,
    /// because no regular one was free.
    std::function<std::optional<Reply>(const RequestHead&, const std::string& address,
                                       bool reserve)>
        answer_early;
    /// Logs a warning about connections that wait, or were refused or closed. Called by the
    /// manager's thread.
    std::function<void(const std::string&)> warn;
    /// Called with the status of each answer that the manager makes itself: refusals, and replies
    /// of answer_early.
    std::function<void(int)> answered;
  };

  /// Takes over a connection with a request until give_back(). Must not block. The request is
  /// complete unless its body is large, or the client has stopped sending.
  using HandOver = std::function<void(SharedConnection, const RequestHead&)>;

  /// Takes over `listener`, a listening socket. Throws RunError if the system lacks descriptors or
  /// memory.
  ConnectionManager(int listener, SeatLimits limits, Callbacks callbacks, HandOver hand_over);
  /// Closes all connections.
  ~ConnectionManager();
  ConnectionManager& operator=(ConnectionManager&&) = delete;

  /// Starts the thread, which accepts connections from now on.
  void start();
  /// Cuts all connections, including those that are being answered, and accepts no more. Has no
  /// effect before start() or when called again.
  void stop();

  /// Returns a connection whose request was answered. The manager sends the rest of the output.
  /// Then it reads the next request if `keep` is set, and closes the connection otherwise. Callable
  /// from any thread.
  void give_back(SharedConnection connection, bool keep);

 private:
  /// What happens to a connection. `draining`: the last answer was sent, and what still arrives is
  /// dropped, because closing the connection at once could destroy the answer.
  enum class Phase : std::uint8_t { reading, answered_elsewhere, writing, draining };
  struct Entry {
    SharedConnection connection;
    Pace pace{};
    bool reserve = false;
    Phase phase = Phase::reading;
    std::uint32_t watched = 0;  ///< epoll events that are reported; 0: none
    std::size_t searched = 0;   ///< bytes of the input that were searched for the end of a head
    std::optional<RequestHead> head{};  ///< the head that was read, while its body arrives
    ChunkDecoder chunks{};              ///< decodes that body
    std::size_t decoded = 0;            ///< bytes of the input that head and decoded chunks take
    bool sent_continue = false;         ///< "100 Continue" was sent
    bool ended = false;                 ///< the client will send no more
    bool keep = true;                   ///< another request may follow
    std::size_t output = 0;             ///< this connection's share of output_bytes_
    std::size_t counted = 0;            ///< this connection's share of input_bytes_
    Time waits_since{};                 ///< phase writing: time of the last attempt to send
    Time drains_until{};                ///< phase draining: end if nothing more arrives
    Time drain_end{};                   ///< phase draining: latest end
    std::size_t drained = 0;            ///< phase draining: bytes dropped
  };

  void run();
  void accept_all(Time now);
  void add_connection(Time now, int socket, std::string address);
  void take_back(Time now);
  void handle(Time now, ConnectionId id);
  void proceed(Time now, ConnectionId id);
  bool receive(Time now, ConnectionId id, Entry& entry);
  bool next_request(Time now, ConnectionId id, Entry& entry);
  static bool read_head(Entry& entry);
  static bool is_complete(Entry& entry);
  static bool awaits_body(Entry& entry);
  void dispatch(ConnectionId id, Entry& entry);
  void refuse(Entry& entry, const Problem& problem);
  void put_answer(Entry& entry, const Reply& reply, bool with_body);
  bool write(Time now, ConnectionId id, Entry& entry);
  void remove(ConnectionId id);
  void remove_late(Time now);
  void watch(ConnectionId id, Entry& entry, std::uint32_t events) const;
  void listen(bool on);
  void recount(Entry& entry, std::size_t bytes);
  void recount_output(Entry& entry, std::size_t bytes);

  const int listener_;
  const int wake_;
  const int poll_;
  const Callbacks callbacks_;
  const HandOver hand_over_;
  std::atomic<bool> stopped_ = false;
  std::mutex mutex_;                                         // guards returned_
  std::vector<std::pair<SharedConnection, bool>> returned_;  ///< with `keep`
  // Used by the manager's thread only.
  Seats seats_;
  std::map<ConnectionId, Entry> entries_;
  ConnectionId next_id_;
  std::size_t input_bytes_ = 0;   ///< received bytes of all connections here
  std::size_t output_bytes_ = 0;  ///< bytes of memory of all answers that are being sent
  bool listens_ = false;
  std::thread thread_;
};

}  // namespace parray::http

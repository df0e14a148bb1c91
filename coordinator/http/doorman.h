#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "coordinator/http/chunk_decoder.h"
#include "coordinator/http/connection.h"
#include "coordinator/http/exchange.h"
#include "coordinator/http/request_head.h"
#include "coordinator/http/seats.h"

namespace parray::http {

/// Holds all connections while nobody answers them. One thread accepts them, reads heads of
/// requests, sends answers, and ends whoever is too slow or sends too much; it never waits for any
/// of them. So a connection takes a thread only while its request is being answered.
class Doorman {
 public:
  using Guest = std::shared_ptr<Connection>;

  struct Callbacks {
    /// Called by the doorman's thread: must not wait. A reply: that is it, and nobody else is
    /// asked. `reserve`: of a connection that there is no room for.
    std::function<std::optional<Reply>(const RequestHead&, const std::string& address,
                                       bool reserve)>
        at_door;
    /// Takes over a connection with a request until give_back(). Must not wait either. The request
    /// is whole unless its body is large.
    std::function<void(Guest, const RequestHead&)> hand_over;
    /// Tells a person: that connections are refused, or end.
    std::function<void(const std::string&)> warn;
  };

  /// `listener`: a socket that listens; taken over. Throws RunError.
  Doorman(int listener, SeatLimits limits, Callbacks callbacks);
  /// Cuts all connections.
  ~Doorman();
  Doorman(const Doorman&) = delete;
  Doorman& operator=(const Doorman&) = delete;

  /// From now on connections are accepted.
  void start();
  /// Cuts all connections, those that are being answered, too, and accepts none. Before start() and
  /// again: nothing.
  void stop();

  /// A request has been answered: the rest of its output is to be sent, and then the next request
  /// heard (`keep`) or the connection closed. Any thread.
  void give_back(Guest guest, bool keep);

 private:
  enum class Phase : std::uint8_t { reading, answered_elsewhere, writing, draining };
  struct Entry {
    Guest guest;
    Pace pace;
    bool reserve = false;
    Phase phase = Phase::reading;
    std::uint32_t watched = 0;          ///< events that epoll reports
    std::size_t searched = 0;           ///< of the input, for the end of a head
    std::optional<RequestHead> head{};  ///< read, while its body is coming
    ChunkDecoder chunks{};              ///< of that body
    std::size_t decoded = 0;            ///< bytes of the input, head and chunks
    bool told_to_go_on = false;         ///< that its body may come
    bool ended = false;                 ///< no more input will come
    bool keep = true;                   ///< another request may follow
    std::size_t output = 0;             ///< of output_bytes_
    std::size_t counted = 0;            ///< of input_bytes_
    Time waits_since{};                 ///< writing: since it was written last
    Time drains_until{};
    Time drain_end{};
    std::size_t drained = 0;
  };
  struct Returned {
    Guest guest;
    bool keep;
  };

  void run();
  void accept_all(Time now);
  void welcome(Time now, int socket, std::string address);
  void take_back(Time now);
  void handle(Time now, ConnectionId id);
  void proceed(Time now, ConnectionId id);
  bool receive(Time now, ConnectionId id, Entry& entry);
  bool next_request(Time now, ConnectionId id, Entry& entry);
  static bool read_head(Entry& entry);
  static bool has_come(Entry& entry);
  static bool awaits_body(Entry& entry);
  void dispatch(ConnectionId id, Entry& entry);
  void refuse(Entry& entry, const Problem& problem);
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
  std::atomic<bool> stopped_ = false;
  std::mutex mutex_;  // guards returned_
  std::vector<Returned> returned_;
  // The thread's own.
  Seats seats_;
  std::map<ConnectionId, Entry> entries_;
  ConnectionId next_id_;
  std::size_t input_bytes_ = 0;   ///< of all that are here
  std::size_t output_bytes_ = 0;  ///< in memory, of all that are being sent
  bool listens_ = false;
  std::thread thread_;
};

}  // namespace parray::http

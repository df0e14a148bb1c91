#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "proto/clock.h"

namespace parray::proto {

/// Returns whether an address tcp://HOST:PORT ends in a port from 1 to 65535. ZeroMQ itself takes
/// other texts for another port: 99999 for 34463. Addresses of other kinds have no port, so the
/// result for them is true.
bool has_port(const std::string& address);

/// Chooses among the addresses of a coordinator: the primary and its standbys. It begins with the
/// first address. It leaves a silent address for the next one, and the last for the first. An
/// address is silent if nothing has arrived within a time limit after the first unanswered message.
/// The limit is 5 s, and a tenth of a microsecond more for each byte sent (10 MB/s). The 5 s
/// double each time that all addresses have been silent in turn, up to 80 s.
class AddressList {
 public:
  /// `text` holds addresses separated by commas. Throws InputError if an address is empty, occurs
  /// twice or has no port; see has_port().
  explicit AddressList(const std::string& text);

  [[nodiscard]] const std::vector<std::string>& all() const { return addresses_; }
  [[nodiscard]] const std::string& current() const { return addresses_[current_]; }

  /// Notes that a message of `bytes` bytes was sent, which should be answered.
  void sent(Time now, std::size_t bytes);
  void heard();  ///< notes that a message has arrived
  /// Moves on to the next address if the current one has been silent for too long. Returns false if
  /// it has not, or if there is no other address.
  bool move_on(Time now);

 private:
  std::vector<std::string> addresses_;
  std::size_t current_ = 0;
  std::size_t silent_ = 0;  ///< number of consecutive addresses without an answer
  Time give_up_at_ = never;
};

}  // namespace parray::proto

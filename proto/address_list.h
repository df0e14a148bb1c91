#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "proto/clock.h"

namespace parray::proto {

/// Addresses at which a coordinator may be found, a first one and its standbys: which of them to
/// talk to. The first to begin with; whenever what was sent there has had no answer for 5 s and the
/// time that its bytes take at 10 MB/s, the next one, round and round. A round without a word
/// doubles the patience, up to 80 s, so that an answer that takes long is heard in the end.
class AddressList {
 public:
  /// `text`: addresses with commas between them. Throws InputError where one is empty or comes
  /// twice.
  explicit AddressList(const std::string& text);

  [[nodiscard]] const std::vector<std::string>& all() const { return addresses_; }
  [[nodiscard]] const std::string& current() const { return addresses_[current_]; }

  void sent(Time now, std::size_t bytes);
  void heard();  ///< something has arrived
  /// Moves on to the next address if this one has been silent for too long; false: it has not, or
  /// there is no other.
  bool move_on(Time now);

 private:
  std::vector<std::string> addresses_;
  std::size_t current_ = 0;
  std::size_t silent_ = 0;  ///< addresses, one after the other, without a word
  Time give_up_at_ = never;
};

}  // namespace parray::proto

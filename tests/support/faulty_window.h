#pragma once

#include <algorithm>
#include <functional>
#include <vector>

#include "proto/window.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/turns.h"

namespace parray::test {

/// Faults between a rank and the window. Probabilities are per operation.
struct WindowFaults {
  Time longest_operation{};  ///< other threads may run meanwhile
  double dying = 0;          ///< the rank dies before or after the operation
  double late = 0;           ///< a put arrives after its log entry, perhaps much later
  Time latest{};
  double torn = 0;     ///< a late put arrives in two parts
  double corrupt = 0;  ///< a put has a wrong bit or lacks its end
};

/// Delayed puts.
class Mail {
 public:
  void send(Time arrival, std::size_t offset, std::vector<std::byte> bytes) {
    letters_.push_back({arrival, offset, std::move(bytes)});
  }
  void deliver(Time now, Window& window) {
    std::erase_if(letters_, [&](const Letter& letter) {
      if (letter.arrival <= now) window.put(letter.offset, letter.bytes);
      return letter.arrival <= now;
    });
  }

 private:
  struct Letter {
    Time arrival;
    std::size_t offset;
    std::vector<std::byte> bytes;
  };
  std::vector<Letter> letters_;
};

/// A faulty window of a rank: operations take virtual time, and some fail as networks, memory and
/// machines do.
class FaultyWindow final : public Window {
 public:
  struct Death {};  ///< thrown by the operation at which the rank dies
  struct Tally {
    std::uint64_t deaths = 0;
    std::uint64_t late = 0;
    std::uint64_t torn = 0;
    std::uint64_t corrupt = 0;
  };

  FaultyWindow(Window& window, Turns& turns, Mail& mail, std::size_t rank,
               const WindowFaults& faults, std::uint64_t seed, Tally& tally)
      : window_(window),
        turns_(turns),
        mail_(mail),
        rank_(rank),
        faults_(faults),
        dice_(seed),
        tally_(tally) {}

  std::uint64_t fetch_add(std::size_t word, std::uint64_t delta) override {
    return around([&] { return window_.fetch_add(word, delta); });
  }
  std::uint64_t load(std::size_t word) override {
    return around([&] { return window_.load(word); });
  }
  void store(std::size_t word, std::uint64_t value) override {
    around([&] {
      window_.store(word, value);
      return 0ULL;
    });
  }
  void put(std::size_t offset, std::span<const std::byte> bytes) override {
    around([&] {
      send(offset, {bytes.begin(), bytes.end()});
      return 0ULL;
    });
  }

 private:
  template <typename Operation>
  std::uint64_t around(Operation operation) {
    pass_time();
    const std::uint64_t result = operation();
    pass_time();
    return result;
  }

  void pass_time() {
    if (dice_.unit() < faults_.dying / 2) {
      ++tally_.deaths;
      throw Death();
    }
    turns_.sleep(
        rank_,
        Time(dice_.below(static_cast<std::uint64_t>(faults_.longest_operation.count() / 2 + 1))));
  }

  void send(std::size_t offset, std::vector<std::byte> bytes) {
    if (dice_.unit() < faults_.corrupt) {
      ++tally_.corrupt;
      if (dice_.one_in(4)) {
        bytes.resize(bytes.size() / 16 * 8);
      } else {
        bytes[dice_.below(bytes.size())] ^= static_cast<std::byte>(1U << dice_.below(8));
      }
    }
    if (dice_.unit() >= faults_.late) {
      window_.put(offset, bytes);
      return;
    }
    ++tally_.late;
    if (dice_.unit() < faults_.torn) {
      ++tally_.torn;
      const auto half = static_cast<std::ptrdiff_t>(bytes.size() / 16 * 8);
      mail_.send(arrival(), offset, {bytes.begin(), bytes.begin() + half});
      bytes.erase(bytes.begin(), bytes.begin() + half);
      offset += static_cast<std::size_t>(half);
    }
    mail_.send(arrival(), offset, std::move(bytes));
  }

  Time arrival() {
    return turns_.now() + Time(dice_.below(static_cast<std::uint64_t>(faults_.latest.count() + 1)));
  }

  Window& window_;
  Turns& turns_;
  Mail& mail_;
  std::size_t rank_;
  const WindowFaults faults_;
  Dice dice_;
  Tally& tally_;
};

}  // namespace parray::test

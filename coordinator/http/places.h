#pragma once

#include <condition_variable>
#include <cstddef>
#include <map>
#include <mutex>
#include <string>

#include "coordinator/http/turns.h"

namespace parray::http {

struct PlaceLimits {
  std::size_t places = 2;      ///< that work at once
  std::size_t of_one = 2;      ///< of these, one owner's
  std::size_t inside = 32;     ///< that work or wait
  std::size_t one_inside = 8;  ///< of these, one owner's
};

/// Places to work at, in turns: of those who wait, the next one is of the owner who has the fewest
/// places and has waited longest for a turn. Any thread.
class Places {
 public:
  /// `what`: that is made there, for messages: "pictures".
  Places(std::string what, PlaceLimits limits)
      : what_(std::move(what)), limits_(limits), free_(limits.places), turns_(limits.of_one) {}

  class Place;
  /// A right to wait for a place. Throws Problem 503 when too many have one.
  class Entry {
   public:
    Entry(Places& places, const std::string& owner);
    ~Entry();
    Entry(const Entry&) = delete;
    Entry& operator=(const Entry&) = delete;

   private:
    friend class Place;
    Places& places_;
    const std::string owner_;
  };

  /// A place, once there is one. Throws RunError after stop().
  class Place {
   public:
    explicit Place(const Entry& entry);
    ~Place();
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

   private:
    Places& places_;
    const std::string owner_;
  };

  /// Nobody gets a place any more.
  void stop();
  /// How many wait for one.
  [[nodiscard]] std::size_t waiting();

 private:
  struct Waiter {
    bool has_place = false;
  };
  void give();

  const std::string what_;
  const PlaceLimits limits_;
  std::condition_variable changed_;
  std::mutex mutex_;  // guards all below
  std::size_t free_;
  std::size_t inside_ = 0;
  std::map<std::string, std::size_t> of_owner_;  ///< inside
  Turns<Waiter*> turns_;
  bool stopped_ = false;
};

}  // namespace parray::http

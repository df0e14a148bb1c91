#pragma once

#include <condition_variable>
#include <cstddef>
#include <map>
#include <mutex>
#include <string>

#include "coordinator/http/turns.h"

namespace parray::http {

/// Limits of Places.
struct PlaceLimits {
  std::size_t places = 2;      ///< tasks that run at the same time
  std::size_t of_one = 2;      ///< places of one owner
  std::size_t inside = 32;     ///< Entry objects that exist at the same time
  std::size_t one_inside = 8;  ///< entries of one owner
};

/// Limits how many tasks run at the same time: each task needs one of a fixed number of places. The
/// next free place goes to the owner that has the fewest places and, among owners with equally
/// many, had its last turn longest ago. An owner is the name of a user or an address (owner_of()).
/// Callable from any thread.
class Places {
 public:
  /// `what`: plural of what the tasks make, for messages: "pictures".
  Places(std::string what, PlaceLimits limits)
      : what_(std::move(what)), limits_(limits), free_(limits.places), turns_(limits.of_one) {}

  class Place;
  /// The right to wait for a place, needed to construct a Place. The constructor throws Problem 503
  /// if a limit of entries (PlaceLimits) is reached.
  class Entry {
   public:
    Entry(Places& places, const std::string& owner);
    ~Entry();
    Entry& operator=(Entry&&) = delete;

   private:
    friend class Place;
    Places& places_;
    const std::string owner_;
  };

  /// Occupies a place. The constructor waits for it, and throws RunError after stop().
  class Place {
   public:
    explicit Place(const Entry& entry);
    ~Place();
    Place& operator=(Place&&) = delete;

   private:
    Places& places_;
    const std::string owner_;
  };

  /// Makes all constructors of Place that wait fail, and all later ones.
  void stop();
  /// Returns the number of entries that wait for a place.
  [[nodiscard]] std::size_t waiting();

 private:
  void give();

  const std::string what_;
  const PlaceLimits limits_;
  std::condition_variable changed_;
  std::mutex mutex_;  // guards the fields below
  std::size_t free_;
  std::size_t inside_ = 0;
  std::map<std::string, std::size_t> of_owner_;  ///< entries per owner
  Turns<bool*> turns_;  ///< for each waiting Place, whether it has its place
  bool stopped_ = false;
};

}  // namespace parray::http

#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "common/base/host_port.h"
#include "common/image/image.h"

namespace parray::output {

/// A picture in a window of tev (github.com/Tom94/tev), or of whatever speaks its protocol over
/// TCP, as it grows. A thread of its own does the talking: nobody waits for a viewer that is slow,
/// silent or away. That it is away is said once, on stderr; it is looked for again every few
/// seconds, and gets the newest picture then.
class Display {
 public:
  /// `address`: HOST:PORT, tev's own port is 14158. Throws InputError for anything else.
  explicit Display(const std::string& address);
  /// Throws as the constructor does; empty is no address, and right.
  static void check(const std::string& address);
  /// Breaks off what is under way.
  ~Display();
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;

  /// Shows `image` under `name` as soon as the one before is there; one that still waits is
  /// dropped. Sizes may differ. Returns at once.
  void show(Image image, const std::string& name);
  /// Waits until what was shown last is there, or in vain for `patience`.
  void finish(std::chrono::milliseconds patience);

 private:
  struct Shown {
    Image image;
    std::string name;
  };

  void run(const std::stop_token& stop);

  const HostPort place_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<Shown> waiting_;
  bool idle_ = true;
  std::jthread thread_;  ///< last: it uses what is above
};

}  // namespace parray::output

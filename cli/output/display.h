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

/// Shows a growing picture in a window of tev (github.com/Tom94/tev), or of another viewer with the
/// same protocol over TCP. A thread sends the pictures, so a slow or silent viewer delays nothing.
/// The first time that the viewer does not answer, the thread prints one line on stderr. After each
/// failure it tries again with the next picture, but not within three seconds.
class Display {
 public:
  /// `address` is HOST:PORT with a port above 0. The default port of tev is 14158. Throws
  /// InputError for any other text.
  explicit Display(const std::string& address);
  /// Throws InputError unless `address` is empty or HOST:PORT.
  static void check(const std::string& address);
  /// Aborts the transfer.
  ~Display();
  Display& operator=(Display&&) = delete;

  /// Shows `image` under `name` after the previous picture was sent. Replaces a picture that still
  /// waits. Sizes may differ. Returns at once.
  void show(Image image, const std::string& name);
  /// Waits until the last picture was sent or could not be sent, at most `patience`.
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
  std::jthread thread_;  ///< last member, because the thread uses the members above
};

}  // namespace parray::output

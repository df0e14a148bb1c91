#pragma once

#include <doctest/doctest.h>
#include <spdlog/sinks/null_sink.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "coordinator/loop/coordinator.h"
#include "proto/zmq_link.h"
#include "tests/support/rooms.h"

namespace parray::test {

/// A coordinator over real ZeroMQ, in a separate thread.
class Server {
 public:
  /// `keys` is the same argument as that of ZmqServer.
  explicit Server(CoordinatorOptions options, const std::filesystem::path& keys = {})
      : server_("tcp://127.0.0.1:*", default_max_message_bytes, keys),
        coordinator_(awakening(std::move(options)), nullptr,
                     std::make_shared<spdlog::logger>(
                         "silent", std::make_shared<spdlog::sinks::null_sink_mt>())),
        thread_([this] {
          run_actor(coordinator_, server_.link(), clock_, [this](Time) { return stop_.load(); });
        }) {}
  ~Server() {
    stop_ = true;
    thread_.join();
  }
  Server& operator=(Server&&) = delete;
  [[nodiscard]] const std::string& endpoint() const { return server_.endpoint(); }

 private:
  CoordinatorOptions awakening(CoordinatorOptions options) {
    options.job_thread.wake = [this] { server_.link().wake(); };
    return options;
  }

  ZmqServer server_;
  Coordinator coordinator_;
  SteadyClock clock_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

/// A peer of a Server. The test sends and receives its messages.
class Speaker {
 public:
  explicit Speaker(const Server& server, const std::optional<MemberKey>& key = {})
      : link_(zmq_connect(server.endpoint(), default_max_message_bytes, seconds(1), key)) {}

  void say(const Message& message) { link_->send({}, message); }
  void say_raw(Frames frames) { link_->send({}, std::move(frames)); }

  /// Returns the next message of type M if it arrives in time. Skips other messages.
  template <typename M>
  std::optional<M> hear_within(Time patience) {
    const SteadyClock clock;
    const Time end = clock.now() + patience;
    while (clock.now() < end) {
      if (auto delivery = link_->receive()) {
        Message message = delivery->content.open();
        if (auto* expected = std::get_if<M>(&message)) return std::move(*expected);
      } else {
        link_->wait(milliseconds(20));
      }
    }
    return {};
  }
  /// Does the same. The test fails after 20 s.
  template <typename M>
  M hear() {
    auto heard = hear_within<M>(seconds(20));
    if (!heard) FAIL("waited 20 s for a message");
    return std::move(*heard);
  }

 private:
  std::unique_ptr<Link> link_;
};

}  // namespace parray::test

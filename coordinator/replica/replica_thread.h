#pragma once

#include <atomic>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "coordinator/replica/replicated_store.h"
#include "proto/link.h"

namespace parray::replica {

/// The primary's end of the replica link over any Link, with its own thread. It repeats each
/// request until a reply arrives. It pings the standby every second, even while other threads are
/// busy.
class ReplicaThread final : public ReplicaConnection {
 public:
  ReplicaThread(std::unique_ptr<Link> link, std::string address);
  ~ReplicaThread() override;
  ReplicaThread& operator=(ReplicaThread&&) = delete;

  /// Waits for the reply at most 3 s plus 1 s per 10 MB of the request. If the standby did not
  /// answer the previous call, 0.3 s replace the 3 s, so that the caller can do other work. Throws
  /// what the link has thrown.
  std::optional<ReplicaReply> call(ReplicaRequest request) override;
  [[nodiscard]] bool session_lost() const override { return session_lost_; }
  [[nodiscard]] const std::string& address() const override { return address_; }
  /// Whether the standby has replied that a later generation serves. Thread-safe.
  [[nodiscard]] bool fenced() const { return fenced_; }

 private:
  void run();
  void exchange_messages(Time now);
  void accept_reply(const ReplicaReply& answer);

  const std::unique_ptr<Link> link_;
  const std::string address_;

  std::mutex mutex_;  // guards the members from here to quit_; the atomic ones change under it
  std::condition_variable changed_;
  std::string request_;  ///< request without a reply; empty: none
  Time send_at_{};
  std::optional<ReplicaReply> answer_;
  std::uint64_t number_ = 0;
  ReplicaRequest ping_;  ///< its session is that of the latest call
  std::atomic<bool> session_lost_ = false;
  bool silent_ = false;
  std::atomic<bool> fenced_ = false;
  std::exception_ptr failure_;
  bool quit_ = false;

  Time ping_at_ = never;  ///< used by the thread only
  std::thread thread_;
};

}  // namespace parray::replica

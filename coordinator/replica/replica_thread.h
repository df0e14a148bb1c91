#pragma once

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

/// The primary's end of the replica link over any Link, in a thread of its own: it repeats what is
/// asked until there is an answer, and tells the standby every second that the primary lives,
/// whatever its other threads are at.
class ReplicaThread final : public ReplicaLine {
 public:
  ReplicaThread(std::unique_ptr<Link> link, std::string address);
  ~ReplicaThread() override;
  ReplicaThread(const ReplicaThread&) = delete;
  ReplicaThread& operator=(const ReplicaThread&) = delete;

  /// Waits 3 s, and the time of its bytes at 10 MB/s; as long as the standby has been silent since,
  /// 0.3 s, so that who asks can do other things meanwhile.
  std::optional<ReplicaReply> ask(ReplicaRequest ask) override;
  [[nodiscard]] bool session_lost() const override;
  [[nodiscard]] const std::string& address() const override { return address_; }
  /// A later generation serves: the standby has said so. Any thread.
  [[nodiscard]] bool fenced() const;

 private:
  void lead();
  void work(Time now);
  void take(const ReplicaReply& answer);

  const std::unique_ptr<Link> link_;
  const std::string address_;

  mutable std::mutex mutex_;  // guards the members down to quit_
  std::condition_variable changed_;
  std::string waiting_;  ///< what is asked; empty: nothing
  Time send_at_{};
  std::optional<ReplicaReply> answer_;
  std::uint64_t number_ = 0;
  ReplicaRequest ping_;  ///< of the session that was asked in last
  bool session_lost_ = false;
  bool silent_ = false;
  bool fenced_ = false;
  std::exception_ptr failure_;
  bool quit_ = false;

  Time ping_at_ = never;  ///< the thread's own
  std::thread thread_;
};

}  // namespace parray::replica

#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "coordinator/replica/changes.h"
#include "coordinator/replica/replica_request.h"
#include "coordinator/store/replication_state.h"
#include "coordinator/store/store.h"

namespace parray::replica {

/// The primary's end of the replica link. Tests replace it to lose requests and replies.
class ReplicaConnection {
 public:
  virtual ~ReplicaConnection() = default;

  /// Repeats the request until a reply arrives, for some seconds. Returns nothing without a reply.
  /// Ignores request.number and gives each request a number of its own.
  virtual std::optional<ReplicaReply> call(ReplicaRequest request) = 0;
  /// Whether the standby does not know the session of the latest call.
  [[nodiscard]] virtual bool session_lost() const = 0;
  /// Returns the address of the standby, for messages.
  [[nodiscard]] virtual const std::string& address() const = 0;
};

/// The store of a primary. Its standby has the same content. commit() sends the changes to the
/// standby first, and returns when the standby and `inner` have committed them. A standby at
/// another position (replication_state.h) gets a full copy, in pieces.
///
/// commit() throws StorageFull while the standby does not answer or has no room. It keeps all
/// changes: call it again. It throws RunError when the standby serves in place of this primary, or
/// refuses this primary: this store can commit nothing any more. Call commit() regularly, even
/// without changes, because it gives a returning standby its full copy.
class ReplicatedStore final : public Store {
 public:
  /// `inner` and `connection` must outlive this object. `random` must never return a number twice.
  /// Throws InputError if `inner` is an incomplete copy, and what its commit() throws.
  ReplicatedStore(Store& inner, ReplicaConnection& connection,
                  std::function<std::uint64_t()> random);

  void put_job(const JobRecord& job) override { both(&Store::put_job, &Changes::put_job, job); }
  void put_scene(const std::string& digest, std::string_view bytes) override {
    both(&Store::put_scene, &Changes::put_scene, digest, bytes);
  }
  void append_rows(JobId job, std::string entry) override {
    pending_.append_rows(job, entry);
    inner_.append_rows(job, std::move(entry));
  }
  void drop_rows(JobId job) override { both(&Store::drop_rows, &Changes::drop_rows, job); }
  void keep_rows(JobId job, std::uint64_t entries) override {
    both(&Store::keep_rows, &Changes::keep_rows, job, entries);
  }
  void put_picture(JobId job, std::span<const std::string_view> pieces) override {
    both(&Store::put_picture, &Changes::put_picture, job, pieces);
  }
  void drop_work(JobId job) override { both(&Store::drop_work, &Changes::drop_work, job); }
  void drop_job(JobId job) override { both(&Store::drop_job, &Changes::drop_job, job); }
  void put_note(const std::string& name, const std::string& text) override {
    both(&Store::put_note, &Changes::put_note, name, text);
  }
  void put_mark(const std::string& text) override { inner_.put_mark(text); }
  void put_reached_mark(const std::string& text) override { inner_.put_reached_mark(text); }
  void commit() override;

  Usage usage() override { return inner_.usage(); }
  std::string note(const std::string& name) override { return inner_.note(name); }
  std::map<std::string, std::string> notes() override { return inner_.notes(); }
  std::string mark() override { return inner_.mark(); }
  std::string reached_mark() override { return inner_.reached_mark(); }
  std::vector<JobRecord> jobs() override { return inner_.jobs(); }
  std::optional<std::string> scene(const std::string& digest) override {
    return inner_.scene(digest);
  }
  void each_rows(JobId job, const RowsVisitor& visit) override { inner_.each_rows(job, visit); }
  std::optional<std::string> picture(JobId job) override { return inner_.picture(job); }
  std::uint64_t picture_bytes(JobId job) override { return inner_.picture_bytes(job); }
  void tidy(double keep_lost) override { inner_.tidy(keep_lost); }
  bool restore_picture(JobId job) override;

 private:
  /// Calls a member of the inner store, and then the one of the changes for the standby.
  void both(auto of_store, auto of_changes, const auto&... arguments) {
    (inner_.*of_store)(arguments...);
    (pending_.*of_changes)(arguments...);
  }
  void commit_sent_batch();
  void begin_session();
  void copy_everything(std::uint64_t session);
  void copy_job(const JobRecord& job, Changes& changes);
  void send_if_large(Changes& changes);
  void send_batch(std::string_view batch, bool whole);
  std::string fetch_picture(JobId job);
  ReplicaReply call(ReplicaRequest request);
  [[noreturn]] void throw_unavailable(const std::string& what) const;

  Store& inner_;
  ReplicaConnection& connection_;
  std::function<std::uint64_t()> random_;
  ReplicationState replication_{};
  bool standby_is_ahead_ = false;  ///< the standby has committed a batch that `inner_` has not
  Position position_{};            ///< the latest position that the standby has committed
  Position marked_position_{};     ///< the latest position that was put into `inner_`
  std::uint64_t session_ = 0;      ///< 0: none
  Changes pending_;                ///< changes after `batch_`
  std::string batch_;              ///< the batch being sent; the standby may have it
};

}  // namespace parray::replica

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "coordinator/replica/replica_request.h"
#include "coordinator/store/replication_state.h"
#include "coordinator/store/store.h"

namespace parray::replica {

/// The standby's side of the replica link: answers requests and applies them to its own store.
/// Lost, repeated and reordered messages do no harm. Does no I/O except through the store, and
/// reads no clock. Not thread-safe.
class Replica {
 public:
  /// `store` must outlive this object. `overwrite` (option --overwrite): accept a primary whose
  /// state is older than that of the store, and replace the store's content. Throws InputError if
  /// the store has jobs and was never replicated.
  explicit Replica(Store& store, bool overwrite = false);

  /// Returns the reply to a message of the primary; empty: the message was damaged, send nothing. A
  /// StorageFull of the store becomes a reply. Throws all other errors of the store, and RunError
  /// if the primary has sent changes that cannot be read.
  std::string answer(std::string_view message);

  /// Whether this process has compared the store with its primary, and the store has all batches
  /// (changes of a commit) that the primary has sent.
  [[nodiscard]] bool in_step() const { return in_step_; }
  /// Whether the store has a complete copy, with which a coordinator can serve.
  [[nodiscard]] bool can_serve() const { return replication_ && is_whole(store_, *replication_); }
  /// Whether the store has served without a standby, for example after a takeover. It then accepts
  /// no primary.
  [[nodiscard]] bool has_taken_over() const {
    return replication_ && replication_->role == ReplicaRole::single;
  }

 private:
  ReplicaReply reply(const ReplicaRequest& request);
  std::optional<ReplicaReply> refusal(const ReplicaRequest& request) const;
  ReplicaReply begin_session(const ReplicaRequest& request);
  std::optional<ReplicaReply> refuse_set_back(const ReplicaRequest& request);
  ReplicaReply begin_copy(const ReplicaRequest& request);
  ReplicaReply receive_piece(const ReplicaRequest& request);
  ReplicaReply commit_batch(const ReplicaRequest& request);
  ReplicaReply send_picture_piece(const ReplicaRequest& request);
  void apply();
  [[nodiscard]] bool is_next(const ReplicaRequest& request) const;
  [[nodiscard]] ReplicaReply received() const;

  Store& store_;
  const bool overwrite_;
  std::optional<ReplicationState> replication_;
  std::uint64_t session_ = 0;
  bool awaits_copy_ = false;
  bool in_step_ = false;
  Position position_{};      ///< position in this session; the store has none during a full copy
  std::string batch_;        ///< received bytes of the current batch
  std::size_t applied_ = 0;  ///< bytes of `batch_` that were applied and not committed
  bool applying_ = false;    ///< the store has uncommitted changes
  std::string picture_job_;  ///< number of the job whose picture the primary is fetching
  std::string picture_;      ///< file with that picture
};

/// Returns the reply `fenced` to a request of an old primary, which must then stop serving.
/// `generation`: that of the coordinator that serves now. Empty: the message was damaged.
std::string fenced_answer(std::string_view message, std::uint64_t generation);

}  // namespace parray::replica

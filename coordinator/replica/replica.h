#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "coordinator/replica/replica_request.h"
#include "coordinator/store/replication_state.h"
#include "coordinator/store/store.h"

namespace parray::replica {

/// The standby's side of the replica link: what it is asked, done to its own store. Lost, repeated
/// and reordered messages change nothing: a piece counts at its offset only, a batch once.
///
/// No I/O but the store's, no clock. One thread.
class Replica {
 public:
  /// `store` outlives this. `overwrite`: a primary that was set back may replace batches that only
  /// this store has. Throws InputError when it holds jobs that were never replicated.
  explicit Replica(Store& store, bool overwrite = false);

  /// What to answer; empty: nothing, the message was damaged. Throws RunError when the store does,
  /// but for StorageFull, which is an answer.
  std::string answer(std::string_view message);

  /// The store has been exactly where its primary was, in this life, and has had all since.
  [[nodiscard]] bool in_step() const { return in_step_; }
  /// It has taken over in an earlier life: no primary may fill it.
  [[nodiscard]] bool serves() const {
    return replication_ && replication_->part == ReplicaRole::alone;
  }

 private:
  ReplicaReply reply(const ReplicaRequest& ask);
  std::optional<ReplicaReply> refusal(const ReplicaRequest& ask) const;
  ReplicaReply begin_session(const ReplicaRequest& ask);
  std::optional<ReplicaReply> refuse_set_back(const ReplicaRequest& ask);
  ReplicaReply begin_copy(const ReplicaRequest& ask);
  ReplicaReply take_piece(const ReplicaRequest& ask);
  ReplicaReply take_batch(const ReplicaRequest& ask);
  ReplicaReply picture_piece(const ReplicaRequest& ask);
  void apply();
  [[nodiscard]] bool is_next(const ReplicaRequest& ask) const;
  [[nodiscard]] ReplicaReply have() const { return {0, 0, ReplicaReplyKind::have, batch_.size()}; }

  Store& store_;
  const bool overwrite_;
  std::optional<ReplicationState> replication_;
  std::uint64_t session_ = 0;
  bool awaits_copy_ = false;
  bool in_step_ = false;
  Position position_{};      ///< of this session; of a copy that is not whole in memory only
  std::string batch_;        ///< as far as it is here
  std::size_t applied_ = 0;  ///< bytes of it that the store has, uncommitted
  bool applying_ = false;    ///< the store has some of what is not committed
  std::string lent_job_;     ///< whose picture the primary is fetching
  std::string lent_;         ///< that picture
};

/// What a coordinator that has taken over answers its old primary; empty: nothing.
std::string fenced_answer(std::string_view message, std::uint64_t generation);

}  // namespace parray::replica

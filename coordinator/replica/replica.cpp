#include "coordinator/replica/replica.h"

#include <algorithm>

#include "common/base/checksum.h"
#include "coordinator/replica/changes.h"

namespace parray::replica {

Replica::Replica(Store& store, bool overwrite)
    : store_(store), overwrite_(overwrite), replication_(replication_state_of(store)) {
  if (!replication_ && !store.jobs().empty()) {
    throw InputError(
        "--standby: --state already has jobs, which the copy would delete: use an empty directory");
  }
}

std::string Replica::answer(std::string_view message) {
  ReplicaRequest request;
  try {
    request = decode_request(message);
  } catch (const DecodeError&) {
    return {};  // the primary repeats it
  }
  ReplicaReply answer;
  try {
    answer = reply(request);
  } catch (const StorageFull& full) {
    answer = {0, 0, ReplicaReplyKind::full, 0, full.what()};
  }
  answer.session = request.session;
  answer.number = request.number;
  return encode(answer);
}

ReplicaReply Replica::reply(const ReplicaRequest& request) {
  if (const std::optional<ReplicaReply> no = refusal(request)) return *no;
  if (request.kind == ReplicaRequestKind::begin_session) return begin_session(request);
  if (request.session != session_) return {0, 0, ReplicaReplyKind::unknown_session};
  switch (request.kind) {
    case ReplicaRequestKind::copy: return begin_copy(request);
    case ReplicaRequestKind::piece: return receive_piece(request);
    case ReplicaRequestKind::commit: return commit_batch(request);
    case ReplicaRequestKind::picture: return send_picture_piece(request);
    default: return {};
  }
}

std::optional<ReplicaReply> Replica::refusal(const ReplicaRequest& request) const {
  if (!replication_) return std::nullopt;
  if (request.position.history != replication_->history) {
    return ReplicaReply{0, 0, ReplicaReplyKind::refused, 0,
                        "it has the state of another farm: start it with an empty directory"};
  }
  if (has_taken_over() || request.position.generation < replication_->generation) {
    return ReplicaReply{0, 0, ReplicaReplyKind::fenced, replication_->generation};
  }
  return std::nullopt;
}

ReplicaReply Replica::begin_session(const ReplicaRequest& request) {
  if (request.session == session_) {  // a repeated request
    return {0, 0, awaits_copy_ ? ReplicaReplyKind::behind : ReplicaReplyKind::in_step};
  }
  if (const std::optional<ReplicaReply> no = refuse_set_back(request)) return *no;
  session_ = request.session;
  batch_.clear();
  applied_ = 0;
  const bool same = replication_ && !applying_ &&
                    position_of(store_, *replication_) == request.position && !store_.lacks_files();
  awaits_copy_ = !same;
  in_step_ = same;
  position_ = request.position;
  return {0, 0, same ? ReplicaReplyKind::in_step : ReplicaReplyKind::behind};
}

/// Refuses a primary that has lost commits. The standby may be one batch ahead, because a primary
/// can be killed before it commits a batch that it sent. More batches prove a loss.
std::optional<ReplicaReply> Replica::refuse_set_back(const ReplicaRequest& request) {
  const std::optional<Position> position =
      replication_ && !applying_ ? position_of(store_, *replication_) : std::nullopt;
  if (!position || overwrite_) return std::nullopt;
  std::uint64_t reached =
      request.position.generation == position->generation ? request.position.sequence : 0;
  for (const EarlierGeneration& past : decode_generations(request.bytes)) {
    reached = past.generation == position->generation ? std::max(reached, past.sequence) : reached;
  }
  if (reached >= replication_->copy_begin && reached < replication_->copy_end) {
    reached = replication_->copy_end;
  }
  if (position->sequence <= reached + 1) return std::nullopt;
  return ReplicaReply{
      0, 0, ReplicaReplyKind::refused, 0,
      "the state of the primary is older than that of the standby, and " +
          std::to_string(position->sequence - reached) +
          " batches of changes would be lost: serve the standby's state, or start the standby with "
          "--overwrite"};
}

ReplicaReply Replica::begin_copy(const ReplicaRequest& request) {
  if (!awaits_copy_) return {};  // a repeated request
  applying_ = true;
  for (const JobRecord& job : store_.jobs()) store_.drop_job(job.id);
  for (const auto& [name, text] : store_.notes()) store_.put_note(name, "");
  replication_ = {request.position.history, request.position.generation, ReplicaRole::standby,
                  request.position.sequence, 0};
  put_replication_state(store_, *replication_);
  store_.put_mark("");
  store_.commit();
  applying_ = false;
  awaits_copy_ = false;
  return {};
}

ReplicaReply Replica::received() const { return {0, 0, ReplicaReplyKind::received, batch_.size()}; }

bool Replica::is_next(const ReplicaRequest& request) const {
  return !awaits_copy_ && request.position.sequence == position_.sequence + 1;
}

ReplicaReply Replica::receive_piece(const ReplicaRequest& request) {
  if (is_next(request) && !applying_ && request.offset == batch_.size()) batch_ += request.bytes;
  return received();
}

ReplicaReply Replica::commit_batch(const ReplicaRequest& request) {
  if (request.position.sequence == position_.sequence) return {0, 0, ReplicaReplyKind::committed};
  if (!is_next(request) || request.offset != batch_.size()) return received();
  if (checksum_of(batch_) != request.checksum) {
    batch_.clear();
    return received();
  }
  apply();
  if (request.whole) {
    put_position(store_, request.position);
    if (!in_step_ && replication_ && replication_->copy_end == 0) {
      replication_->copy_end = request.position.sequence;
      put_replication_state(store_, *replication_);
    }
  }
  store_.commit();
  applying_ = false;
  applied_ = 0;
  batch_.clear();
  position_ = request.position;
  in_step_ = request.whole;
  return {0, 0, ReplicaReplyKind::committed};
}

/// Applies the batch. After StorageFull, the next call continues with the change that failed.
void Replica::apply() {
  applying_ = true;
  try {
    while (applied_ < batch_.size()) {
      applied_ += apply_first(std::string_view(batch_).substr(applied_), store_);
    }
  } catch (const DecodeError& error) {
    throw RunError(std::string("the primary sent a batch that cannot be read: ") + error.what());
  }
}

/// Reads the file for the first piece and keeps it in memory until the last one.
ReplicaReply Replica::send_picture_piece(const ReplicaRequest& request) {
  if (picture_job_ != request.bytes || picture_.empty()) {
    picture_job_ = request.bytes;
    try {
      picture_ = store_.picture(std::stoull(picture_job_)).value_or("");
    } catch (const std::exception&) {  // this copy is damaged, too
      picture_.clear();
    }
  }
  if (request.offset >= picture_.size()) {
    picture_.clear();
    return {0, 0, ReplicaReplyKind::no_picture};
  }
  ReplicaReply answer{0, 0, ReplicaReplyKind::picture, picture_.size(),
                      picture_.substr(request.offset, piece_bytes)};
  if (request.offset + answer.text.size() == picture_.size()) picture_ = {};
  return answer;
}

std::string fenced_answer(std::string_view message, std::uint64_t generation) {
  try {
    const ReplicaRequest request = decode_request(message);
    return encode(
        ReplicaReply{request.session, request.number, ReplicaReplyKind::fenced, generation});
  } catch (const DecodeError&) {
    return {};
  }
}

}  // namespace parray::replica

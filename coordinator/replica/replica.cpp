#include "coordinator/replica/replica.h"

#include <algorithm>
#include <utility>

#include "coordinator/replica/changes.h"

namespace parray::replica {

Replica::Replica(Store& store, bool overwrite)
    : store_(store), overwrite_(overwrite), replication_(replication_state_of(store)) {
  if (!replication_ && !store.jobs().empty()) {
    throw InputError(
        "--standby: --state holds jobs of its own, which a copy would replace: name an empty "
        "directory");
  }
}

std::string Replica::answer(std::string_view message) {
  ReplicaRequest ask;
  try {
    ask = decode_request(message);
  } catch (const DecodeError&) {
    return {};  // as if it were lost: it comes again
  }
  ReplicaReply answer;
  try {
    answer = reply(ask);
  } catch (const StorageFull& full) {
    answer = {0, 0, ReplicaReplyKind::full, 0, full.what()};
  }
  answer.session = ask.session;
  answer.number = ask.number;
  return encode(answer);
}

ReplicaReply Replica::reply(const ReplicaRequest& ask) {
  if (const std::optional<ReplicaReply> no = refusal(ask)) {
    return *no;
  }
  if (ask.kind == ReplicaRequestKind::hello) {
    return begin_session(ask);
  }
  if (ask.session != session_) {
    return {0, 0, ReplicaReplyKind::who};
  }
  switch (ask.kind) {
    case ReplicaRequestKind::copy:
      return begin_copy(ask);
    case ReplicaRequestKind::piece:
      return take_piece(ask);
    case ReplicaRequestKind::commit:
      return take_batch(ask);
    case ReplicaRequestKind::picture:
      return picture_piece(ask);
    default:
      return {};
  }
}

std::optional<ReplicaReply> Replica::refusal(const ReplicaRequest& ask) const {
  if (!replication_) {
    return std::nullopt;
  }
  if (ask.position.history != replication_->history) {
    return ReplicaReply{0, 0, ReplicaReplyKind::refused, 0,
                        "it holds the state of another farm: give it an empty directory"};
  }
  if (serves() || ask.position.generation < replication_->generation) {
    return ReplicaReply{0, 0, ReplicaReplyKind::fenced, replication_->generation};
  }
  return std::nullopt;
}

ReplicaReply Replica::begin_session(const ReplicaRequest& ask) {
  if (ask.session == session_) {  // it was repeated
    return {0, 0, awaits_copy_ ? ReplicaReplyKind::behind : ReplicaReplyKind::in_step};
  }
  if (const std::optional<ReplicaReply> no = refuse_set_back(ask)) {
    return *no;
  }
  session_ = ask.session;
  batch_.clear();
  applied_ = 0;
  const bool same = replication_ && !applying_ &&
                    position_of(store_, *replication_) == ask.position && !store_.lacks_files();
  awaits_copy_ = !same;
  in_step_ = same;
  position_ = ask.position;
  return {0, 0, same ? ReplicaReplyKind::in_step : ReplicaReplyKind::behind};
}

/// One batch may be here alone: its primary was killed before it committed the batch. More than one
/// means that the primary has lost what it had.
std::optional<ReplicaReply> Replica::refuse_set_back(const ReplicaRequest& ask) {
  const std::optional<Position> here =
      replication_ && !applying_ ? position_of(store_, *replication_) : std::nullopt;
  if (!here || overwrite_) {
    return std::nullopt;
  }
  std::uint64_t there = ask.position.generation == here->generation ? ask.position.sequence : 0;
  for (const LeftGeneration& left : decode_left(ask.bytes)) {
    there = left.generation == here->generation ? std::max(there, left.sequence) : there;
  }
  if (there >= replication_->copy_begin && there < replication_->copy_end) {
    there = replication_->copy_end;
  }
  if (here->sequence <= there + 1) {
    return std::nullopt;
  }
  return ReplicaReply{
      0, 0, ReplicaReplyKind::refused, 0,
      "the primary has been set back: " + std::to_string(here->sequence - there) +
          " batches would be lost: serve from the standby, or start it with --overwrite"};
}

ReplicaReply Replica::begin_copy(const ReplicaRequest& ask) {
  if (!awaits_copy_) {
    return {};  // it was repeated
  }
  applying_ = true;
  for (const JobRecord& job : store_.jobs()) {
    store_.drop_job(job.id);
  }
  for (const auto& [name, text] : store_.notes()) {
    store_.put_note(name, "");
  }
  replication_ = {ask.position.history, ask.position.generation, ReplicaRole::standby,
                  ask.position.sequence, 0};
  put_replication_state(store_, *replication_);
  store_.put_mark("");
  store_.commit();
  applying_ = false;
  awaits_copy_ = false;
  return {};
}

bool Replica::is_next(const ReplicaRequest& ask) const {
  return !awaits_copy_ && ask.position.sequence == position_.sequence + 1;
}

ReplicaReply Replica::take_piece(const ReplicaRequest& ask) {
  if (is_next(ask) && !applying_ && ask.offset == batch_.size()) {
    batch_ += ask.bytes;
  }
  return have();
}

ReplicaReply Replica::take_batch(const ReplicaRequest& ask) {
  if (ask.position.sequence == position_.sequence) {
    return {0, 0, ReplicaReplyKind::committed};
  }
  if (!is_next(ask) || ask.offset != batch_.size()) {
    return have();
  }
  if (checksum_of(batch_) != ask.checksum) {
    batch_.clear();
    return have();
  }
  apply();
  if (ask.whole) {
    put_position(store_, ask.position);
    if (!in_step_ && replication_ && replication_->copy_end == 0) {
      replication_->copy_end = ask.position.sequence;
      put_replication_state(store_, *replication_);
    }
  }
  store_.commit();
  applying_ = false;
  applied_ = 0;
  batch_.clear();
  position_ = ask.position;
  in_step_ = ask.whole;
  return {0, 0, ReplicaReplyKind::committed};
}

/// Goes on where a full disk has stopped it.
void Replica::apply() {
  applying_ = true;
  try {
    while (applied_ < batch_.size()) {
      applied_ += apply_first(std::string_view(batch_).substr(applied_), store_);
    }
  } catch (const DecodeError& error) {
    throw RunError(std::string("a batch of the primary's cannot be read: ") + error.what());
  }
}

/// The file is read once, for its first piece, and held until its last one.
ReplicaReply Replica::picture_piece(const ReplicaRequest& ask) {
  if (lent_job_ != ask.bytes || lent_.empty()) {
    lent_job_ = ask.bytes;
    try {
      lent_ = store_.picture(std::stoull(lent_job_)).value_or("");
    } catch (const std::exception&) {  // damaged here, too
      lent_.clear();
    }
  }
  if (ask.offset >= lent_.size()) {
    lent_.clear();
    return {0, 0, ReplicaReplyKind::nothing};
  }
  ReplicaReply answer{0, 0, ReplicaReplyKind::picture, lent_.size(),
                      lent_.substr(ask.offset, piece_bytes)};
  if (ask.offset + answer.text.size() == lent_.size()) {
    lent_ = {};
  }
  return answer;
}

std::string fenced_answer(std::string_view message, std::uint64_t generation) {
  try {
    const ReplicaRequest ask = decode_request(message);
    return encode(ReplicaReply{ask.session, ask.number, ReplicaReplyKind::fenced, generation});
  } catch (const DecodeError&) {
    return {};
  }
}

}  // namespace parray::replica

#include "coordinator/replica/replicated_store.h"

#include <utility>

#include "common/base/checksum.h"

namespace parray::replica {

/// Size of the batches of a full copy, in bytes.
static constexpr std::size_t copy_bytes = std::size_t{32} << 20;

ReplicatedStore::ReplicatedStore(Store& inner, ReplicaConnection& connection,
                                 std::function<std::uint64_t()> random)
    : inner_(inner), connection_(connection), random_(std::move(random)) {
  replication_ = replication_state_of(inner_).value_or(
      ReplicationState{random_() | 1, 0, ReplicaRole::single});
  const std::optional<Position> kept = position_of(inner_, replication_);
  if (!is_whole(inner_, replication_)) {
    throw InputError(
        "--replicate-to: --state holds an incomplete copy: start this coordinator with --standby, "
        "so that its primary completes the copy");
  }
  // Resumes at the position of the previous process if the store has it. Otherwise begins a new
  // generation, of which no standby has a batch yet.
  if (replication_.role == ReplicaRole::primary && kept) {
    position_ = marked_position_ = *kept;
    return;
  }
  begin_generation(inner_, replication_, ReplicaRole::primary);
  position_ = {replication_.history, replication_.generation, 0};
  put_position(inner_, position_);
  marked_position_ = position_;
  inner_.commit();  // before any standby receives the generation
}

/// Uses the current session only. A new session could send the standby a full copy, which would
/// delete the standby's picture.
bool ReplicatedStore::restore_picture(JobId job) {
  if (session_ == 0 || connection_.session_lost()) return false;
  try {
    const std::string whole = fetch_picture(job);
    const std::string_view piece = whole;
    if (whole.empty()) return false;
    inner_.put_picture(job, std::span(&piece, 1));
    marked_position_ = {};  // the standby's content stays: the next commit puts the same mark again
    return true;
  } catch (const StorageFull&) {  // the standby did not answer, or `inner_` has no room
    return false;
  }
}

/// Returns the standby's picture of the job; empty: it has no undamaged one.
std::string ReplicatedStore::fetch_picture(JobId job) {
  const std::string name = std::to_string(job);
  std::string whole;
  for (;;) {
    const ReplicaReply answer = call({.kind = ReplicaRequestKind::picture,
                                      .position = position_,
                                      .offset = whole.size(),
                                      .bytes = name});
    if (answer.kind != ReplicaReplyKind::picture || answer.text.empty()) return {};
    whole += answer.text;
    if (whole.size() >= answer.value) return whole;
  }
}

void ReplicatedStore::commit() {
  commit_sent_batch();
  if (session_ == 0 || connection_.session_lost()) begin_session();
  // The standby may have `batch_` already if the reply was lost. So repeat it unchanged.
  while (!batch_.empty() || pending_.size() > 0) {
    commit_sent_batch();
    if (batch_.empty()) batch_ = pending_.take();
    send_batch(batch_, true);
    batch_.clear();
    standby_is_ahead_ = true;
  }
  if (position_ != marked_position_) {
    put_position(inner_, position_);
    marked_position_ = position_;
  }
  inner_.commit();
  standby_is_ahead_ = false;
}

/// Commits the batch that the standby has committed, before the standby gets the next one. So the
/// standby is never more than one batch ahead.
void ReplicatedStore::commit_sent_batch() {
  if (!standby_is_ahead_) return;
  put_reached_position(inner_, position_);  // the commit includes later changes
  inner_.commit();
  standby_is_ahead_ = false;
}

void ReplicatedStore::begin_session() {
  session_ = 0;
  const std::uint64_t session = random_() | 1;
  const std::string generations = encode_generations(replication_, position_);
  const ReplicaReply answer = call({.session = session,
                                    .kind = ReplicaRequestKind::begin_session,
                                    .position = position_,
                                    .bytes = generations});
  if (answer.kind == ReplicaReplyKind::in_step) {
    session_ = session;
  } else {
    copy_everything(session);
    standby_is_ahead_ = true;
  }
}

/// Sends a full copy. It includes uncommitted changes.
void ReplicatedStore::copy_everything(std::uint64_t session) {
  call({.session = session, .kind = ReplicaRequestKind::copy, .position = position_});
  session_ = session;
  try {
    Changes changes;
    for (const auto& [name, text] : inner_.notes()) {
      if (name != replication_note) changes.put_note(name, text);
    }
    for (const JobRecord& job : inner_.jobs()) copy_job(job, changes);
    send_batch(changes.take(), true);
    batch_.clear();  // only now: before, the former standby could have come back to get this batch
    pending_.take();
  } catch (...) {
    session_ = 0;  // the next commit begins a new session
    throw;
  }
}

/// Sends all that can be read of a job. Damaged files of the primary do not stop the copy.
void ReplicatedStore::copy_job(const JobRecord& job, Changes& changes) {
  const auto unless_damaged = [](const auto& copy) {
    try {
      copy();
    } catch (const StorageFull&) {
      throw;
    } catch (const RunError&) {
    }
  };
  changes.put_job(job);
  unless_damaged([&] {
    const auto scene = inner_.scene(job.scene);
    if (scene) changes.put_scene(job.scene, *scene);
  });
  send_if_large(changes);
  unless_damaged([&] {
    inner_.each_rows(job.id, [&](std::string_view entry) {
      changes.append_rows(job.id, entry);
      send_if_large(changes);
    });
  });
  unless_damaged([&] {
    const auto picture = inner_.picture(job.id);
    if (picture) {
      const std::string_view whole = *picture;
      changes.put_picture(job.id, std::span(&whole, 1));
    }
  });
  send_if_large(changes);
}

void ReplicatedStore::send_if_large(Changes& changes) {
  if (changes.size() >= copy_bytes) send_batch(changes.take(), false);
}

void ReplicatedStore::send_batch(std::string_view batch, bool whole) {
  constexpr int most_repeats = 3;  // of a batch that arrived damaged
  ReplicaRequest next;
  next.position = position_;
  ++next.position.sequence;
  for (int repeats = 0; repeats < most_repeats;) {
    const bool complete = next.offset >= batch.size();
    next.kind = complete ? ReplicaRequestKind::commit : ReplicaRequestKind::piece;
    next.whole = whole;
    next.offset = complete ? batch.size() : next.offset;
    next.checksum = complete ? checksum_of(batch) : 0;
    next.bytes = complete ? std::string_view() : batch.substr(next.offset, piece_bytes);
    const ReplicaReply answer = call(next);
    if (answer.kind == ReplicaReplyKind::committed) {
      position_ = next.position;
      return;
    }
    repeats += complete || answer.value <= next.offset ? 1 : 0;
    next.offset = answer.value;
  }
  session_ = 0;
  throw_unavailable("received a batch damaged three times");
}

ReplicaReply ReplicatedStore::call(ReplicaRequest request) {
  request.session = request.session == 0 ? session_ : request.session;
  const std::optional<ReplicaReply> answer = connection_.call(request);
  if (!answer) throw_unavailable("does not answer");
  switch (answer->kind) {
    case ReplicaReplyKind::unknown_session: session_ = 0; throw_unavailable("has restarted");
    case ReplicaReplyKind::full: throw_unavailable("cannot commit a batch (" + answer->text + ")");
    case ReplicaReplyKind::fenced:
      throw RunError("fenced: the standby at " + connection_.address() +
                     " has taken over and serves instead of this primary (generation " +
                     std::to_string(answer->value) + " of the farm's state instead of " +
                     std::to_string(position_.generation) +
                     "): start this coordinator with --standby, and the other one with "
                     "--replicate-to");
    case ReplicaReplyKind::refused:
      throw RunError("the standby at " + connection_.address() +
                     " refuses this primary: " + answer->text);
    default: return *answer;
  }
}

void ReplicatedStore::throw_unavailable(const std::string& what) const {
  throw StorageFull("the standby at " + connection_.address() + " " + what +
                    ": jobs wait until the standby stores the primary's changes again");
}

}  // namespace parray::replica

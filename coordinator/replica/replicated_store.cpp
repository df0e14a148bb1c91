#include "coordinator/replica/replicated_store.h"

#include <set>
#include <utility>

namespace parray::replica {

/// How much of a copy is committed at a time, in bytes.
static constexpr std::size_t copy_bytes = std::size_t{32} << 20;

ReplicatedStore::ReplicatedStore(Store& inner, ReplicaLine& line,
                                 std::function<std::uint64_t()> random)
    : inner_(inner), line_(line), random_(std::move(random)) {
  find_replication_state();
}

/// Goes on where the last life has left off, if that is known; else as a new generation, of which
/// no standby has anything yet.
void ReplicatedStore::find_replication_state() {
  replication_ =
      replication_state_of(inner_).value_or(ReplicationState{random_() | 1, 0, ReplicaRole::alone});
  const std::optional<Position> kept = position_of(inner_, replication_);
  if (!is_whole(inner_, replication_)) {
    throw InputError(
        "--replicate-to: --state holds a copy that is not whole: start it with --standby, and its "
        "primary fills it up");
  }
  if (replication_.part == ReplicaRole::primary && kept) {
    position_ = marked_ = *kept;
    return;
  }
  begin_generation(inner_, replication_, ReplicaRole::primary);
  position_ = {replication_.history, replication_.generation, 0};
  put_position(inner_, position_);
  marked_ = position_;
  inner_.commit();  // before any standby hears of it
}

void ReplicatedStore::put_job(const JobRecord& job) {
  inner_.put_job(job);
  fresh_.put_job(job);
}
void ReplicatedStore::put_scene(const std::string& digest, std::string_view bytes) {
  inner_.put_scene(digest, bytes);
  fresh_.put_scene(digest, bytes);
}
void ReplicatedStore::append_rows(JobId job, std::string entry) {
  fresh_.append_rows(job, entry);
  inner_.append_rows(job, std::move(entry));
}
void ReplicatedStore::drop_rows(JobId job) {
  inner_.drop_rows(job);
  fresh_.drop_rows(job);
}
void ReplicatedStore::keep_rows(JobId job, std::uint64_t entries) {
  inner_.keep_rows(job, entries);
  fresh_.keep_rows(job, entries);
}
void ReplicatedStore::put_picture(JobId job, std::span<const std::string_view> pieces) {
  inner_.put_picture(job, pieces);
  fresh_.put_picture(job, pieces);
}
void ReplicatedStore::drop_work(JobId job) {
  inner_.drop_work(job);
  fresh_.drop_work(job);
}
void ReplicatedStore::drop_job(JobId job) {
  inner_.drop_job(job);
  fresh_.drop_job(job);
}
void ReplicatedStore::put_note(const std::string& name, const std::string& text) {
  inner_.put_note(name, text);
  fresh_.put_note(name, text);
}

/// Asks within the present session only: a new one could give the standby a copy of this store, and
/// so take the picture from it.
bool ReplicatedStore::restore_picture(JobId job) {
  if (session_ == 0 || line_.session_lost()) {
    return false;
  }
  try {
    const std::string whole = fetch_picture(job);
    const std::string_view piece = whole;
    if (whole.empty()) {
      return false;
    }
    inner_.put_picture(job, std::span(&piece, 1));
    marked_ = {};  // the next commit keeps what the standby has: it puts the mark again
    return true;
  } catch (const StorageFull&) {  // no answer, or no room here
    return false;
  }
}

/// Empty: the standby has no undamaged picture of that job.
std::string ReplicatedStore::fetch_picture(JobId job) {
  const std::string name = std::to_string(job);
  std::string whole;
  for (;;) {
    ReplicaRequest next;
    next.kind = ReplicaRequestKind::picture;
    next.position = position_;
    next.offset = whole.size();
    next.bytes = name;
    const ReplicaReply answer = ask(next);
    if (answer.kind != ReplicaReplyKind::picture || answer.text.empty()) {
      return {};
    }
    whole += answer.text;
    if (whole.size() >= answer.value) {
      return whole;
    }
  }
}

void ReplicatedStore::commit() {
  catch_up();
  if (session_ == 0 || line_.session_lost()) {
    begin_session();
  }
  // The standby may have a batch whose answer was lost: it is sent as it was, what came later next.
  while (!batch_.empty() || fresh_.size() > 0) {
    catch_up();
    if (batch_.empty()) {
      batch_ = fresh_.take();
    }
    send_batch(batch_, true);
    batch_.clear();
    behind_ = true;
  }
  if (position_ != marked_) {
    put_position(inner_, position_);
    marked_ = position_;
  }
  inner_.commit();
  behind_ = false;
}

/// Commits at home what the standby has, before it gets more: so it is never more than one batch
/// ahead.
void ReplicatedStore::catch_up() {
  if (!behind_) {
    return;
  }
  put_reached_position(inner_, position_);  // with what came later, which the standby lacks
  inner_.commit();
  behind_ = false;
}

void ReplicatedStore::begin_session() {
  session_ = 0;
  ReplicaRequest hello;
  hello.session = random_() | 1;
  hello.kind = ReplicaRequestKind::hello;
  hello.position = position_;
  const std::string left = encode_left(replication_, position_);
  hello.bytes = left;
  const bool in_step = ask(hello).kind == ReplicaReplyKind::in_step;
  if (in_step) {
    session_ = hello.session;
  } else {
    copy_everything(hello.session);
    behind_ = true;
  }
}

/// What was put and is not committed yet is in the copy, too.
void ReplicatedStore::copy_everything(std::uint64_t session) {
  ReplicaRequest begin;
  begin.session = session;
  begin.kind = ReplicaRequestKind::copy;
  begin.position = position_;
  ask(begin);
  session_ = session;
  try {
    Changes changes;
    for (const auto& [name, text] : inner_.notes()) {
      if (name != replication_note) {
        changes.put_note(name, text);
      }
    }
    for (const JobRecord& job : inner_.jobs()) {
      copy_job(job, changes);
    }
    send_batch(changes.take(), true);
    batch_.clear();  // not before: until now another standby may come back and want it
    fresh_.take();
  } catch (...) {
    session_ = 0;  // it is begun anew
    throw;
  }
}

/// What of a job cannot be read here is no loss of the copy's.
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
    if (scene) {
      changes.put_scene(job.scene, *scene);
    }
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
  if (changes.size() >= copy_bytes) {
    send_batch(changes.take(), false);
  }
}

void ReplicatedStore::send_batch(std::string_view batch, bool whole) {
  constexpr int most_repeats = 3;  // of a batch that was damaged on its way
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
    const ReplicaReply answer = ask(next);
    if (answer.kind == ReplicaReplyKind::committed) {
      position_ = next.position;
      return;
    }
    repeats += complete || answer.value <= next.offset ? 1 : 0;
    next.offset = answer.value;
  }
  session_ = 0;
  fail("takes no batch");
}

ReplicaReply ReplicatedStore::ask(ReplicaRequest ask) {
  ask.session = ask.session == 0 ? session_ : ask.session;
  const std::optional<ReplicaReply> answer = line_.ask(ask);
  if (!answer) {
    fail("does not answer");
  }
  switch (answer->kind) {
    case ReplicaReplyKind::who:
      session_ = 0;
      fail("has started again");
    case ReplicaReplyKind::full:
      fail("cannot keep what it was sent (" + answer->text + ")");
    case ReplicaReplyKind::fenced:
      throw RunError("fenced: the standby at " + line_.address() + " serves as generation " +
                     std::to_string(answer->value) + ", this one was generation " +
                     std::to_string(position_.generation));
    case ReplicaReplyKind::refused:
      throw RunError("the standby at " + line_.address() + " refuses to be one: " + answer->text);
    default:
      return *answer;
  }
}

void ReplicatedStore::fail(const std::string& what) const {
  throw StorageFull("the standby at " + line_.address() + " " + what +
                    ": nothing is acknowledged until it does");
}

}  // namespace parray::replica

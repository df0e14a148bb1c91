#include "coordinator/replica/replica.h"

#include <algorithm>
#include <utility>

#include "coordinator/replica/changes.h"

namespace parray::replica {

Replica::Replica(Store& store, bool overwrite)
    : store_(store), overwrite_(overwrite), lineage_(lineage_of(store)) {
  if (!lineage_ && !store.jobs().empty()) {
    throw InputError(
        "--standby: --state holds jobs of its own, which a copy would replace: name an empty "
        "directory");
  }
}

std::string Replica::answer(std::string_view message) {
  Ask ask;
  try {
    ask = decode_ask(message);
  } catch (const DecodeError&) {
    return {};  // as if it were lost: it comes again
  }
  Answer answer;
  try {
    answer = reply(ask);
  } catch (const StorageFull& full) {
    answer = {0, 0, AnswerKind::full, 0, full.what()};
  }
  answer.session = ask.session;
  answer.number = ask.number;
  return encode(answer);
}

Answer Replica::reply(const Ask& ask) {
  if (const std::optional<Answer> no = refusal(ask)) {
    return *no;
  }
  if (ask.kind == AskKind::hello) {
    return begin_session(ask);
  }
  if (ask.session != session_) {
    return {0, 0, AnswerKind::who};
  }
  switch (ask.kind) {
    case AskKind::copy:
      return begin_copy(ask);
    case AskKind::piece:
      return take_piece(ask);
    case AskKind::commit:
      return take_batch(ask);
    case AskKind::picture:
      return picture_piece(ask);
    default:
      return {};
  }
}

std::optional<Answer> Replica::refusal(const Ask& ask) const {
  if (!lineage_) {
    return std::nullopt;
  }
  if (ask.position.history != lineage_->history) {
    return Answer{0, 0, AnswerKind::refused, 0,
                  "it holds the state of another farm: give it an empty directory"};
  }
  if (serves() || ask.position.generation < lineage_->generation) {
    return Answer{0, 0, AnswerKind::fenced, lineage_->generation};
  }
  return std::nullopt;
}

Answer Replica::begin_session(const Ask& ask) {
  if (ask.session == session_) {  // it was repeated
    return {0, 0, awaits_copy_ ? AnswerKind::behind : AnswerKind::in_step};
  }
  if (const std::optional<Answer> no = refuse_set_back(ask)) {
    return *no;
  }
  session_ = ask.session;
  batch_.clear();
  applied_ = 0;
  const bool same = lineage_ && !applying_ && position_of(store_, *lineage_) == ask.position &&
                    !store_.lacks_files();
  awaits_copy_ = !same;
  in_step_ = same;
  position_ = ask.position;
  return {0, 0, same ? AnswerKind::in_step : AnswerKind::behind};
}

/// One batch may be here alone: its primary was killed before it committed the batch. More than one
/// means that the primary has lost what it had.
std::optional<Answer> Replica::refuse_set_back(const Ask& ask) {
  const std::optional<Position> here =
      lineage_ && !applying_ ? position_of(store_, *lineage_) : std::nullopt;
  if (!here || overwrite_) {
    return std::nullopt;
  }
  std::uint64_t there = ask.position.generation == here->generation ? ask.position.sequence : 0;
  for (const LeftGeneration& left : decode_left(ask.bytes)) {
    there = left.generation == here->generation ? std::max(there, left.sequence) : there;
  }
  if (there >= lineage_->copy_begin && there < lineage_->copy_end) {
    there = lineage_->copy_end;
  }
  if (here->sequence <= there + 1) {
    return std::nullopt;
  }
  return Answer{0, 0, AnswerKind::refused, 0,
                "the primary has been set back: " + std::to_string(here->sequence - there) +
                    " batches would be lost: serve from the standby, or start it with --overwrite"};
}

Answer Replica::begin_copy(const Ask& ask) {
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
  lineage_ = {ask.position.history, ask.position.generation, Part::standby, ask.position.sequence,
              0};
  put_lineage(store_, *lineage_);
  store_.put_mark("");
  store_.commit();
  applying_ = false;
  awaits_copy_ = false;
  return {};
}

bool Replica::is_next(const Ask& ask) const {
  return !awaits_copy_ && ask.position.sequence == position_.sequence + 1;
}

Answer Replica::take_piece(const Ask& ask) {
  if (is_next(ask) && !applying_ && ask.offset == batch_.size()) {
    batch_ += ask.bytes;
  }
  return have();
}

Answer Replica::take_batch(const Ask& ask) {
  if (ask.position.sequence == position_.sequence) {
    return {0, 0, AnswerKind::committed};
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
    if (!in_step_ && lineage_ && lineage_->copy_end == 0) {
      lineage_->copy_end = ask.position.sequence;
      put_lineage(store_, *lineage_);
    }
  }
  store_.commit();
  applying_ = false;
  applied_ = 0;
  batch_.clear();
  position_ = ask.position;
  in_step_ = ask.whole;
  return {0, 0, AnswerKind::committed};
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
Answer Replica::picture_piece(const Ask& ask) {
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
    return {0, 0, AnswerKind::nothing};
  }
  Answer answer{0, 0, AnswerKind::picture, lent_.size(), lent_.substr(ask.offset, piece_bytes)};
  if (ask.offset + answer.text.size() == lent_.size()) {
    lent_ = {};
  }
  return answer;
}

std::string fenced_answer(std::string_view message, std::uint64_t generation) {
  try {
    const Ask ask = decode_ask(message);
    return encode(Answer{ask.session, ask.number, AnswerKind::fenced, generation});
  } catch (const DecodeError&) {
    return {};
  }
}

}  // namespace parray::replica

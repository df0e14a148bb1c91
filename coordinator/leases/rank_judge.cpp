#include "coordinator/leases/rank_judge.h"

#include <algorithm>
#include <utility>

namespace parray::coordinator {

std::vector<RankVoice> rank_voices(const std::vector<std::string>& hosts) {
  std::vector<RankVoice> voices;
  for (std::uint32_t rank = 0; rank < hosts.size(); ++rank) {
    const auto first = std::ranges::find(hosts, hosts[rank]) - hosts.begin();
    voices.push_back({tracer_key("parray-mpi", hosts[rank] + " " + std::to_string(rank)),
                      first == 0 ? rank : static_cast<std::uint32_t>(first)});
  }
  return voices;
}

RankJudge::RankJudge(JobPicture& picture, std::vector<RankVoice> ranks, Hooks hooks)
    : picture_(picture), ranks_(std::move(ranks)), hooks_(std::move(hooks)) {}

bool RankJudge::admit(std::uint32_t rank, const TracedCells& traced,
                      const std::vector<std::uint64_t>& digests) {
  if (!hooks_.trace) return true;
  const std::shared_ptr<const WorkPlan> plan = picture_.plan();
  while (!left_out(rank) && !self_doubt_ && picture_.plan() == plan) {
    const auto differing = picture_.collector().differing(traced.range, digests);
    if (differing.empty()) return true;
    const std::uint64_t cell = differing.front().cell;
    compare_with_rank_0(rank, cell, digests[cell - traced.range.begin]);
  }
  return false;
}

/// Traces a cell in rank 0 and returns its digest.
std::uint64_t RankJudge::digest_by_rank_0(std::uint64_t cell) const {
  return picture_.collector().digests_of(hooks_.trace(picture_.plan()->batch({cell, cell + 1})))[0];
}

/// Finds out whether the rank's claim, the merged bits, or both are wrong.
void RankJudge::compare_with_rank_0(std::uint32_t rank, std::uint64_t cell, std::uint64_t claim) {
  const std::uint64_t truth = digest_by_rank_0(cell);
  const auto wrong = picture_.collector().differing({cell, cell + 1}, {truth});
  if (claim != truth) find_faulty(ranks_[rank].tracer);
  if (!wrong.empty() && !self_doubt_) find_faulty(wrong.front().tracer);
}

void RankJudge::find_faulty(TracerKey tracer) {
  Verdict verdict;
  const auto found = std::ranges::find(ranks_, tracer, &RankVoice::tracer);
  if (found != ranks_.end()) verdict.rank = static_cast<std::uint32_t>(found - ranks_.begin());
  if (verdict.rank && left_out(*verdict.rank)) return;
  if (!verdict.rank) retract(tracer, verdict);
  for (std::uint32_t rank = 0; verdict.rank && rank < ranks_.size(); ++rank) {
    if (ranks_[rank].machine == ranks_[*verdict.rank].machine) {
      left_out_.insert(rank);
      verdict.left_out.push_back(rank);
      retract(ranks_[rank].tracer, verdict);
    }
  }
  self_doubt_ = self_doubt_ || left_out(0);
  verdicts_.push_back(verdict);
  if (hooks_.decided) hooks_.decided(verdict);
}

void RankJudge::retract(TracerKey tracer, Verdict& verdict) {
  const JobPicture::Retraction retraction = picture_.retract(tracer);
  for (const ResultCollector::Unchecked& unchecked : retraction.unchecked) {
    rechecks_.push_back(unchecked.range);
  }
  if (retraction.restarted) {
    verdict.restarted = true;
    rechecks_.clear();
    if (hooks_.restarted) hooks_.restarted();
    return;
  }
  for (const CellRange& range : retraction.cells) verdict.cells += range.count();
  if (!retraction.cells.empty() && hooks_.retracted) hooks_.retracted(retraction.cells);
}

void RankJudge::note_checks(std::uint32_t rank, const std::vector<CellRange>& were_in) {
  for (const CellRange& range : were_in) {
    picture_.collector().note_check(ranks_[rank].tracer, range);
  }
}

void RankJudge::recheck(std::uint64_t most_cells) {
  for (; most_cells > 0 && !rechecks_.empty() && !self_doubt_; --most_cells) {
    CellRange& range = rechecks_.front();
    const std::uint64_t cell = range.begin++;
    if (range.count() == 0) rechecks_.pop_front();
    if (!picture_.collector().has(cell) || picture_.collector().is_checked(cell)) continue;
    const auto wrong = picture_.collector().differing({cell, cell + 1}, {digest_by_rank_0(cell)});
    if (wrong.empty()) {
      picture_.collector().note_check(ranks_[0].tracer, {cell, cell + 1});
    } else {
      find_faulty(wrong.front().tracer);
    }
  }
}

}  // namespace parray::coordinator

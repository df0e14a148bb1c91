#pragma once

#include <algorithm>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/scene/settings_fwd.h"
#include "common/schedule/work_plan.h"
#include "coordinator/disputes/referee.h"
#include "proto/clock.h"

namespace parray::coordinator {

/// A case: cells of a job that the referee traces again, for a dispute or for a check.
struct RefereeCase {
  /// JobWork::generation: a job whose work begins again gets another.
  std::uint64_t generation = 0;
  /// True: two machines returned different bits. False: the case is a check, which may be skipped.
  bool dispute = false;
  /// True: no machine makes this check. If the referee does not make it either, its lease counts as
  /// unchecked.
  bool sole = true;
  std::shared_ptr<const WorkPlan> plan;
  std::string scene;  ///< see Referee::Question
  ScenePayload payload;
  Boxed<RenderSettings> settings;
  std::uint64_t memory = 0;         ///< estimated bytes that the referee needs
  std::uint64_t cells_at_once = 1;  ///< most cells of one question
  /// The machine_key() of the machine whose bits differ from merged cells; 0: a check.
  std::uint64_t claimant = 0;
  std::vector<std::uint64_t> cells;  ///< cells that are not decided yet, ascending
  /// The claimant's digest of each of `cells` (ResultCollector::digests_of()); empty for a check.
  std::vector<std::uint64_t> claims;
};

/// Limits the referee's processor time to a share of one core on average. Unused time accumulates
/// up to `burst` seconds. A question may take more than is left; then the next one waits until the
/// budget has recovered. Not thread-safe. `now` must never decrease.
class RefereeBudget {
 public:
  /// `share`: of a core, above 0. `burst`: seconds at the beginning, and the maximum.
  RefereeBudget(double share, double burst) : share_(share), burst_(burst), left_(burst) {}

  /// Returns the seconds that are left. Negative after a question that took more.
  [[nodiscard]] double left(Time now) const {
    return std::min(burst_, left_ + share_ * to_seconds(now - since_));
  }
  /// Subtracts the processor time of a question, in seconds.
  void spend(Time now, double took) {
    left_ = left(now) - took;
    since_ = now;
  }
  /// Returns when min(`wanted`, `burst`) seconds will be left.
  [[nodiscard]] Time when(Time now, double wanted) const {
    const double lacking = std::min(wanted, burst_) - left(now);
    return lacking <= 0 ? now
                        : now + std::chrono::ceil<milliseconds>(
                                    std::chrono::duration<double>(lacking / share_));
  }
  [[nodiscard]] double burst() const { return burst_; }

 private:
  double share_;
  double burst_;
  double left_;
  Time since_{};
};

/// Asks the referee about cases, one question at a time: disputes before checks, each kind in the
/// order of opening. Keeps to the budget of processor time. Not thread-safe. Never waits for the
/// referee.
class RefereeDesk {
 public:
  struct Options {
    double share = 0.1;                  ///< share of one core that the referee may use on average
    double burst = 30;                   ///< seconds of unused processor time that may accumulate
    std::size_t most_disputes = 64;      ///< most open disputes of one job
    std::size_t most_checks = 64;        ///< most waiting checks of all jobs together
    Time patience = seconds(30);         ///< time after which a job with an open dispute pauses
    Time longest_answer = seconds(180);  ///< for a dispute; then the referee restarts
    Time longest_check = seconds(60);    ///< for a check; then the referee restarts
    Time rest = seconds(60);             ///< idle time after which the referee frees its memory
  };
  /// `referee` may be null: then every job with a dispute pauses.
  RefereeDesk(std::shared_ptr<Referee> referee, Options options);

  /// Opens a case. False, and the case is dropped: there are too many disputes of that job, or too
  /// many checks, or there is no referee for a check.
  bool open(Time now, RefereeCase opened);
  /// Forgets all cases of a job's work.
  void drop(std::uint64_t generation);
  /// Forgets the waiting checks of a job's work. Returns how many leases are unchecked because of
  /// this, or because the referee has failed since the last call.
  std::size_t drop_checks(std::uint64_t generation);
  /// Forgets the disputes whose claimant is this machine.
  void drop_claims(std::uint64_t machine);

  /// Cells of a case that the referee has traced: the answer to one question.
  struct Traced {
    std::uint64_t number = 0;  ///< of the case
    std::uint64_t generation = 0;
    bool dispute = false;
    std::uint64_t claimant = 0;
    CellRange range;
    std::vector<std::uint64_t> claims;  ///< for the range; empty for a check
    CellsPayload cells;                 ///< traced by the referee
  };
  /// Returns new answers. For each, the caller must call close(), ask_again() or continue_case()
  /// with its number.
  std::vector<Traced> take_answers(Time now);
  /// Returns whether ask_next() may have something to do.
  [[nodiscard]] bool may_ask(Time now) const {
    return referee_ && asked_ == 0 && now >= retry_at_ && (memory_ > 0 || !entries_.empty());
  }
  /// Asks the next question if one may be asked. Without one, frees the referee's memory after
  /// Options::rest. `memory_left`: bytes that the referee may use.
  void ask_next(Time now, std::uint64_t memory_left);
  /// Returns the latest time at which take_answers() or ask_next() must be called again.
  [[nodiscard]] Time next(Time now) const;

  /// Ends a case: a machine was found wrong, or the job has ended.
  void close(std::uint64_t number);
  /// Notes that the answer to a case was invalid, for the reason `why`. A dispute is asked again
  /// after a pause; a check is dropped.
  void ask_again(Time now, std::uint64_t number, const std::string& why) {
    fail(now, find(number), why);
  }
  /// Notes that the cells of the last answer are decided. The other cells are asked next. If there
  /// are no others, ends the case.
  void continue_case(std::uint64_t number);

  /// Returns whether there is a referee, and its budget and its last failure permit another check.
  [[nodiscard]] bool may_check(Time now) const;
  /// Returns the number of checks of a job that the referee has not been asked about.
  [[nodiscard]] std::size_t checks(std::uint64_t generation) const;
  /// Returns whether a job has open disputes, or checks that the referee has been asked about.
  [[nodiscard]] bool busy_with(std::uint64_t generation) const;
  /// Returns the number of open disputes of a job, or of all jobs.
  [[nodiscard]] std::size_t disputes(std::uint64_t generation) const;
  [[nodiscard]] std::size_t disputes() const;
  /// Returns why a job must pause until the referee has decided, for people. Empty: it need not
  /// pause.
  [[nodiscard]] std::string hold(Time now, std::uint64_t generation) const;
  /// Returns what the job waits for, for people, if the referee has been tracing for it for some
  /// seconds. Empty: the job does not wait for the referee.
  [[nodiscard]] std::string wait(Time now, std::uint64_t generation) const;
  /// Returns whether no case is open.
  [[nodiscard]] bool idle() const { return entries_.empty(); }
  /// Returns the bytes of memory that the referee uses.
  [[nodiscard]] std::uint64_t memory() const { return memory_; }

 private:
  enum class State : std::uint8_t { waiting, asked, traced };
  struct Entry {
    std::uint64_t number = 0;
    RefereeCase content;
    Time opened{};
    State state = State::waiting;
    CellRange asked;
    std::string trouble;  ///< why the referee could not trace it the last time

    [[nodiscard]] bool waits_as_check() const {
      return !content.dispute && state == State::waiting;
    }
  };
  using Entries = std::list<Entry>;

  [[nodiscard]] std::size_t count(const auto& fits) const {
    return static_cast<std::size_t>(std::ranges::count_if(entries_, fits));
  }
  Entries::iterator find(std::uint64_t number);
  Entries::iterator next_entry(Time now);
  void fail(Time now, Entries::iterator entry, const std::string& why);
  [[nodiscard]] double reserve(const Entry& entry) const;
  [[nodiscard]] Time answer_due() const;

  std::shared_ptr<Referee> referee_;
  const Options options_;
  RefereeBudget budget_;
  Entries entries_;
  std::map<std::uint64_t, std::size_t> failed_;  ///< failed sole checks of each generation
  std::uint64_t next_number_ = 1;
  std::uint64_t asked_ = 0;  ///< number of the case that was asked; 0: none
  Time asked_at_{};
  Time retry_at_{};
  Time retry_pause_{};
  Time answered_at_{};
  std::uint64_t memory_ = 0;
};

}  // namespace parray::coordinator

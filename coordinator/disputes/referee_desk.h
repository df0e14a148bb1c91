#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <string>
#include <vector>

#include "common/scene/settings_fwd.h"
#include "common/schedule/work_plan.h"
#include "coordinator/disputes/referee.h"
#include "coordinator/disputes/referee_budget.h"
#include "proto/clock.h"

namespace parray::coordinator {

/// Cells of a job that the referee traces again.
struct RefereeCase {
  std::uint64_t generation = 0;  ///< of the job's work
  /// Two machines returned different bits. Otherwise the case is a check, which may be left out.
  bool dispute = false;
  std::shared_ptr<const WorkPlan> plan;
  std::string scene;
  SceneParcel parcel;
  Boxed<RenderSettings> settings;
  std::uint64_t memory = 0;           ///< bytes that scene and tree take, as far as is known
  std::uint64_t cells_at_once = 1;    ///< of one question, at most
  std::uint64_t claimant = 0;         ///< machine_key() of whoever contradicts what is merged
  std::vector<std::uint64_t> cells;   ///< not decided yet, ascending
  std::vector<std::uint64_t> claims;  ///< digest of each, by the claimant; empty: of a check
};

/// Puts cases before the referee, one question at a time: disputes before checks, each kind in the
/// order in which they were opened. Keeps the budget. Plain state; one thread. Nothing waits for
/// the referee here.
class RefereeDesk {
 public:
  struct Options {
    double share = 0.1;                  ///< of one core, on average
    double burst = 30;                   ///< seconds of processor time
    std::size_t most_disputes = 64;      ///< open ones of one job
    std::size_t most_checks = 64;        ///< that wait, of all jobs
    Time patience = seconds(30);         ///< after which a job with a dispute is held
    Time longest_answer = seconds(180);  ///< to a dispute; then the referee is started again
    Time longest_check = seconds(60);    ///< for a check; then the referee is started again
    Time rest = seconds(60);             ///< without a question, until it gives its memory back
  };
  /// `referee` may be null: then every job with a dispute is held.
  RefereeDesk(std::shared_ptr<Referee> referee, Options options);

  /// False: there is no room for another dispute of that job, or for another check.
  bool open(Time now, RefereeCase opened);
  /// Forgets the cases of a job's work.
  void drop(std::uint64_t generation);
  /// Forgets its checks that have not been asked yet; returns how many.
  std::size_t drop_checks(std::uint64_t generation);
  /// Forgets disputes that rest on the word of this machine.
  void drop_claims(std::uint64_t machine);

  /// What the referee traced.
  struct Traced {
    std::uint64_t number = 0;  ///< of the case
    std::uint64_t generation = 0;
    bool dispute = false;
    std::uint64_t claimant = 0;
    CellRange range;
    std::vector<std::uint64_t> claims;  ///< for the range; empty: of a check
    CellsParcel cells;
  };
  /// Takes answers in. Each one is settled with close() or go_on().
  std::vector<Traced> take_answers(Time now);
  /// Whether ask_next() has anything to do.
  [[nodiscard]] bool may_ask(Time now) const {
    return referee_ && asked_ == 0 && now >= retry_at_ && (memory_ > 0 || !entries_.empty());
  }
  /// Asks the next question if one may be asked. `memory_left`: bytes that the referee may use.
  void ask_next(Time now, std::uint64_t memory_left);
  /// When either has something to do again, at the latest.
  [[nodiscard]] Time next(Time now) const;

  /// A case is decided.
  void close(std::uint64_t number);
  /// The answer is no good.
  void ask_again(Time now, std::uint64_t number, const std::string& why) {
    fail(now, find(number), why);
  }
  /// Those of its cells that were traced last are decided; the others are asked next.
  void go_on(std::uint64_t number);

  /// Whether there is processor time for a check.
  [[nodiscard]] bool may_check(Time now) const;
  /// Checks of a job that wait.
  [[nodiscard]] std::size_t checks(std::uint64_t generation) const;
  /// Open cases: disputes, and checks that have been asked.
  [[nodiscard]] bool busy_with(std::uint64_t generation) const;
  [[nodiscard]] std::size_t disputes(std::uint64_t generation) const;
  [[nodiscard]] std::size_t disputes() const;
  /// Why a job must get no more leases before the referee has decided; empty: it may.
  [[nodiscard]] std::string hold(Time now, std::uint64_t generation) const;
  /// What a job waits for: the referee, if it has been tracing for the job for some seconds. Empty:
  /// nothing.
  [[nodiscard]] std::string wait(Time now, std::uint64_t generation) const;
  /// No case is open.
  [[nodiscard]] bool idle() const { return entries_.empty(); }
  /// Bytes that the referee holds.
  [[nodiscard]] std::uint64_t memory() const { return memory_; }

 private:
  enum class State : std::uint8_t { waiting, asked, traced };
  struct Entry {
    std::uint64_t number = 0;
    RefereeCase its;
    Time opened{};
    State state = State::waiting;
    CellRange asked;
    std::string trouble;  ///< why it could not be traced the last time
  };
  using Entries = std::list<Entry>;

  Entries::iterator find(std::uint64_t number);
  Entries::iterator next_entry(Time now);
  void fail(Time now, Entries::iterator entry, const std::string& why);
  [[nodiscard]] double reserve(const Entry& entry) const;
  [[nodiscard]] Time answer_due() const;

  std::shared_ptr<Referee> referee_;
  const Options options_;
  RefereeBudget budget_;
  Entries entries_;
  std::uint64_t next_number_ = 1;
  std::uint64_t asked_ = 0;  ///< number of the case under way; 0: none
  Time asked_at_{};
  Time retry_at_{};
  Time retry_pause_{};
  Time answered_at_{};
  std::uint64_t memory_ = 0;
};

}  // namespace parray::coordinator

#include "coordinator/disputes/referee_desk.h"

#include <spdlog/fmt/fmt.h>

#include <chrono>
#include <utility>

namespace parray::coordinator {
namespace {

constexpr Time first_pause = seconds(1);
constexpr Time longest_pause = seconds(60);

/// Share of the burst that checks leave for disputes.
constexpr double reserve_of_checks = 0.5;

/// Returns the first run of adjacent cells, at most `most`.
CellRange first_run(const std::vector<std::uint64_t>& cells, std::uint64_t most) {
  CellRange run{cells.front(), cells.front() + 1};
  for (std::size_t i = 1; i < cells.size() && cells[i] == run.end && run.count() < most; ++i) {
    ++run.end;
  }
  return run;
}

std::string memory_text(std::uint64_t bytes) {
  return fmt::format("{:.3f} GiB", static_cast<double>(bytes) * 0x1p-30);
}

}  // namespace

RefereeDesk::RefereeDesk(std::shared_ptr<Referee> referee, Options options)
    : referee_(std::move(referee)),
      options_(options),
      budget_(options.share, options.burst),
      retry_pause_(first_pause) {}

bool RefereeDesk::open(Time now, RefereeCase opened) {
  if (opened.dispute) {
    if (disputes(opened.generation) >= options_.most_disputes) return false;
  } else {
    const std::size_t checks = count([](const Entry& e) { return e.waits_as_check(); });
    if (!referee_ || checks >= options_.most_checks) return false;
  }
  entries_.push_back({next_number_++, std::move(opened), now, State::waiting, {}, {}});
  return true;
}

RefereeDesk::Entries::iterator RefereeDesk::find(std::uint64_t number) {
  return std::ranges::find(entries_, number, &Entry::number);
}

void RefereeDesk::drop(std::uint64_t generation) {
  std::erase_if(entries_, [&](const Entry& e) { return e.content.generation == generation; });
  failed_.erase(generation);
}

std::size_t RefereeDesk::drop_checks(std::uint64_t generation) {
  const auto failed = failed_.extract(generation);
  std::size_t unchecked = failed ? failed.mapped() : 0;
  std::erase_if(entries_, [&](const Entry& e) {
    const bool waits = e.content.generation == generation && e.waits_as_check();
    unchecked += waits && e.content.sole ? 1 : 0;
    return waits;
  });
  return unchecked;
}

void RefereeDesk::drop_claims(std::uint64_t machine) {
  std::erase_if(entries_,
                [&](const Entry& e) { return e.content.dispute && e.content.claimant == machine; });
}

void RefereeDesk::fail(Time now, Entries::iterator entry, const std::string& why) {
  retry_at_ = now + retry_pause_;
  retry_pause_ = std::min(2 * retry_pause_, longest_pause);
  if (entry == entries_.end()) return;
  if (!entry->content.dispute) {
    if (entry->content.sole) ++failed_[entry->content.generation];
    entries_.erase(entry);
    return;
  }
  entry->state = State::waiting;
  entry->trouble = why;
  entries_.splice(entries_.end(), entries_, entry);  // other cases may succeed
}

std::vector<RefereeDesk::Traced> RefereeDesk::take_answers(Time now) {
  std::vector<Traced> traced;
  if (!referee_) return traced;
  for (Referee::Answer& answer : referee_->take_answers()) {
    budget_.spend(now, answer.seconds);
    memory_ = answer.memory;
    answered_at_ = now;
    if (asked_ == 0 || answer.id != asked_) {
      continue;  // an answer to a cancelled question
    }
    const auto entry = find(std::exchange(asked_, 0));
    if (!answer.failure.empty()) {
      fail(now, entry, answer.failure);
      continue;
    }
    retry_pause_ = first_pause;
    if (entry == entries_.end()) {
      continue;  // the job has ended
    }
    entry->state = State::traced;
    entry->trouble.clear();
    Traced one{entry->number,          entry->content.generation,
               entry->content.dispute, entry->content.claimant,
               entry->asked,           {},
               std::move(answer.cells)};
    const auto first = entry->content.claims.begin();
    if (entry->content.dispute) {
      one.claims.assign(first, first + static_cast<std::ptrdiff_t>(entry->asked.count()));
    }
    traced.push_back(std::move(one));
  }
  if (asked_ != 0 && now >= answer_due()) {
    referee_->forget();
    memory_ = 0;
    const auto silent = std::chrono::duration_cast<std::chrono::seconds>(now - asked_at_);
    fail(now, find(std::exchange(asked_, 0)),
         "it has not answered for " + std::to_string(silent.count()) + " s");
  }
  return traced;
}

/// Returns when the current question has taken too long.
Time RefereeDesk::answer_due() const {
  const auto entry = std::ranges::find(entries_, asked_, &Entry::number);
  const bool check = entry != entries_.end() && !entry->content.dispute;
  return asked_at_ + (check ? options_.longest_check : options_.longest_answer);
}

/// Returns the seconds that must be left in the budget before the case is asked.
double RefereeDesk::reserve(const Entry& entry) const {
  return entry.content.dispute ? 0 : reserve_of_checks * budget_.burst();
}

RefereeDesk::Entries::iterator RefereeDesk::next_entry(Time now) {
  const auto first = [&](bool dispute) {
    return std::ranges::find_if(entries_, [dispute](const Entry& e) {
      return e.content.dispute == dispute && e.state == State::waiting;
    });
  };
  auto entry = first(true);
  entry = entry == entries_.end() ? first(false) : entry;
  const bool may = entry != entries_.end() && budget_.left(now) >= reserve(*entry);
  return may ? entry : entries_.end();
}

void RefereeDesk::ask_next(Time now, std::uint64_t memory_left) {
  if (!referee_ || asked_ != 0 || now < retry_at_) return;
  const auto entry = next_entry(now);
  if (entry == entries_.end()) {
    if (memory_ > 0 && now - answered_at_ >= options_.rest) {
      referee_->forget();
      memory_ = 0;
    }
    return;
  }
  if (entry->content.memory > memory_left) {
    fail(now, entry,
         "the scene needs about " + memory_text(entry->content.memory) +
             " of memory, and the coordinator's --memory leaves " + memory_text(memory_left) +
             ": raise --memory");
    return;
  }
  entry->asked = first_run(entry->content.cells, entry->content.cells_at_once);
  entry->state = State::asked;
  asked_ = entry->number;
  asked_at_ = now;
  memory_ = std::max(memory_, entry->content.memory);
  referee_->ask({entry->number, entry->content.scene, entry->content.payload,
                 entry->content.settings, entry->content.plan->batch(entry->asked), memory_left});
}

Time RefereeDesk::next(Time now) const {
  if (!referee_) return never;
  if (asked_ != 0) return answer_due();
  Time soonest = memory_ > 0 ? answered_at_ + options_.rest : never;
  for (const Entry& entry : entries_) {
    if (entry.state == State::waiting) {
      soonest = std::min(soonest, std::max(retry_at_, budget_.when(now, reserve(entry))));
    }
  }
  return std::max(soonest, now + milliseconds(1));
}

void RefereeDesk::close(std::uint64_t number) {
  std::erase_if(entries_, [number](const Entry& e) { return e.number == number; });
}

void RefereeDesk::continue_case(std::uint64_t number) {
  const auto entry = find(number);
  if (entry == entries_.end()) return;
  const auto decided = static_cast<std::ptrdiff_t>(entry->asked.count());
  RefereeCase& content = entry->content;
  content.cells.erase(content.cells.begin(), content.cells.begin() + decided);
  if (content.dispute) {
    content.claims.erase(content.claims.begin(), content.claims.begin() + decided);
  }
  entry->state = State::waiting;
  if (content.cells.empty()) entries_.erase(entry);
}

bool RefereeDesk::busy_with(std::uint64_t generation) const {
  return std::ranges::any_of(entries_, [&](const Entry& e) {
    return e.content.generation == generation && (e.content.dispute || e.state != State::waiting);
  });
}

bool RefereeDesk::may_check(Time now) const {
  return referee_ && now >= retry_at_ && budget_.left(now) >= reserve_of_checks * budget_.burst();
}

std::size_t RefereeDesk::checks(std::uint64_t generation) const {
  return count(
      [&](const Entry& e) { return e.content.generation == generation && e.waits_as_check(); });
}

std::size_t RefereeDesk::disputes(std::uint64_t generation) const {
  return count(
      [&](const Entry& e) { return e.content.generation == generation && e.content.dispute; });
}

std::size_t RefereeDesk::disputes() const {
  return count([](const Entry& e) { return e.content.dispute; });
}

std::string RefereeDesk::wait(Time now, std::uint64_t generation) const {
  constexpr Time usual = seconds(5);
  const auto entry = std::ranges::find(entries_, asked_, &Entry::number);
  if (entry == entries_.end() || entry->content.generation != generation ||
      now - asked_at_ < usual) {
    return {};
  }
  const auto silent = std::chrono::duration_cast<std::chrono::seconds>(now - asked_at_);
  return std::string("the referee, which has been tracing cells again for a ") +
         (entry->content.dispute ? "dispute" : "check") + " for " + std::to_string(silent.count()) +
         " s";
}

std::string RefereeDesk::hold(Time now, std::uint64_t generation) const {
  const std::string two = "two machines returned different bits for the same samples, and ";
  std::size_t open = 0;
  for (const Entry& entry : entries_) {
    if (entry.content.generation != generation || !entry.content.dispute) continue;
    ++open;
    if (!referee_) return two + "this coordinator has no referee to decide which bits are right";
    if (!entry.trouble.empty()) {
      return two + "the referee cannot trace them again: " + entry.trouble;
    }
    if (now - entry.opened >= options_.patience) return two + "the referee has not decided yet";
  }
  if (open > 0 && budget_.left(now) < 0) {
    return two + "the referee has used up its share of processor time: it will continue later";
  }
  if (open >= options_.most_disputes) {
    return two + "the referee must decide first: " + std::to_string(open) + " disputes are open";
  }
  return {};
}

}  // namespace parray::coordinator

#include "coordinator/loop/farm_watch.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/base/json_text.h"
#include "common/base/printable.h"

namespace parray::coordinator {

using nlohmann::json;

static constexpr std::size_t longest_text = 300;
static constexpr Time left_kept = std::chrono::hours(1);

void FarmWatch::note(FarmEvent event) {
  event.text = printable(event.text, longest_text);
  if (event.frames > 0 && !events_.empty()) {
    const FarmEvent& latest = events_.front();
    if (latest.kind == event.kind && latest.job == event.job) {
      event.frames += latest.frames;
      events_.pop_front();
    }
  }
  events_.push_front(std::move(event));
  if (events_.size() > most_events) events_.pop_back();
}

void FarmWatch::note_left(LeftWorker worker) {
  worker.reason = printable(worker.reason, longest_text);
  left_.push_front(std::move(worker));
  if (left_.size() > most_left) left_.pop_back();
}

void FarmWatch::note_joined(const std::string& name) {
  std::erase_if(left_, [&](const LeftWorker& worker) { return worker.name == name; });
}

void FarmWatch::forget_old(Time now) {
  while (!left_.empty() && now - left_.back().at > left_kept) left_.pop_back();
}

UserAccount& FarmWatch::account(const std::string& user) {
  const auto found = accounts_.find(user);
  if (found != accounts_.end()) return found->second;
  if (accounts_.size() >= most_users) {
    accounts_.erase(std::ranges::min_element(
        accounts_, {}, [](const auto& entry) { return entry.second.thread_seconds; }));
  }
  return accounts_[user];
}

std::string FarmWatch::accounts_text() const {
  json map = json::object();
  for (const auto& [user, account] : accounts_) {
    if (account.thread_seconds > 0) map[user] = std::round(account.thread_seconds * 1e3) / 1e3;
  }
  return json_text(map);
}

void FarmWatch::restore_accounts(std::string_view text) {
  const json map = json::parse(text, nullptr, false);
  if (!map.is_object()) return;
  for (const auto& [user, seconds] : map.items()) {
    const double value = seconds.is_number() ? seconds.get<double>() : 0;
    if (std::isfinite(value) && value > 0) account(user).thread_seconds = value;
  }
}

void FarmWatch::note_gauges(Time now, const Gauges& gauges) {
  const std::int64_t number = RateHistory::number_of(now);
  const std::int64_t passed = number_ < 0 ? 0 : number - number_;
  const auto ended = static_cast<std::size_t>(std::max<std::int64_t>(passed, 0));
  for (std::size_t i = 0; i < std::min(ended, RateHistory::most); ++i) gauges_.push_back(gauges);
  while (gauges_.size() > RateHistory::most) gauges_.pop_front();
  number_ = std::max(number_, number);
}

}  // namespace parray::coordinator

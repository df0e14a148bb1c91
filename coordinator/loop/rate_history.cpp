#include "coordinator/loop/rate_history.h"

#include <algorithm>

namespace parray::coordinator {

void RateHistory::add(Time now, double amount) {
  const std::int64_t number = number_of(now);
  if (number_ < 0) number_ = number;
  const auto passed = static_cast<std::size_t>(std::max<std::int64_t>(number - number_, 0));
  if (passed > 0) {
    earlier_.push_back(static_cast<float>(amount_));
    const std::size_t pause = std::min(passed - 1, most);
    earlier_.insert(earlier_.end(), pause, 0.0F);
  }
  while (earlier_.size() > most) earlier_.pop_front();
  amount_ = passed > 0 ? amount : amount_ + amount;
  number_ = std::max(number_, number);
}

double RateHistory::amount_of(std::int64_t number) const {
  if (number == number_) return amount_;
  const auto back = static_cast<std::size_t>(number_ - number);
  const bool known = number < number_ && back <= earlier_.size();
  return known ? earlier_[earlier_.size() - back] : 0;
}

std::vector<float> RateHistory::before(std::int64_t end, std::size_t count) const {
  std::vector<float> rates;
  for (auto back = static_cast<std::int64_t>(count); back > 0; --back) {
    rates.push_back(static_cast<float>(amount_of(end - back) / to_seconds(interval)));
  }
  return rates;
}

double RateHistory::last_minute(Time now, Time since) const {
  constexpr std::int64_t intervals = 6;
  const std::int64_t present = number_of(now);
  double amount = 0;
  for (std::int64_t number = present - intervals; number <= present; ++number) {
    amount += amount_of(number);
  }
  const Time window = std::min(now - (present - intervals) * interval, now - since);
  return amount / std::max(to_seconds(window), 1.0);
}

}  // namespace parray::coordinator

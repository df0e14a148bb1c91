#include "coordinator/http/budget.h"

#include <utility>

#include "coordinator/http/exchange.h"

namespace parray::http {

Budget::Hold::~Hold() {
  if (budget_ != nullptr) budget_->give_back(bytes_);
}

Budget::Hold::Hold(Hold&& other) noexcept
    : budget_(std::exchange(other.budget_, nullptr)), bytes_(other.bytes_) {}

Budget::Hold Budget::hold(std::uint64_t bytes, Time patience, const std::string& what) {
  std::unique_lock lock(mutex_);
  if (!changed_.wait_for(lock, patience, [&] { return has_room(bytes); })) {
    throw Problem(503, "the server has no room for " + what + " now: try again in a few seconds", 0,
                  {{"Retry-After", "5"}});
  }
  held_ += bytes;
  return {*this, bytes};
}

bool Budget::has_room(std::uint64_t bytes) const { return held_ == 0 || held_ + bytes <= most_; }

void Budget::give_back(std::uint64_t bytes) {
  {
    const std::scoped_lock lock(mutex_);
    held_ -= bytes;
  }
  changed_.notify_all();
}

}  // namespace parray::http

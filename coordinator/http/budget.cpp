#include "coordinator/http/budget.h"

#include "coordinator/http/exchange.h"

namespace parray::http {

Budget::Hold Budget::hold(std::uint64_t bytes, Time patience, const std::string& what) {
  {
    std::unique_lock lock(mutex_);
    const auto has_room = [&] { return held_ == 0 || held_ + bytes <= most_; };
    if (!changed_.wait_for(lock, patience, has_room)) {
      throw Problem(503, "the server has no room for " + what + " now: try again in a few seconds",
                    0, {{"Retry-After", "5"}});
    }
    held_ += bytes;
  }
  return {this, [bytes](Budget* budget) {
            {
              const std::scoped_lock lock(budget->mutex_);
              budget->held_ -= bytes;
            }
            budget->changed_.notify_all();
          }};
}

}  // namespace parray::http

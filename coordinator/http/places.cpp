#include "coordinator/http/places.h"

#include "common/base/error.h"
#include "coordinator/http/exchange.h"

namespace parray::http {

Places::Entry::Entry(Places& places, const std::string& owner) : places_(places), owner_(owner) {
  const std::scoped_lock lock(places_.mutex_);
  const auto mine = places_.of_owner_.find(owner_);
  const std::size_t of_mine = mine == places_.of_owner_.end() ? 0 : mine->second;
  if (places_.inside_ >= places_.limits_.inside || of_mine >= places_.limits_.one_inside) {
    throw Problem(503, "too many " + places_.what_ + " are requested at once: try again in a while",
                  0, {{"Retry-After", "1"}});
  }
  ++places_.inside_;
  ++places_.of_owner_[owner_];
}

Places::Entry::~Entry() {
  const std::scoped_lock lock(places_.mutex_);
  --places_.inside_;
  const auto mine = places_.of_owner_.find(owner_);
  if (--mine->second == 0) places_.of_owner_.erase(mine);
}

Places::Place::Place(const Entry& entry) : places_(entry.places_), owner_(entry.owner_) {
  std::unique_lock lock(places_.mutex_);
  bool has_place = false;
  places_.turns_.push(owner_, &has_place);
  places_.give();
  places_.changed_.wait(lock, [&] { return has_place || places_.stopped_; });
  if (!has_place) throw RunError("the coordinator is stopping");
}

Places::Place::~Place() {
  const std::scoped_lock lock(places_.mutex_);
  ++places_.free_;
  places_.turns_.ended(owner_);
  places_.give();
}

void Places::stop() {
  const std::scoped_lock lock(mutex_);
  stopped_ = true;
  changed_.notify_all();
}

std::size_t Places::waiting() {
  const std::scoped_lock lock(mutex_);
  return turns_.waiting();
}

/// Gives free places to the next owners. The caller holds mutex_.
void Places::give() {
  while (!stopped_ && free_ > 0) {
    const std::optional<bool*> has_place = turns_.take();
    if (!has_place) return;
    --free_;
    **has_place = true;
    changed_.notify_all();
  }
}

}  // namespace parray::http

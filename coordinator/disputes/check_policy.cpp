#include "coordinator/disputes/check_policy.h"

#include <algorithm>

namespace parray::coordinator {

double CheckPolicy::share_of(const CheckedWorker& worker) const {
  if (options_.share <= 0 || (worker.ours && !options_.ours_too)) return 0;
  const bool fresh = worker.machine_leases < options_.first_leases ||
                     worker.process_leases < options_.restart_leases;
  return fresh ? std::max(options_.share, options_.first_share) : options_.share;
}

bool CheckPolicy::wants_check(const CheckedWorker& worker) {
  const double share = share_of(worker);
  return share > 0 && random_() < share;
}

std::optional<std::size_t> CheckPolicy::draw_checker(std::size_t machines) {
  if (machines == 0 || random_() < options_.referee_share) return {};
  return below(machines);
}

std::uint64_t CheckPolicy::below(std::uint64_t count) {
  const auto drawn = static_cast<std::uint64_t>(random_() * static_cast<double>(count));
  return std::min(drawn, count - 1);
}

}  // namespace parray::coordinator

#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "coordinator/store/job_record.h"

namespace parray::coordinator {

/// Estimates when each waiting job begins. It follows the rules of FairQueue as if work were a
/// fluid: users share the farm by their shares; of a user's time, three quarters go to the oldest
/// job of the highest priority and a quarter to the shortest; a job without a lease for long gets
/// one from the lane against starvation.
///
/// Not thread-safe. assign() takes O(n log n) time for n jobs; every other call O(log n).
class QueueOutlook {
 public:
  /// A job or a series that waits for leases or is being traced.
  struct Entry {
    JobId id = 0;  ///< the number under which clients see it
    std::string user;
    double share = 1;  ///< > 0
    std::uint32_t priority = 0;
    bool begun = false;         ///< it has had a lease in this process
    double work_left = 0;       ///< thread-seconds
    bool work_known = true;     ///< false: `work_left` serves only for comparisons
    double until_starving = 0;  ///< seconds until it counts as starving; >= 0
  };
  /// The place of a job that waits.
  struct Place {
    std::uint32_t number = 0;  ///< 1: begins next
    JobId behind = 0;  ///< the user's job that goes first; 0: this job has the user's next turn
    std::uint32_t priority_behind = 0;  ///< priority of the job `behind`
    std::optional<double> starts_in;    ///< seconds; none: unknown
  };

  /// Replaces the jobs. `threads`: threads that trace; 0: nothing begins, and no time is known.
  /// `lease_seconds`: the longest time of a lease.
  void assign(const std::vector<Entry>& jobs, double threads, double lease_seconds);
  /// Returns the place of a job. Null: it has begun, or the latest assign() did not have it.
  [[nodiscard]] const Place* of(JobId id) const;

 private:
  std::map<JobId, Place> places_;
};

}  // namespace parray::coordinator

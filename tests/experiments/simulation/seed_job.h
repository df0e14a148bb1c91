#pragma once

#include <cstdint>
#include <vector>

#include "tests/experiments/simulation/sim_job.h"
#include "tests/support/rooms.h"

namespace parray::simulation {

struct SeedJob {
  double seconds = 0;
  double work = 0;  ///< on one core
  std::uint64_t leases = 0;
  std::vector<double> normalized;  ///< by rank: its time of tracing over the job's
};

/// The same job as the seed program's report describes it: contiguous rows, static (its section
/// 3.4) or guided with a minimum of 2 rows a thread, handed out by a rank more that does nothing
/// else (section 3.5); within a rank a thread takes a row at a time; a rank puts what it has traced
/// and then asks for more. Speeds as in `job`; its stops, start-up, schedule and order do not
/// count.
SeedJob seed_job(const JobOptions& job, SchedulePolicy policy);

}  // namespace parray::simulation

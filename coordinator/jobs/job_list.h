#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "coordinator/jobs/job_index.h"
#include "proto/messages.h"

namespace parray::coordinator {

/// A page of the list of jobs.
struct JobList {
  std::vector<const JobIndex::Frames*> page;  ///< single jobs and series
  /// Number of jobs and series on all pages, also of those that ListJobs::before leaves out. 0 with
  /// JobOrder::newest, which does not count them.
  std::uint64_t total = 0;
};

/// Selects and sorts jobs as `request` says. `now`: of the loop. Takes linear time in the number of
/// jobs, plus the time to sort the jobs up to the end of the page.
JobList list_of(const JobIndex& index, const msg::ListJobs& request, Time now);

/// Returns a job map with shorter texts: `count` such maps fit into one message. `count`: 1 to
/// msg::most_listed.
nlohmann::json short_map(nlohmann::json map, std::size_t count);

}  // namespace parray::coordinator

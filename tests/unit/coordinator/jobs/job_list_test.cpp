#include "coordinator/jobs/job_list.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "tests/support/farm_rig.h"
#include "tests/support/rooms.h"

namespace parray::test {
namespace {

std::vector<JobId> ids_of(const JobList& list) {
  std::vector<JobId> ids;
  for (const JobIndex::Frames* frames : list.page) {
    ids.push_back(frames->begin()->second->record.listed_as());
  }
  return ids;
}

/// Jobs 1 to 4 of two users.
struct ListRig : FarmRig {
  ListRig() {
    named(1, "ann", "Water box", 10);
    named(2, "bob", "glass", 90);
    named(3, "ann", "deep water", 50);
    named(4, "ann", "capsid", 50);
    farm.jobs.at(4).record.state = JobState::paused;
  }
  void named(JobId id, const std::string& user, const std::string& name, std::uint32_t priority) {
    JobRecord& record = add_job(id, user).record;
    record.name = name;
    record.priority = priority;
    record.note(100.0 - static_cast<double>(id), "submitted");
  }
  JobList list(const msg::ListJobs& request) { return list_of(farm.index, request, farm.now); }
};

}  // namespace

TEST_CASE("a request without an order lists the newest jobs, the oldest of them first") {
  ListRig rig;
  msg::ListJobs request;
  request.limit = 2;
  CHECK(ids_of(rig.list(request)) == std::vector<JobId>{3, 4});
  request.before = 3;
  CHECK(ids_of(rig.list(request)) == std::vector<JobId>{1, 2});
}

TEST_CASE("a list is filtered by user, by a part of the name in any case, and by state") {
  ListRig rig;
  msg::ListJobs request;
  request.user = "ann";
  request.name = "WATER";
  CHECK(ids_of(rig.list(request)) == std::vector<JobId>{1, 3});
  request.name = "";
  request.states = "paused,done";
  CHECK(ids_of(rig.list(request)) == std::vector<JobId>{4});
}

TEST_CASE("a list is sorted by any value, with the newest of equal jobs first") {
  ListRig rig;
  msg::ListJobs request;
  request.order = msg::JobOrder::descending;
  request.sort = msg::JobSort::priority;
  CHECK(ids_of(rig.list(request)) == std::vector<JobId>{2, 4, 3, 1});
  request.order = msg::JobOrder::ascending;
  CHECK(ids_of(rig.list(request)) == std::vector<JobId>{1, 4, 3, 2});
  request.sort = msg::JobSort::name;
  CHECK(ids_of(rig.list(request)) == std::vector<JobId>{4, 3, 2, 1});
  request.sort = msg::JobSort::submitted;
  CHECK(ids_of(rig.list(request)) == std::vector<JobId>{4, 3, 2, 1});
  request.sort = msg::JobSort::id;
  CHECK(ids_of(rig.list(request)) == std::vector<JobId>{1, 2, 3, 4});
}

TEST_CASE("an offset selects a page, and the total counts the jobs on all pages") {
  ListRig rig;
  msg::ListJobs request;
  request.order = msg::JobOrder::descending;
  request.limit = 2;
  request.offset = 1;
  CHECK(ids_of(rig.list(request)) == std::vector<JobId>{3, 2});
  CHECK(rig.list(request).total == 4);
  request.offset = 1'000'000;
  CHECK(rig.list(request).page.empty());
  request.before = 3;  // the total does not depend on the page
  CHECK(rig.list(request).total == 4);
}

}  // namespace parray::test

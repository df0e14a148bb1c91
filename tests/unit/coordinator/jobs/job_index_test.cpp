#include "coordinator/jobs/job_index.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <string>

#include "common/scene/settings.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"

namespace parray::test {
namespace {

Job make_job(JobId id, const std::string& user, JobId series = 0, std::uint32_t frame = 0) {
  Job job;
  job.record.id = id;
  job.record.user = user;
  job.record.token = "token-" + std::to_string(id) + "#digest";
  job.record.series_id = series;
  job.record.frame = frame;
  job.record.settings->width = 10;
  job.record.settings->height = 10;
  return job;
}

}  // namespace

TEST_CASE("the index finds a job only by its own user and the name in its token") {
  JobIndex index;
  Job job = make_job(7, "ann");
  index.add(job);
  CHECK(index.by_token("ann", "token-7") == 7);
  CHECK(index.by_token("bob", "token-7") == 0);
  CHECK(index.by_token("ann", "token-8") == 0);
  index.remove(job);
  CHECK(index.by_token("ann", "token-7") == 0);
}

TEST_CASE("the index lists the frames of a series under one number, by frame") {
  JobIndex index;
  Job second = make_job(11, "ann", 10, 2);
  Job first = make_job(12, "ann", 10, 1);
  Job alone = make_job(13, "ann");
  for (Job* job : {&second, &first, &alone}) index.add(*job);
  REQUIRE(index.listed().size() == 2);
  REQUIRE(index.listed_as(10) != nullptr);
  CHECK(series_of(*index.listed_as(10)) == Series{&first, &second});
  CHECK(index.listed_as(11) == nullptr);
  index.remove(first);
  index.remove(second);
  CHECK(index.listed_as(10) == nullptr);
  CHECK(index.listed_as(13)->size() == 1);
}

TEST_CASE("a series counts as one job of its user, with the pixels of its largest frame") {
  JobIndex index;
  Job small = make_job(11, "ann", 10, 1);
  Job large = make_job(12, "ann", 10, 2);
  large.record.settings->width = 20;
  Job alone = make_job(13, "ann");
  for (Job* job : {&small, &large, &alone}) index.add(*job);
  CHECK(index.open_of("ann", 0).jobs == 2);
  CHECK(index.open_of("ann", 0).pixels == 300);
  CHECK(index.open_of("ann", 10).jobs == 1);
  CHECK(index.open_of("ann", 10).pixels == 100);
  CHECK(index.open_pixels("ann", 10) == 200);
  CHECK(index.open_of("bob", 0).jobs == 0);
  index.note_ended(small);
  CHECK(index.open_of("ann", 0).jobs == 2);
  index.note_ended(large);
  CHECK(index.open_of("ann", 0).jobs == 1);
  CHECK(index.open_pixels("ann", 10) == 0);
}

TEST_CASE("an ended job that is queued again is open again; noting it twice changes nothing") {
  JobIndex index;
  Job job = make_job(7, "ann");
  index.add(job);
  index.note_ended(job);
  index.note_ended(job);
  CHECK(index.open().empty());
  index.note_open(job);
  index.note_open(job);
  CHECK(index.open() == std::set<JobId>{7});
  CHECK(index.open_of("ann", 0).jobs == 1);
  CHECK(index.open_of("ann", 0).pixels == 100);
}

TEST_CASE("a job that ended before add() is listed but not open") {
  JobIndex index;
  Job job = make_job(7, "ann");
  job.phase = JobPhase::ended;
  index.add(job);
  CHECK(index.listed_as(7) != nullptr);
  CHECK(index.open().empty());
}

TEST_CASE("after any sequence of changes the index agrees with a search through all jobs") {
  Dice dice(1);
  JobIndex index;
  std::map<JobId, Job> jobs;
  for (JobId step = 1; step <= 2000; ++step) {
    const auto chosen = jobs.lower_bound(dice.below(step) + 1);
    switch (dice.below(4)) {
      case 0:
        if (chosen != jobs.end()) {
          index.remove(chosen->second);
          jobs.erase(chosen);
        }
        break;
      case 1:
        if (chosen != jobs.end()) {
          const bool ended = chosen->second.ended();
          chosen->second.phase = ended ? JobPhase::waiting : JobPhase::ended;
          ended ? index.note_open(chosen->second) : index.note_ended(chosen->second);
        }
        break;
      default:
        const std::string user = dice.below(2) == 0 ? "ann" : "bob";
        const JobId series = dice.below(3) == 0 ? 1'000'000 + (user == "ann" ? 1 : 2) : 0;
        Job& job = jobs.emplace(step, make_job(step, user, series)).first->second;
        job.phase = dice.below(4) == 0 ? JobPhase::ended : JobPhase::waiting;
        index.add(job);
    }
    std::set<JobId> open;
    std::set<JobId> listed;
    std::set<JobId> unfinished;
    std::map<std::string, std::set<JobId>> of_user;
    for (const auto& [id, job] : jobs) {
      listed.insert(job.record.listed_as());
      REQUIRE(index.by_token(job.record.user, "token-" + std::to_string(id)) == id);
      if (!job.ended()) {
        open.insert(id);
        of_user[job.record.user].insert(job.record.listed_as());
        unfinished.insert(job.record.listed_as());
      }
    }
    std::set<JobId> ended;
    std::ranges::set_difference(listed, unfinished, std::inserter(ended, ended.begin()));
    REQUIRE(index.ended() == ended);
    REQUIRE(index.open() == open);
    REQUIRE(index.listed().size() == listed.size());
    for (const std::string user : {"ann", "bob"}) {
      REQUIRE(index.open_of(user, 0).jobs == of_user[user].size());
      REQUIRE(index.open_of(user, 0).pixels == 100 * of_user[user].size());
    }
  }
}

}  // namespace parray::test

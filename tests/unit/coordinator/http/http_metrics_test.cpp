#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "coordinator/http/metrics.h"
#include "coordinator/loop/client_requests.h"
#include "tests/support/farm_rig.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

std::string metrics_of(test::FarmRig& rig) {
  msg::ShowFarm m{1};
  rig.farm.outbox.clear();
  rig.clients.on(rig.farm.now, "client", m);
  return http::metrics_text(rig.sent<msg::Farm>().at(0).farm);
}

bool has_line(const std::string& text, const std::string& line) {
  return text.find("\n" + line + "\n") != std::string::npos;
}

TEST_CASE("names of users are escaped in labels") {
  test::FarmRig rig;
  rig.add_job(1, R"(a"b\c{d}=e,f)");
  CHECK(has_line(metrics_of(rig), R"(parray_user_jobs{user="a\"b\\c{d}=e,f",state="open"} 1)"));
}

TEST_CASE("ended jobs, lost workers and waits are counted from the start") {
  test::FarmRig rig;
  rig.farm.tally.failed_jobs = 3;
  rig.farm.tally.lost = 4;
  rig.farm.tally.queue_seconds = 12.5;
  rig.farm.tally.begun = 2;
  rig.farm.watch.account("ann").thread_seconds = 7;
  const std::string text = metrics_of(rig);
  CHECK(has_line(text, R"(parray_jobs_ended_total{state="failed"} 3)"));
  CHECK(has_line(text, "parray_workers_lost_total 4"));
  CHECK(has_line(text, "parray_queue_seconds_sum 12.5"));
  CHECK(has_line(text, "parray_queue_seconds_count 2"));
  CHECK(has_line(text, R"(parray_user_thread_seconds_total{user="ann"} 7)"));
}

}  // namespace
}  // namespace parray

// The journal of real jobs: every cell is merged once, whatever happens to the farm.
#include "cli/check/audit/audit.h"

#include <doctest/doctest.h>

#include <string>

#include "common/scene/settings.h"
#include "tests/support/crash_store.h"
#include "tests/support/rooms.h"
#include "tests/support/service.h"

namespace parray::test {

TEST_CASE("a job's journal is complete when it is done, with a store and without") {
  CrashStore store(0, 1);
  for (Store* const kept : {static_cast<Store*>(nullptr), static_cast<Store*>(&store)}) {
    Service service(service_options(), kept);
    Hand ann(service, "ann");
    Hand bob(service, "bob");
    const JobId job = service.submit(small_scene(), many_leases());
    for (int i = 0; i < 3; ++i) work(service, {{&ann, honest}, {&bob, honest}}, job, 1);
    const Audit early = audit_of(service, job);
    CHECK(early.problems.empty());
    CHECK(early.merged > 0);
    CHECK_FALSE(early.complete());
    work(service, {{&ann, honest}, {&bob, honest}}, job);
    REQUIRE(service.state(job) == "done");
    const Audit late = audit_of(service, job);
    CHECK(late.complete());
    CHECK(late.workers.size() == 2);
    CHECK(service.sha256(job) == reference_sha256(small_scene(), many_leases()));
  }
}

TEST_CASE("a journal continues after a restart of the coordinator") {
  CrashStore store(0, 1);
  Service service(service_options(), &store);
  Hand ann(service, "ann");
  const JobId job = service.submit(small_scene(), many_leases());
  work(service, {{&ann, honest}}, job, 3);
  service.turn();
  service.restart();
  ann.join();
  work(service, {{&ann, honest}}, job);
  REQUIRE(service.state(job) == "done");
  CHECK(audit_of(service, job).complete());
  CHECK(audit_of(service, job).workers.size() == 2);  // the same name, another process
}

TEST_CASE("the cells of a faulty worker are set back in the journal, and merged again") {
  CoordinatorOptions options = service_options();
  options.checks.share = 1;
  Service service(options);
  Hand ann(service, "ann");
  Hand bob(service, "bob");
  Hand faulty(service, "faulty");
  const JobId job = service.submit(small_scene(), many_leases());
  work(service, {{&ann, honest}, {&bob, honest}, {&faulty, lying}}, job);
  REQUIRE(service.state(job) == "done");
  CHECK(audit_of(service, job).complete());
  CHECK(audit_of(service, job).set_back > 0);
}

TEST_CASE("if a faulty worker spoils a picture in passes, its journal begins again") {
  CoordinatorOptions options = service_options();
  options.checks.share = 1;
  CrashStore store(0, 1);
  Service service(options, &store);
  Hand ann(service, "ann");
  Hand bob(service, "bob");
  Hand faulty(service, "faulty");
  RenderSettings settings = many_leases();
  settings.passes = {4, 8};
  settings.samples_per_pixel = 8;
  const JobId job = service.submit(small_scene(), settings);
  work(service, {{&ann, honest}, {&bob, honest}, {&faulty, lying}}, job);
  REQUIRE(service.state(job) == "done");
  CHECK(audit_of(service, job).complete());
  CHECK(audit_of(service, job).passes == 2);
}

}  // namespace parray::test

// parray-mpi continues from the state of a coordinator.
#include <doctest/doctest.h>

#include <memory>

#include "cli/mpi/checkpointed_job.h"
#include "common/scene/settings.h"
#include "tests/support/rooms.h"
#include "tests/support/service.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {

TEST_CASE("ranks do not continue from the rows of a machine that returned wrong bits") {
  for (const RenderSettings& settings : {many_leases(), in_passes()}) {
    for (const bool found_faulty : {false, true}) {
      CAPTURE(settings.in_passes());
      CAPTURE(found_faulty);
      const TemporaryDirectory directory(in_memory());
      {
        DiskStore store(directory.path());
        Service service(service_options(), &store);
        Hand faulty(service, "faulty");
        const JobId job = service.submit(small_scene(), settings);
        work(service, {{&faulty, lying_loudly}}, job, 4);
        service.steer(job, msg::JobAction::pause);
        service.restart();
        faulty.come_back();
        RenderSettings other = many_leases();
        other.seed = 7;
        service.submit(small_scene(), other);
        service.turn();
        faulty.listen();
        const msg::Grant lease = faulty.put_down();
        found_faulty ? faulty.send_forgery(lease) : faulty.send_honest(lease);
        service.turn();
        CHECK((service.worker("faulty").at("state") == "quarantined") == found_faulty);
        service.turn();
      }
      Submission submission;
      submission.settings = settings;
      submission.scene = std::make_shared<const Scene>(small_scene());
      CheckpointedJob job(submission, 0, directory.path(), true);
      JobRun& resumed = job.run();
      CHECK((resumed.samples_before() > 0) == !found_faulty);
      CHECK(resumed.record().flag.empty() == !found_faulty);
      CHECK(resumed.picture().framebuffer().counts().samples == resumed.samples_before());
    }
  }
}

}  // namespace parray::test

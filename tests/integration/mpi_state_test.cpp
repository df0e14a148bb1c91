// parray-mpi goes on with the state of a coordinator.
#include <doctest/doctest.h>

#include <memory>

#include "cli/mpi/checkpointed_job.h"
#include "common/scene/settings.h"
#include "tests/support/rooms.h"
#include "tests/support/service.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {

TEST_CASE("ranks do not go on from the rows of a machine that returned wrong bits") {
  for (const RenderSettings& settings : {many_leases(), in_passes()}) {
    for (const bool convicted : {false, true}) {
      CAPTURE(settings.in_passes());
      CAPTURE(convicted);
      const TemporaryDirectory directory(in_memory());
      {
        DiskStore store(directory.path());
        Service service(service_options(), &store);
        Hand liar(service, "liar");
        const JobId job = service.submit(small_scene(), settings);
        work(service, {{&liar, lying_loudly}}, job, 4);
        service.steer(job, msg::JobAction::pause);
        service.restart();
        liar.come_back();
        RenderSettings other = many_leases();
        other.seed = 7;
        service.submit(small_scene(), other);
        service.turn();
        liar.listen();
        const msg::Grant lease = liar.put_down();
        convicted ? liar.send_forgery(lease) : liar.send_honest(lease);
        service.turn();
        CHECK((service.worker("liar").at("state") == "quarantined") == convicted);
        service.turn();
      }
      Submission submission;
      submission.settings = settings;
      submission.scene = std::make_shared<const Scene>(small_scene());
      const CheckpointedJob taken_up(submission, 0, directory.path(), true);
      CHECK(taken_up.taken_up() == !convicted);
      CHECK(taken_up.record().flag.empty() == !convicted);
      CHECK(taken_up.picture().framebuffer().counts().samples == taken_up.samples_before());
    }
  }
}

}  // namespace parray::test

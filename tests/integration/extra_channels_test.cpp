#include "cli/output/extra_channels.h"

#include <doctest/doctest.h>

#include <memory>

#include "cli/farm/client.h"
#include "cli/farm/embedded.h"
#include "cli/output/write_outputs.h"
#include "common/scene/scene_bytes.h"
#include "common/scene/settings.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"

/// Extra channels, traced by the process that rendered the picture.
namespace parray {

TEST_CASE("extra channels are traced by the accelerator that rendered the picture") {
  const auto scene = std::make_shared<const Scene>(test::small_scene());
  Submission submission;
  submission.name = "small";
  submission.settings = test::small_settings(*scene);
  submission.scene = scene;
  const std::string id = scene_identity(scene_to_bytes(*scene));
  const RenderSettings settings = submission.settings;
  OutputPaths outputs;
  outputs.aovs = {Aov::depth};
  ExtraChannels extra = extra_channels(outputs, settings, scene, 1);

  EmbeddedFarm farm(1);
  extra.accelerators = farm.accelerators();
  const SteadyClock clock;
  const auto link = farm.connect();
  Client client(*link, clock, {.address = "this process"});
  const JobId job = client.submit(std::move(submission));
  while (!job_status(client.show(job)).ended()) client.rest(milliseconds(1));
  Picture picture = client.fetch(job);
  const auto rendered = farm.accelerators()->find(id, settings);
  REQUIRE(rendered);
  add_channels(picture, extra);
  CHECK(farm.accelerators()->find(id, settings) == rendered);

  Picture alone = client.fetch(job);
  add_channels(alone, extra_channels(outputs, settings, scene, 1));
  CHECK_UNARY(picture.channels == alone.channels);
  CHECK(picture.channels.size() == 1);
}

}  // namespace parray

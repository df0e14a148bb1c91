// Pictures with few pixels and many samples, in virtual time: workers share them as well as others.
#include <doctest/doctest.h>

#include "common/scene/settings.h"
#include "tests/support/rooms.h"
#include "tests/support/sim_farm.h"

namespace parray::test {
namespace {

struct Shape {
  std::uint32_t side;
  std::uint32_t samples;
};

double render_seconds(const Shape& shape, int workers) {
  Faults network;
  network.longest_delay = std::chrono::microseconds(200);
  SimFarm farm(network, 1);
  for (int i = 0; i < workers; ++i) farm.add_worker(5e6);
  RenderSettings settings = small_settings(small_scene());
  settings.width = settings.height = shape.side;
  settings.samples_per_pixel = shape.samples;
  farm.submit(small_scene(), settings);
  REQUIRE(farm.run(seconds(100)));
  return farm.report().at("seconds").at("render");
}

TEST_CASE("one pixel, and 64, with a million samples keep two workers busy") {
  for (const Shape& shape : {Shape{1, 1'000'000}, Shape{8, 15'625}, Shape{100, 100}}) {
    CAPTURE(shape.side);
    const double one = render_seconds(shape, 1);
    const double two = render_seconds(shape, 2);
    CHECK(one / (2 * two) >= 0.95);
  }
}

}  // namespace
}  // namespace parray::test

#include "cli/output/channel_tracing.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

#include "cli/input/scene_file/duplicates.h"
#include "common/base/error.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"
#include "tests/support/message_of.h"
#include "tests/support/precisions.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/tracers.h"

namespace parray::test {
namespace {

const Aovs everything{Aov::depth, Aov::normal, Aov::albedo, Aov::sphere, Aov::cost};
constexpr std::uint32_t sky = 0xFFFFFFFF;
const Material matt{MaterialType::diffuse, {0.5, 0.25, 0.125}, 0, 1};
const Material glass{MaterialType::dielectric, {1, 1, 1}, 0, 1.5};

/// A pinhole at (1, 2, 8) that looks along -z, its picture as wide and as high as `tan_half_vfov`
/// says.
Scene seen_along_z(double tan_half_vfov, std::vector<Sphere> spheres) {
  Scene scene;
  scene.camera.look_from = {1, 2, 8};
  scene.camera.look_at = {1, 2, 5};
  scene.camera.aperture = 0;
  scene.camera.tan_half_vfov = tan_half_vfov;
  scene.materials = {matt, glass};
  scene.spheres = std::move(spheres);
  return scene;
}

RenderSettings settings_of(std::uint32_t side, std::uint32_t spp,
                           Precision precision = Precision::f32) {
  RenderSettings settings;
  settings.width = side;
  settings.height = side;
  settings.samples_per_pixel = spp;
  settings.precision = precision;
  settings.accelerator = AcceleratorKind::bvh;
  return settings;
}

const Channel& named(const Channels& channels, const std::string& name) {
  const auto found = std::find_if(channels.begin(), channels.end(),
                                  [&](const Channel& c) { return c.name == name; });
  REQUIRE(found != channels.end());
  return *found;
}

const std::vector<float>& reals(const Channels& channels, const std::string& name) {
  return std::get<std::vector<float>>(named(channels, name).values);
}

const std::vector<std::uint32_t>& spheres_of(const Channels& channels) {
  return std::get<std::vector<std::uint32_t>>(named(channels, "sphere").values);
}

Channels trace_channels(const Scene& scene, const RenderSettings& settings, const Aovs& wanted,
                        int threads, const std::function<void()>& between_bands = {}) {
  const auto tracer = make_path_tracer(scene, settings, threads);
  return output::trace_channels(*tracer, scene, settings, wanted, threads, between_bands);
}

/// All values are `expected` within `tolerance`.
void check_all(const std::vector<float>& values, double expected, double tolerance = 0) {
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  CHECK(*least >= expected - tolerance);
  CHECK(*most <= expected + tolerance);
}

}  // namespace

TEST_CASE("the middle of a sphere has its distance, the normal towards the eye, its albedo") {
  for (const Precision precision : precisions) {
    CAPTURE(name_of(precision));
    const Scene scene = seen_along_z(1e-4, {{{40, 0, 0}, 1, 0}, {{1, 2, 0}, 3, 0}});
    const Channels channels = trace_channels(scene, settings_of(4, 9, precision), everything, 1);
    check_all(reals(channels, "Z"), 5, 1e-5);
    check_all(reals(channels, "N.X"), 0, 1e-3);
    check_all(reals(channels, "N.Y"), 0, 1e-3);
    check_all(reals(channels, "N.Z"), 1, 1e-5);
    check_all(reals(channels, "albedo.R"), 0.5);
    check_all(reals(channels, "albedo.G"), 0.25);
    check_all(reals(channels, "albedo.B"), 0.125);
    CHECK(spheres_of(channels) == std::vector<std::uint32_t>(16, 1));
  }
}

TEST_CASE("depth is measured along the view, not along the ray, with a lens too") {
  for (const Precision precision : precisions) {
    for (const double aperture : {0.0, 0.5}) {
      CAPTURE(name_of(precision));
      // As good as a wall at z = 3. Along the ray its corners would be sqrt(3) times as far.
      Scene scene = seen_along_z(1, {{{1, 2, 3 - 1e4}, 1e4, 0}});
      scene.camera.aperture = aperture;
      const Channels channels = trace_channels(scene, settings_of(8, 5, precision), everything, 1);
      check_all(reals(channels, "Z"), 5, 0.02);
      check_all(reals(channels, "N.Z"), 1, 1e-5);
    }
  }
}

TEST_CASE("a normal points to the visible side, also inside a sphere") {
  for (const Precision precision : precisions) {
    CAPTURE(name_of(precision));
    const Scene scene = seen_along_z(1e-4, {{{1, 2, 7}, 2, 1}});
    const Channels channels = trace_channels(scene, settings_of(3, 4, precision), everything, 1);
    check_all(reals(channels, "Z"), 3, 1e-5);
    check_all(reals(channels, "N.Z"), 1, 1e-5);
    check_all(reals(channels, "albedo.G"), 1);
    CHECK(spheres_of(channels) == std::vector<std::uint32_t>(9, 0));
  }
}

TEST_CASE("the sky is infinitely far, has no normal, albedo or sphere, and costs one segment") {
  const Scene scene = seen_along_z(0.5, {{{1, 2, 20}, 1, 0}});
  const Channels channels = trace_channels(scene, settings_of(5, 3), everything, 2);
  for (const char* name : {"N.X", "N.Y", "N.Z", "albedo.R", "albedo.G", "albedo.B"}) {
    CAPTURE(name);
    check_all(reals(channels, name), 0);
  }
  check_all(reals(channels, "cost"), 1);
  CHECK(reals(channels, "Z") == std::vector<float>(25, std::numeric_limits<float>::infinity()));
  CHECK(spheres_of(channels) == std::vector<std::uint32_t>(25, sky));
}

TEST_CASE("at an edge depth is the sphere's, and the sky takes its share of normal and albedo") {
  // One pixel; the sphere covers some of it.
  const Scene scene = seen_along_z(0.5, {{{3, 2, 0}, 3, 0}});
  const Channels channels = trace_channels(scene, settings_of(1, 16), everything, 1);
  const float covered = reals(channels, "albedo.R")[0] / 0.5F;
  CHECK(covered > 0.2F);
  CHECK(covered < 0.8F);
  CHECK(covered * 16 == static_cast<float>(static_cast<int>(covered * 16)));
  CHECK(reals(channels, "albedo.B")[0] == covered * 0.125F);
  CHECK(reals(channels, "N.Z")[0] < covered);
  CHECK(reals(channels, "Z")[0] > 5);
  CHECK(reals(channels, "Z")[0] < 8);
}

TEST_CASE("cost is what the picture's own samples take") {
  const Scene scene = small_scene();
  const RenderSettings settings = small_settings(scene);
  const Channels channels = trace_channels(scene, settings, {Aov::cost}, 2);
  double rays = 0;
  for (const float mean : reals(channels, "cost")) {
    rays += static_cast<double>(mean) * settings.samples_per_pixel;
  }
  CHECK(rays == doctest::Approx(static_cast<double>(lane_sums(scene, settings).counts.rays)));
}

TEST_CASE("in a closed room every path has the largest number of segments") {
  RenderSettings settings = settings_of(4, 3);
  settings.max_depth = 7;
  const Scene room = seen_along_z(0.5, {{{1, 2, 7}, 20, 0}});
  check_all(reals(trace_channels(room, settings, {Aov::cost}, 1), "cost"), 7);
}

TEST_CASE("extra channels use the first 16 samples of a pixel, or all if there are fewer") {
  const Scene scene = small_scene();
  RenderSettings settings = small_settings(scene);
  const auto with = [&](std::uint32_t spp) {
    settings.samples_per_pixel = spp;
    return trace_channels(scene, settings, everything, 1);
  };
  const Channels sixteen = with(16);
  CHECK_UNARY(with(1000) == sixteen);
  CHECK_FALSE(with(15) == sixteen);
  CHECK(spheres_of(with(1)) == spheres_of(sixteen));  // of sample 0
}

TEST_CASE(
    "extra channels are the same for every number of threads, accelerator and instruction set") {
  const Scene scene = small_scene();
  RenderSettings settings = small_settings(scene);
  settings.width = 301;  // several pieces a row
  settings.samples_per_pixel = 20;
  for (const Precision precision : precisions) {
    CAPTURE(name_of(precision));
    settings.precision = precision;
    settings.accelerator = AcceleratorKind::bvh;
    settings.isa = Isa::automatic;
    const Channels expected = trace_channels(scene, settings, everything, 1);
    CHECK_UNARY(trace_channels(scene, settings, everything, 2) == expected);
    CHECK_UNARY(trace_channels(scene, settings, everything, 5) == expected);
    settings.isa = Isa::scalar;
    CHECK_UNARY(trace_channels(scene, settings, everything, 2) == expected);
    settings.accelerator = AcceleratorKind::linear;
    CHECK_UNARY(trace_channels(scene, settings, everything, 2) == expected);
    settings.accelerator = AcceleratorKind::octree;
    CHECK_UNARY(trace_channels(scene, settings, everything, 2) == expected);
  }
}

TEST_CASE("only the requested channels exist, and each is independent of the others") {
  const Scene scene = small_scene();
  const RenderSettings settings = small_settings(scene);
  const Channels all = trace_channels(scene, settings, everything, 1);
  std::size_t count = 0;
  for (const Aov aov : everything) {
    for (const Channel& channel : trace_channels(scene, settings, {aov}, 1)) {
      CHECK_UNARY(channel == named(all, channel.name));
      ++count;
    }
  }
  CHECK(count == all.size());
  CHECK(all.size() == 9);
  CHECK(trace_channels(scene, settings, {}, 1).empty());
}

TEST_CASE("a sphere's number is its place in the scene without duplicates") {
  Scene scene = seen_along_z(1e-4, {{{40, 0, 0}, 1, 0}, {{40, 0, 0}, 1, 1}, {{1, 2, 0}, 3, 0}});
  CHECK(spheres_of(trace_channels(scene, settings_of(1, 1), everything, 1))[0] == 2);
  REQUIRE(remove_duplicates(scene).count == 1);
  CHECK(spheres_of(trace_channels(scene, settings_of(1, 1), everything, 1))[0] == 1);
}

TEST_CASE("an exception between two bands ends the tracing") {
  const Scene scene = seen_along_z(0.5, {{{1, 2, 0}, 3, 0}});
  int calls = 0;
  CHECK_THROWS_AS(trace_channels(scene, settings_of(300, 16), {Aov::depth}, 2,
                                 [&] {
                                   if (++calls == 3) throw std::logic_error("enough");
                                 }),
                  std::logic_error);
  CHECK(calls == 3);
}

TEST_CASE("channels are requested by name in any order, and unknown ones are refused") {
  CHECK(aovs_from("depth") == Aovs{Aov::depth});
  CHECK(aovs_from("sphere,depth,sphere") == Aovs{Aov::depth, Aov::sphere});
  CHECK(text_of(aovs_from("cost,sphere,albedo,normal,depth")) == "depth,normal,albedo,sphere,cost");
  const auto refusal = [](const char* names) {
    return message_of<InputError>([&] { aovs_from(names); });
  };
  CHECK(refusal("depth,normls") == "unknown channel 'normls': did you mean 'normal'?");
  for (const char* names : {"", ",", "depth,", " depth", "Z"}) {
    CHECK(refusal(names).starts_with("unknown channel '"));
  }
}

}  // namespace parray::test

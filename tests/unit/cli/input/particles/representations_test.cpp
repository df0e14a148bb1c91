
#include <doctest/doctest.h>

#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

#include "cli/input/particles/selected_particles.h"
#include "cli/input/scene_file/scene_file.h"
#include "cli/input/select/particle_filter.h"
#include "cli/input/view/auto_scene.h"
#include "cli/output/picture/partial_file.h"
#include "common/base/error.h"
#include "tests/support/message_of.h"
#include "tests/support/molecule_files.h"
#include "tests/support/rooms.h"
#include "tests/support/temporary_directory.h"

namespace parray {
namespace {

using test::xs_of;

Particles six() {
  Particles particles;
  for (int i = 0; i < 6; ++i) particles.positions.push_back({static_cast<double>(i), 0, 0});
  return particles;
}

ParticleSource source_showing(const std::vector<std::string>& selections) {
  ParticleSource source;
  for (const std::string& select : selections) source.shows.push_back({select});
  return source;
}

}  // namespace

TEST_CASE("without representations all particles are one part") {
  Particles particles = six();
  const auto parts = split(particles, {});
  REQUIRE(parts.size() == 1);
  CHECK(!parts[0].representation);
  CHECK(parts[0].particles.count() == 6);
  CHECK(particles.facts.notes.empty());
}

TEST_CASE(
    "a particle in several selections belongs to the last, and notes count these and the rest") {
  for (const int threads : {1, 3}) {
    Particles particles = six();
    const auto parts = split(particles, source_showing({"x <= 3", "x = 1 or x = 2"}), threads);
    REQUIRE(parts.size() == 2);
    CHECK(xs_of(parts[0].particles) == std::vector<double>{0, 3});
    CHECK(xs_of(parts[1].particles) == std::vector<double>{1, 2});
    CHECK(parts[1].representation == 1U);
    REQUIRE(particles.facts.notes.size() == 2);
    CHECK(particles.facts.notes[0].key == "shown_twice");
    CHECK(particles.facts.notes[0].count == 2);
    CHECK(particles.facts.notes[1].key == "not_shown");
    CHECK(particles.facts.notes[1].count == 2);
  }
}

TEST_CASE("index in a selection of a representation counts hidden particles") {
  Particles particles = six();
  apply(ParticleFilter{.select = "x != 1", .slice = {}}, particles);
  const auto parts = split(particles, source_showing({"index 2:3", "index 5"}));
  REQUIRE(parts.size() == 2);
  CHECK(xs_of(parts[0].particles) == std::vector<double>{2, 3});
  CHECK(parts[0].numbers == std::vector<std::uint32_t>{1, 2});
  CHECK(xs_of(parts[1].particles) == std::vector<double>{5});
  CHECK(parts[1].particles.index_of(0) == 5);
}

TEST_CASE("a part that later representations hide completely is left out") {
  Particles particles = six();
  const auto parts = split(particles, source_showing({"x = 1", "all"}));
  REQUIRE(parts.size() == 1);
  CHECK(parts[0].representation == 1U);
}

TEST_CASE("a selection without particles is an error of its representation") {
  Particles particles = six();
  try {
    (void)split(particles, source_showing({"all", "x > 9"}));
    FAIL("no error");
  } catch (const SourceError& error) {
    CHECK(error.key() == "select");
    CHECK(error.representation() == 1U);
    CHECK(std::string(error.what()).find("none of 6 particles: ") != std::string::npos);
  }
}

TEST_CASE("a look has the members of the base that it does not give") {
  using Rule = ParticleMaterial::Rule;
  ParticleLook base;
  base.radius = {ParticleRadius::Rule::fixed, 2};
  base.coloring.by = "vx";
  base.coloring.map = ColorMap::magma;
  CHECK(completed({}, base) == base);

  ParticleLook own;
  own.coloring.by = "chain";
  CHECK(completed(own, base).coloring == own.coloring);
  CHECK(completed(own, base).radius == base.radius);

  ParticleLook by_element;
  by_element.material = {Rule::by_element, {}};
  CHECK(completed(by_element, base).coloring.empty());

  base = {};
  base.material = {Rule::by_element, {}};
  base.radius_by = {"mass"};
  CHECK(completed(own, base).material == ParticleMaterial{});
  CHECK(completed(own, base).radius_by == base.radius_by);
  own.radius = {ParticleRadius::Rule::fixed, 1};
  CHECK(completed(own, base).radius_by.empty());
}

TEST_CASE("a scene file with representations has the spheres of the automatic scene") {
  const test::TemporaryDirectory directory;
  const std::string file = (directory.path() / "a.csv").string();
  write_text_file(file, "x,y,z,element,mass\n0,0,0,C,1\n3,0,0,O,2\n6,0,0,H,3\n9,0,0,H,4\n");
  ParticleSource source = source_showing({"all", "element H", "element O"});
  source.look.coloring.by = "x";
  source.shows[1].look.radius_by = {"mass", 0.25, 0.5};
  source.shows[2].look.material = {ParticleMaterial::Rule::by_element, {}};
  source.shows[2].look.radius = {ParticleRadius::Rule::fixed, 2};
  const AutoScene made = auto_scene(file, source, auto_scene_settings());
  const std::size_t first = made.file.scenery;
  REQUIRE(made.file.scene.spheres.size() == first + 4);
  CHECK(made.file.scene.spheres[first + 1].radius == 0.25);
  CHECK(made.file.scene.spheres[first + 2].radius == 0.5);
  CHECK(made.file.scene.spheres[first + 3].radius == 2);
  CHECK(made.file.legends.size() == 3);

  const std::string scene = (directory.path() / "s.json").string();
  std::ostringstream text;
  write_scene(text, with_reference(made, "a.csv"), [] {});
  write_text_file(scene, text.str());
  SceneFile again = read_scene_file(scene);
  expand_particles(again, scene);
  CHECK(again.scene.spheres == made.file.scene.spheres);
  CHECK(again.scene.materials == made.file.scene.materials);
}

TEST_CASE("a scene file with as many representations as options allow can be read again") {
  ParticleSource source;
  source.file = "a.csv";
  Representation show{.select = "all"};
  show.look.style = ParticleStyle::sticks;
  show.look.material = {ParticleMaterial::Rule::named, "gold"};
  show.look.radius_by = {"mass", 1, 2};
  show.look.stick_radius = 0.5;
  show.look.coloring = {"vx", ColorMap::magma, color_range_from("0:1"), NumberScale::log};
  source.shows.assign(max_representations, show);
  SceneFile file;
  file.scene.camera.look_from = {0, 0, 9};
  file.particles = {source};
  std::ostringstream text;
  write_scene(text, file, [] {});
  std::istringstream in(text.str());
  CHECK(read_scene(in, "s.json").particles.at(0).shows.size() == max_representations);
}

}  // namespace parray

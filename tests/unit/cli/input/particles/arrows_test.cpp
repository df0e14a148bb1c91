#include "cli/input/particles/arrows.h"

#include <doctest/doctest.h>

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "cli/input/particles/file_place.h"
#include "cli/input/select/selection.h"
#include "common/base/error.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::message_of;

/// Three particles, 2 apart, with three columns of numbers.
Particles moving(const std::vector<std::string>& names) {
  Particles particles;
  particles.positions = {{0, 0, 0}, {2, 0, 0}, {4, 0, 0}};
  particles.numbers = {
      {names[0], {3, 0, 0}, "angstrom/ps"}, {names[1], {4, 0, 0}, ""}, {names[2], {0, 0, -1}, ""}};
  return particles;
}

}  // namespace

TEST_CASE("the text of arrows names a vector or three columns") {
  CHECK(arrows_from(" Velocity ") == "velocity");
  CHECK(arrows_from("mux,muy,muz") == "mux,muy,muz");
  for (const std::string text : {"", "vx,vy", "vx,vy,", "a,b,c,d"}) {
    CAPTURE(text);
    CHECK(message_of<InputError>([&] { (void)arrows_from(text); }).find("names no vector") !=
          std::string::npos);
  }
}

TEST_CASE("a vector is found by its word, its name or its columns") {
  using Names = std::vector<std::string>;
  const std::vector<std::pair<std::string, Names>> cases{
      {"velocity", {"vx", "vy", "vz"}},  {"velocity", {"velo_x", "velo_y", "velo_z"}},
      {"force", {"fx", "fy", "fz"}},     {"force", {"forces_x", "forces_y", "forces_z"}},
      {"mu", {"mux", "muy", "muz"}},     {"magmom", {"magmom_x", "magmom_y", "magmom_z"}},
      {"spin,b, c", {"spin", "b", "c"}}, {"velocity", {"velocity:0", "velocity:1", "velocity:2"}}};
  for (const auto& row : cases) {
    const std::string& text = row.first;  // Clang 14 does not capture a structured binding
    const Names& names = row.second;
    CAPTURE(text);
    Particles particles = moving(names);
    CHECK(arrows_of(arrows_from(text), 1.0, particles).arrows ==
          std::vector<Vec3d>{{3, 4, 0}, {0, 0, 0}, {0, 0, -1}});
    for (const std::string& name : names) {
      CHECK(numbers_of_arrows(arrows_from(text)).contains(name));
    }
  }
  Particles particles = moving({"vx", "vy", "q"});
  CHECK_THROWS_AS((void)arrows_of("velocity", {}, particles), UnknownNumber);
}

TEST_CASE("without a scale, the longest arrow is twice as long as the distance of neighbours") {
  Particles particles = moving({"vx", "vy", "vz"});
  const ParticleArrows arrows = arrows_of("velocity", {}, particles);
  CHECK(length(arrows.arrows[0]) == doctest::Approx(4));
  CHECK(length(arrows.arrows[2]) == doctest::Approx(0.8));
  CHECK(arrows_of("velocity", 0.5, particles).arrows[0] == Vec3d{1.5, 2, 0});
}

TEST_CASE("the legend says the value of the longest arrow with its unit") {
  Particles particles = moving({"vx", "vy", "vz"});
  const Legend legend = arrows_of("velocity", 0.5, particles).legend;
  CHECK(legend.title == "velocity");
  REQUIRE(legend.entries.size() == 1);
  CHECK(legend.entries[0].name == "longest = 5 \u00c5/ps");
  CHECK(legend.entries[0].arrow);
  CHECK(legends_text({legend}) ==
        R"([{"title":"velocity","entries":[{"name":"longest = 5 Å/ps","arrow":true}]}])");
}

TEST_CASE("particles without a known vector have no arrow, and a note counts them") {
  Particles particles = moving({"vx", "vy", "vz"});
  particles.numbers[1].values[0] = std::numeric_limits<double>::quiet_NaN();
  const ParticleArrows arrows = arrows_of("velocity", 1.0, particles);
  CHECK(arrows.arrows[0] == Vec3d{});
  REQUIRE(particles.facts.notes.size() == 1);
  CHECK(particles.facts.notes[0].key == "unknown_vectors");
  CHECK(particles.facts.notes[0].count == 1);
  for (NumberColumn& column : particles.numbers) column.values.assign(3, 0);
  CHECK(arrows_of("velocity", {}, particles).legend.empty());
}

TEST_CASE("a particle without neighbours needs a scale, and too long arrows are refused") {
  Particles one;
  one.positions = {{0, 0, 0}};
  one.numbers = {{"vx", {1e10}, ""}, {"vy", {0}, ""}, {"vz", {0}, ""}};
  CHECK(message_of<SourceError>([&] {
          (void)arrows_of("velocity", {}, one);
        }).find("have no neighbours") != std::string::npos);
  CHECK(arrows_of("velocity", 1e-10, one).width > 0);
  CHECK(message_of<SourceError>([&] {
          (void)arrows_of("velocity", 1e9, one);
        }).find("use a smaller scale") != std::string::npos);
}

TEST_CASE("an arrow is a shaft and balls that shrink towards the tip, inside its length") {
  std::vector<Capsule> capsules;
  append_arrow({1, 0, 0}, {10, 0, 0}, 0.1, 7, capsules);
  REQUIRE(capsules.size() == capsules_of_arrow);
  CHECK(capsules[0].from == Vec3d{1, 0, 0});
  CHECK(capsules[0].radius == 0.1);
  CHECK(capsules[1].radius > 2 * capsules[0].radius);
  for (std::size_t i = 1; i < capsules.size(); ++i) {
    CHECK(capsules[i].from == capsules[i].to);
    CHECK(capsules[i].to.x + capsules[i].radius < 11);
    CHECK(capsules[i].material == 7);
    if (i > 1) {
      CHECK(capsules[i].radius < capsules[i - 1].radius);
      CHECK(capsules[i].from.x > capsules[i - 1].from.x);
    }
  }
  CHECK(capsules.back().to.x > 10.8);
}

TEST_CASE("short arrows are thinner, and an arrow of length 0 is not drawn") {
  std::vector<Capsule> capsules;
  append_arrow({0, 0, 0}, {0, 0.1, 0}, 0.1, 0, capsules);
  REQUIRE(!capsules.empty());
  CHECK(capsules[0].radius < 0.01);
  CHECK(capsules[0].to.y > 0);
  capsules.clear();
  append_arrow({0, 0, 0}, {0, 0, 0}, 0.1, 0, capsules);
  CHECK(capsules.empty());
}

}  // namespace parray

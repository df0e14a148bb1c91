// What the colours of particles mean, as data: from particles to text.
#include "cli/input/color/legend.h"

#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "cli/input/particles/elements.h"
#include "cli/input/particles/particle_spheres.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using nlohmann::json;

LegendEntry entry(const char* name, double red, std::uint64_t count) {
  return {name, {red, 0, 0}, count};
}

}  // namespace

TEST_CASE(
    "a legend by element lists the elements of the particles by atomic number, unknown ones last") {
  Particles particles;
  particles.positions.resize(5);
  particles.elements = {8, 1, 0, 1, 1};
  const Legend legend = legend_of(particles, {ParticleMaterial::Rule::by_element, {}}, {});
  CHECK(legend.title == "element");
  REQUIRE(legend.entries.size() == 3);
  CHECK(legend.entries[0] == LegendEntry{"H", element(1).color, 3});
  CHECK(legend.entries[1] == LegendEntry{"O", element(8).color, 1});
  CHECK(legend.entries[2] == LegendEntry{"unknown", element(0).color, 1});
}

TEST_CASE(
    "a legend by type is in alphabetical order and has the colours of materials with the type's "
    "name") {
  Particles particles;
  particles.positions.resize(3);
  particles.types = {{"b", "a", "unused"}, {0, 1, 0}};
  MaterialNames names;
  names.define("a", {MaterialType::metal, {0.25, 0.5, 0.75}, 0, 1});
  const Legend legend = legend_of(particles, {ParticleMaterial::Rule::by_type, {}}, names);
  CHECK(legend.title == "type");
  REQUIRE(legend.entries.size() == 2);
  CHECK(legend.entries[0] == LegendEntry{"a", {0.25, 0.5, 0.75}, 1});
  CHECK(legend.entries[1].name == "b");
  CHECK(legend.entries[1].count == 2);
  CHECK(legend_of(particles, {ParticleMaterial::Rule::named, "a"}, names).empty());
}

TEST_CASE("a legend by type names particles without a type, also if a frame has none of them") {
  Particles particles;
  particles.positions.resize(2);
  particles.types = {{"", "a"}, {0, 1}};
  const Legend legend = legend_of(particles, {ParticleMaterial::Rule::by_type, {}}, {});
  REQUIRE(legend.entries.size() == 2);
  CHECK(legend.entries[0].name == "a");
  CHECK(legend.entries[1].name == "no name");
  particles.types.index = {1, 1};
  const Legend later =
      legend_of(particles, {ParticleMaterial::Rule::by_type, {}}, {}, {"a", "no name"});
  REQUIRE(later.entries.size() == 2);
  CHECK(later.entries[1].count == 0);
}

TEST_CASE("legends of several files with the same title and scale become one") {
  std::vector<Legend> legends;
  add_legend(legends, {});
  CHECK(legends.empty());
  add_legend(legends, {.title = "type", .entries = {entry("1", 0.1, 5)}});
  add_legend(legends, {.title = "type", .entries = {entry("2", 0.2, 1), entry("1", 0.1, 2)}});
  add_legend(legends, {.title = "element", .entries = {entry("H", 1, 1)}});
  REQUIRE(legends.size() == 2);
  CHECK(legends[0].entries == std::vector<LegendEntry>{entry("1", 0.1, 7), entry("2", 0.2, 1)});
  const Legend scale{.title = "vx", .low = 0, .high = 1, .stops = {{0, 0, 0}, {1, 1, 1}}};
  add_legend(legends, scale);
  add_legend(legends, scale);
  CHECK(legends.size() == 3);
  Legend other = scale;
  other.high = 2;
  add_legend(legends, other);
  CHECK(legends.size() == 4);
}

TEST_CASE("a legend's text is JSON with all entries, except beyond the limit of names") {
  Legend scale{
      .title = "v\"x", .unit = "m/s", .low = -1, .high = 2, .stops = {{0, 0, 1}, {1, 0, 0}}};
  Legend many{.title = "type"};
  for (int i = 0; i < 300; ++i) many.entries.push_back({"\xff", {0, 0.5, 0}, 1});
  const json list = json::parse(legends_text({scale, many}));
  CHECK(list.at(0) == json{{"title", "v\"x"},
                           {"unit", "m/s"},
                           {"low", -1.0},
                           {"high", 2.0},
                           {"stops", {{0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}}}});
  CHECK(list.at(1).at("entries").size() == 256);
  CHECK(list.at(1).at("left_out") == 44);
  CHECK_FALSE(list.at(1).contains("low"));
  CHECK(list.at(1).at("entries").at(0).at("color") == json{0.0, 0.5, 0.0});
}

}  // namespace parray

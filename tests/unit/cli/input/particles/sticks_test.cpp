#include "cli/input/particles/sticks.h"

#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <set>
#include <vector>

#include "cli/input/particles/elements.h"
#include "common/scene/limits.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using Rule = ParticleRadius::Rule;

/// Methanal with the bonds that its file states.
Particles methanal() {
  Particles particles;
  particles.positions = {{0, 0, 0}, {1.2, 0, 0}, {-0.6, 0.9, 0}, {-0.6, -0.9, 0}};
  particles.elements = {6, 8, 1, 1};
  particles.bonds = {{0, 1}, {0, 2}, {0, 3}};
  return particles;
}

ParticleLook look_of(ParticleStyle style, ParticleRadius radius) {
  ParticleLook look;
  look.style = style;
  look.radius = radius;
  return look;
}

double radius_in(const ParticleLook& look) {
  std::vector<Sphere> spheres{{{0, 0, 0}, 2, 0}};
  shape_spheres(look, 0.15, spheres);
  return spheres.front().radius;
}

ParticleStyle decided_style(const Particles& particles, ParticleSource source = {}) {
  decide_style(particles, source);
  return source.look.style;
}

}  // namespace

TEST_CASE("a stick has two halves, each with the material of its own particle") {
  Scene scene;
  scene.spheres = {{{9, 9, 9}, 1, 0}, {{0, 0, 0}, 1, 1}, {{2, 0, 0}, 1, 2}};
  append_sticks({{0, 1, {2, 0, 0}}}, {{1, 0.25, true}, {2, 0.5, true}}, scene);
  CHECK(scene.capsules ==
        std::vector<Capsule>{{{0, 0, 0}, {1, 0, 0}, 0.25, 1}, {{2, 0, 0}, {1, 0, 0}, 0.5, 2}});
}

TEST_CASE("the halves of a bond across a periodic face stay at their own particles") {
  Scene scene;
  scene.spheres = {{{0.5, 0, 0}, 1, 0}, {{9.5, 0, 0}, 1, 0}};
  append_sticks({{0, 1, {-1, 0, 0}}}, {{0, 0.25, true}, {1, 0.25, true}}, scene);
  CHECK(scene.capsules == std::vector<Capsule>{{{0.5, 0, 0}, {0, 0, 0}, 0.25, 0},
                                               {{9.5, 0, 0}, {10, 0, 0}, 0.25, 0}});
}

TEST_CASE("a bond to a particle that is not shown is left out") {
  Scene scene;
  scene.spheres = {{{0, 0, 0}, 1, 0}};
  append_sticks({{0, 1, {2, 0, 0}}}, {{0, 0.5, true}, {}}, scene);
  CHECK(scene.capsules.empty());
}

TEST_CASE("particles without sticks have no half, and bonds of length 0 have none") {
  Scene scene;
  scene.spheres = {{{0, 0, 0}, 1, 0}, {{2, 0, 0}, 1, 0}};
  append_sticks({{0, 1, {2, 0, 0}}, {0, 1, {}}}, {{0, 0, true}, {1, 0.5, true}}, scene);
  CHECK(scene.capsules == std::vector<Capsule>{{{2, 0, 0}, {1, 0, 0}, 0.5, 0}});
}

TEST_CASE("the style and the rule of the radius decide the size of balls") {
  CHECK(radius_in(look_of(ParticleStyle::spheres, {Rule::by_element, 0})) == 2);
  CHECK(radius_in(look_of(ParticleStyle::automatic, {Rule::by_element, 0})) == 2);
  CHECK(radius_in(look_of(ParticleStyle::balls_and_sticks, {Rule::by_element, 0})) == 0.5);
  CHECK(radius_in(look_of(ParticleStyle::balls_and_sticks, {Rule::covalent, 0})) == 1);
  CHECK(radius_in(look_of(ParticleStyle::balls_and_sticks, {Rule::column, 0})) == 0.5);
  CHECK(radius_in(look_of(ParticleStyle::balls_and_sticks, {Rule::fixed, 2})) == 2);
  CHECK(radius_in(look_of(ParticleStyle::sticks, {Rule::by_element, 0})) == 0.15);
  ParticleLook by_number = look_of(ParticleStyle::balls_and_sticks, {Rule::column, 0});
  by_number.radius_by = {"mass"};
  CHECK(radius_in(by_number) == 2);
}

TEST_CASE("sticks are 0.15 angstrom thick in the unit of the file, or a tenth of the mean bond") {
  Particles particles = methanal();
  CHECK(stick_radius_of(particles, {}) == 0.15);
  particles.facts.length_unit = "nm";
  CHECK(stick_radius_of(particles, {}) == doctest::Approx(0.015));
  particles.elements.clear();
  CHECK(stick_radius_of(particles, {{0, 1, {3, 0, 0}}, {0, 2, {0, 5, 0}}}) == doctest::Approx(0.4));
  CHECK(stick_radius_of(particles, {}) > 0);
}

TEST_CASE("small molecules with bonds are balls and sticks unless a rule gives their radii") {
  CHECK(decided_style(methanal()) == ParticleStyle::balls_and_sticks);
  ParticleSource source;
  source.look.radius = {Rule::fixed, 0.4};
  CHECK(decided_style(methanal(), source) == ParticleStyle::balls_and_sticks);
  source.look.radius = {Rule::by_element, 0};
  CHECK(decided_style(methanal(), source) == ParticleStyle::automatic);
  source.look = {};
  source.look.style = ParticleStyle::spheres;
  CHECK(decided_style(methanal(), source) == ParticleStyle::spheres);
  source.look = {};
  source.bonds = BondSource::off;
  CHECK(decided_style(methanal(), source) == ParticleStyle::automatic);
  source = {};
  source.cell.crystal = true;
  CHECK(decided_style(methanal(), source) == ParticleStyle::automatic);
}

TEST_CASE("large molecules, unknown elements, radii of the file and beads stay spheres") {
  Particles particles = methanal();
  particles.elements[1] = 0;
  CHECK(decided_style(particles) == ParticleStyle::automatic);
  particles = methanal();
  particles.elements.clear();
  CHECK(decided_style(particles) == ParticleStyle::automatic);
  particles = methanal();
  particles.radii.assign(4, 1.0);
  CHECK(decided_style(particles) == ParticleStyle::automatic);
  particles = methanal();
  particles.facts.notes.push_back({"beads", 4, "beads"});
  CHECK(decided_style(particles) == ParticleStyle::automatic);
  for (const std::size_t count : {most_atoms_with_sticks, most_atoms_with_sticks + 1}) {
    particles = methanal();
    while (particles.count() < count) {
      particles.positions.push_back({10 + 9.0 * static_cast<double>(particles.count()), 0, 0});
      particles.elements.push_back(18);
    }
    CHECK((decided_style(particles) == ParticleStyle::balls_and_sticks) ==
          (count <= most_atoms_with_sticks));
  }
}

TEST_CASE("metals and noble gases that are no part of a molecule stay spheres") {
  const auto row_of = [](const std::vector<std::uint8_t>& elements, double distance) {
    Particles row;
    row.elements = elements;
    for (std::size_t i = 0; i < elements.size(); ++i) {
      row.positions.push_back({distance * static_cast<double>(i), 0, 0});
    }
    return row;
  };
  const Particles gold = row_of({79, 79, 79}, 2.8);
  CHECK_FALSE(drawn_bonds(gold, BondSource::automatic).empty());
  CHECK(decided_style(gold) == ParticleStyle::automatic);
  const Particles argon = row_of({18, 18, 18}, 1.1);  // in units of Lennard-Jones
  CHECK_UNARY(drawn_bonds(argon, BondSource::automatic).empty());
  CHECK(decided_style(argon) == ParticleStyle::automatic);
  CHECK(decided_style(row_of({18, 18, 18}, 3.8)) == ParticleStyle::automatic);
  CHECK(decided_style(row_of({79, 79, 16}, 2.4)) == ParticleStyle::balls_and_sticks);
  CHECK(decided_style(row_of({54, 9}, 2)) == ParticleStyle::balls_and_sticks);
}

TEST_CASE("atoms with arrows are balls, so that they do not hide the arrows") {
  Particles argon;
  argon.elements = {18, 18};
  argon.positions = {{0, 0, 0}, {3.8, 0, 0}};
  ParticleSource source;
  source.arrows = "velocity";
  decide_style(argon, source);
  CHECK(source.look.style == ParticleStyle::balls_and_sticks);
  CHECK(source.bonds == BondSource::off);
  ParticleSource asked;
  asked.arrows = "velocity";
  asked.look.style = ParticleStyle::spheres;
  decide_style(argon, asked);
  CHECK(asked.look.style == ParticleStyle::spheres);
  CHECK(asked.bonds == BondSource::automatic);
  ParticleSource molecule;
  molecule.arrows = "velocity";
  decide_style(methanal(), molecule);
  CHECK(molecule.look.style == ParticleStyle::balls_and_sticks);
  CHECK(molecule.bonds == BondSource::automatic);
}

TEST_CASE("arrows of larger structures remove no bonds for which the user asked") {
  Particles argon;
  argon.elements = {18, 18};
  argon.positions = {{0, 0, 0}, {3.8, 0, 0}};
  ParticleSource source;
  source.arrows = "velocity";
  source.bonds = BondSource::file;
  decide_style(argon, source);
  CHECK(source.look.style == ParticleStyle::balls_and_sticks);
  CHECK(source.bonds == BondSource::file);
  for (const auto style : {ParticleStyle::balls_and_sticks, ParticleStyle::sticks}) {
    source = {};
    source.arrows = "velocity";
    source.shows.resize(2);
    source.shows[0].look.style = style;
    decide_style(argon, source);
    CHECK(source.shows[0].look.style == style);
    CHECK(source.shows[1].look.style == ParticleStyle::balls_and_sticks);
    CHECK(source.bonds == BondSource::automatic);
  }
}

TEST_CASE("representations of a small molecule get the style one by one") {
  ParticleSource source;
  source.shows.resize(3);
  source.shows[1].look.style = ParticleStyle::sticks;
  source.shows[2].look.radius = {Rule::by_element, 0};
  decide_style(methanal(), source);
  CHECK(source.shows[0].look.style == ParticleStyle::balls_and_sticks);
  CHECK(source.shows[1].look.style == ParticleStyle::sticks);
  CHECK(source.shows[2].look.style == ParticleStyle::automatic);
}

TEST_CASE("the edges of a cell are twelve different capsules between its eight corners") {
  std::vector<Capsule> capsules;
  append_cell({{1, 1, 1}, {Vec3d{2, 0, 0}, Vec3d{1, 3, 0}, Vec3d{0, 0, 4}}, {}}, 5, capsules);
  REQUIRE(capsules.size() == 12);
  const auto key = [](const Vec3d& v) { return std::array{v.x, v.y, v.z}; };
  std::set<std::array<double, 3>> corners;
  std::set<std::set<std::array<double, 3>>> edges;
  for (const Capsule& capsule : capsules) {
    corners.insert({key(capsule.from), key(capsule.to)});
    edges.insert({key(capsule.from), key(capsule.to)});
    CHECK(capsule.material == 5);
    CHECK(capsule.radius == capsules.front().radius);
  }
  CHECK(corners.size() == 8);
  CHECK(edges.size() == 12);
  CHECK(corners.contains({4, 4, 5}));
  CHECK(capsules.front().radius > 0.01);
  CHECK(capsules.front().radius < 0.04);
}

}  // namespace parray

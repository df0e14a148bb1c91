
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "cli/input/particles/cell.h"
#include "common/base/error.h"
#include "common/scene/limits.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::message_of;

/// Returns atoms in a cell of edge 4, one type and one number for each.
Particles in_cube(std::vector<Vec3d> positions) {
  Particles particles;
  particles.cell = ParticleCell{{}, {Vec3d{4, 0, 0}, Vec3d{0, 4, 0}, Vec3d{0, 0, 4}}};
  for (std::size_t i = 0; i < positions.size(); ++i) {
    particles.elements.push_back(static_cast<std::uint8_t>(i + 1));
    particles.types.names.push_back("t" + std::to_string(i));
    particles.types.index.push_back(static_cast<std::uint32_t>(i));
  }
  particles.numbers = {{"charge", std::vector<double>(positions.size(), 0.5)}};
  particles.positions = std::move(positions);
  return particles;
}

bool has(const Particles& particles, const Vec3d& position) {
  return std::ranges::any_of(particles.positions,
                             [&](const Vec3d& other) { return length(other - position) < 1e-9; });
}

ParticleCell oblique() { return *cell_from({5, 6, 7}, {80, 95, 110}); }

Replicas copies(std::uint32_t a, std::uint32_t b, std::uint32_t c) { return {{a, b, c}}; }

}  // namespace

TEST_CASE("fractions of an oblique cell lead back to the position") {
  ParticleCell cell = oblique();
  cell.origin = {1, -2, 3};
  const CellFractions fractions(cell);
  CHECK(length(fractions.of(cell.origin)) < 1e-12);
  const Vec3d f = fractions.of(cell.origin + cell.edges[0] + 0.25 * cell.edges[2]);
  CHECK(length(f - Vec3d{1, 0, 0.25}) < 1e-12);
  CHECK(length(fractions.translation(Vec3d{1, 2, 3}) - fractions.translation(CellImage{1, 2, 3})) ==
        0);
  const Vec3d heights = CellFractions(*cell_from({4, 5, 6}, {90, 90, 90})).heights();
  CHECK(length(heights - Vec3d{4, 5, 6}) < 1e-12);
}

TEST_CASE("the nearest image is the nearest of all images, in a very oblique cell too") {
  const ParticleCell cell = *cell_from({4, 4, 4}, {60, 60, 35});
  const CellFractions fractions(cell);
  const Vec3d from{0.3, 0.2, 0.1};
  for (int n = 0; n < 200; ++n) {
    const Vec3d to{std::sin(n) * 9, std::sin(2 * n + 1) * 9, std::sin(3 * n + 2) * 9};
    const CellImage nearest = fractions.nearest(from, to);
    const auto distance = [&](const CellImage& step) {
      return length(to + fractions.translation(nearest) + fractions.translation(step) - from);
    };
    double least = distance({0, 0, 0});
    for (int i = 0; i < 15 * 15 * 15; ++i) {
      least = std::min(least, distance({i % 15 - 7, i / 15 % 15 - 7, i / 225 - 7}));
    }
    CHECK(distance({0, 0, 0}) <= least + 1e-9);
  }
}

TEST_CASE("numbers of copies are three whole numbers above 0") {
  CHECK(replicas_from("3x2x1") == copies(3, 2, 1));
  CHECK(text_of(replicas_from("3x2x1")) == "3x2x1");
  CHECK(text_of(Replicas{}).empty());
  for (const char* text : {"", "3", "3x3", "3x3x3x3", "0x1x1", "-1x1x1", "1.5x1x1", "axbxc", "3x3x",
                           "99999999999999999999x1x1", "100000001x1x1", "3X3X3"}) {
    CAPTURE(text);
    CHECK(message_of<InputError>([&] {
            (void)replicas_from(text);
          }).starts_with("'" + std::string(text) + "' is not a number of copies: write three"));
  }
}

TEST_CASE("replication repeats particles, columns and cell along each edge") {
  Particles particles = in_cube({{1, 1, 1}, {2, 2, 2}});
  replicate(particles, copies(3, 2, 1));
  REQUIRE(particles.count() == 12);
  CHECK(particles.positions[0] == Vec3d{1, 1, 1});
  CHECK(particles.positions[1] == Vec3d{2, 2, 2});
  CHECK(has(particles, {1 + 8, 1 + 4, 1}));
  CHECK(has(particles, {2 + 4, 2, 2}));
  CHECK(particles.cell->edges[0] == Vec3d{12, 0, 0});
  CHECK(particles.cell->edges[1] == Vec3d{0, 8, 0});
  CHECK(particles.cell->edges[2] == Vec3d{0, 0, 4});
  CHECK(particles.elements == std::vector<std::uint8_t>{1, 2, 1, 2, 1, 2, 1, 2, 1, 2, 1, 2});
  CHECK(particles.types.of(11) == "t1");
  CHECK(particles.numbers[0].values == std::vector<double>(12, 0.5));
}

TEST_CASE("replication follows the edges of an oblique cell") {
  Particles particles = in_cube({{0, 0, 0}});
  particles.cell = oblique();
  replicate(particles, copies(1, 2, 2));
  const auto& edges = oblique().edges;
  for (const Vec3d& corner : {Vec3d{}, edges[1], edges[2], edges[1] + edges[2]}) {
    CHECK(has(particles, corner));
  }
}

TEST_CASE("too many copies are refused before memory is allocated, without overflow") {
  Particles particles = in_cube({{1, 1, 1}, {2, 2, 2}});
  for (const Replicas& replicas :
       {copies(50'000'001, 1, 1), copies(100'000'000, 100'000'000, 100'000'000),
        copies(1, 65'536, 65'536), copies(4'000'000, 1'000, 4'000'000)}) {
    CHECK(message_of<InputError>([&] { replicate(particles, replicas); }) ==
          text_of(replicas) +
              " copies of 2 particles are more than 100000000 spheres: use fewer copies");
    CHECK(particles.count() == 2);
  }
}

TEST_CASE("an atom on a corner is drawn on all eight, one on a face on two, one inside once") {
  Particles corner = in_cube({{0, 0, 0}});
  CHECK(add_boundary_copies(corner, {1e-3, 1e-3, 1e-3}) == 7);
  for (int n = 0; n < 8; ++n) CHECK(has(corner, {4.0 * (n % 2), 4.0 * (n / 2 % 2), 4.0 * (n / 4)}));
  CHECK(corner.elements == std::vector<std::uint8_t>(8, 1));
  Particles face = in_cube({{2, 2, 0.003}});
  CHECK(add_boundary_copies(face, {1e-3, 1e-3, 1e-3}) == 1);
  CHECK(has(face, {2, 2, 4.003}));
  Particles far_face = in_cube({{4, 2, 2}});
  CHECK(add_boundary_copies(far_face, {1e-3, 1e-3, 1e-3}) == 1);
  CHECK(has(far_face, {0, 2, 2}));
  Particles inside = in_cube({{2, 2, 0.005}, {9, 0, 0}});
  CHECK(add_boundary_copies(inside, {1e-3, 1e-3, 1e-3}) == 0);
}

TEST_CASE("no copy takes the place of an atom that the file has") {
  Particles both = in_cube({{0, 2, 2}, {4, 2, 2}});
  CHECK(add_boundary_copies(both, {1e-3, 1e-3, 1e-3}) == 0);
}

TEST_CASE("edges that are not periodic have no copies and no wrapping") {
  Particles slab = in_cube({{0, 0, 0}, {5, 5, 5}});
  slab.cell->periodic = {true, true, false};
  wrap(slab);
  CHECK(has(slab, {1, 1, 5}));
  CHECK(add_boundary_copies(slab, {1e-3, 1e-3, 1e-3}) == 3);
  CHECK_FALSE(has(slab, {0, 0, 4}));
  Particles above = in_cube({{0, 2, 5}});  // beyond the face that is not periodic
  above.cell->periodic = {true, true, false};
  CHECK(add_boundary_copies(above, {1e-3, 1e-3, 1e-3}) == 1);
}

TEST_CASE("wrapping brings each particle into the cell by whole edges") {
  Particles particles = in_cube({{-1, 5, 2}, {40, -40, 3.5}, {-1e-8, 1, 1}});
  particles.cell->origin = {0, 0, 1};
  wrap(particles);
  CHECK(has(particles, {3, 1, 2}));
  CHECK(has(particles, {0, 0, 3.5}));
  CHECK(particles.positions[2] == Vec3d{-1e-8, 1, 1});  // rounding does not cross the cell
}

TEST_CASE("wrapping moves a molecule as one, by its centroid") {
  Particles particles = in_cube({{3.5, 1, 1}, {4.2, 1, 1}, {5.5, 1, 1}, {6, 1, 1}});
  const std::vector<std::uint32_t> molecule{0, 0, 1, 1};
  wrap(particles, molecule);
  CHECK(has(particles, {3.5, 1, 1}));
  CHECK(has(particles, {4.2, 1, 1}));
  CHECK(has(particles, {1.5, 1, 1}));
  CHECK(has(particles, {2, 1, 1}));
}

TEST_CASE("a group that crosses a face is centred by its images") {
  Particles particles = in_cube({{3.8, 1, 1}, {0.6, 1, 1}, {2, 3, 3}});
  center_on(particles, {1, 1, 0});
  wrap(particles);
  CHECK(has(particles, {1.6, 2, 2}));
  CHECK(has(particles, {2.4, 2, 2}));
  CHECK(has(particles, {3.8, 0, 0}));
}

TEST_CASE("numbers at the ends of the range wrap without overflow") {
  Particles particles = in_cube({{1e15, -1e15, 3}});
  particles.cell = ParticleCell{{}, {Vec3d{1e-15, 0, 0}, Vec3d{0, 4, 0}, Vec3d{0, 0, 4}}};
  wrap(particles);
  for (const double x : {particles.positions[0].x, particles.positions[0].y}) {
    CHECK(std::abs(x) <= limits::max_length);
  }
}

}  // namespace parray

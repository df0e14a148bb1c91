#include <doctest/doctest.h>

#include <cstring>
#include <string>
#include <vector>

#include "tests/support/memory.h"
#include "tests/support/particle_columns.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_gsd.h"

namespace parray {
namespace {

using test::gsd_count;
using test::gsd_file;
using test::gsd_floats;
using test::gsd_part;
using test::numbers_of;
using test::packed;
using test::ParticleFiles;
using test::sample_gsd;

using Doubles = std::vector<double>;

Particles gsd_frame(const std::string& bytes, std::uint64_t number) {
  const ParticleFiles files;
  return read_particles(files.write("a.gsd", bytes),
                        {.frame = FrameChoice{number, false}, .all = true});
}

std::string gsd_message(const std::string& bytes) {
  return ParticleFiles().message("a.gsd", bytes);
}

bool says(const std::string& bytes, const std::string& text) {
  const std::string found = gsd_message(bytes);
  INFO(found);
  CHECK(found.find('\n') == std::string::npos);
  return found.find(text) != std::string::npos;
}

/// The bytes with those at `at` replaced.
std::string with(std::string bytes, std::size_t at, const std::string& other) {
  return bytes.replace(at, other.size(), other);
}

/// The byte of the index at which the entry `number` begins.
std::size_t entry_at(const std::string& bytes, std::size_t number) {
  std::uint64_t location = 0;
  std::memcpy(&location, bytes.data() + 8, sizeof location);
  return static_cast<std::size_t>(location) + 32 * number;
}

std::string u64(std::uint64_t value) { return test::bytes_of(value); }

}  // namespace

TEST_CASE("GSD: versions 0.3, 1 and 2 of the file layer give the same particles") {
  std::string old = sample_gsd(1);
  old = with(old, 44, test::bytes_of(std::uint32_t{3}));
  for (const std::string& bytes :
       {old, sample_gsd(1), sample_gsd(2), packed(sample_gsd(2)), packed(sample_gsd(2), "zstd")}) {
    const Particles particles = gsd_frame(bytes, 0);
    CHECK(particles.positions == std::vector<Vec3d>{{0, 0.5, 1}, {-1, -2, -3}});
    CHECK(particles.radii == Doubles{0.5, 0.25});
    CHECK(particles.types.names == std::vector<std::string>{"long", "A"});
    CHECK(particles.types.index == std::vector<std::uint32_t>{0, 1});
    CHECK(particles.elements.empty());
    CHECK(particles.facts.frames == 3U);
    CHECK(particles.facts.time == 10);
    CHECK(particles.facts.notes.empty());
  }
}

TEST_CASE("GSD: numbers of particles are columns: vectors, quaternions and logged numbers") {
  const Particles particles = gsd_frame(sample_gsd(), 0);
  CHECK(particles.numbers.size() == 12);
  CHECK(numbers_of(particles, "mass") == Doubles{2, 3});
  CHECK(numbers_of(particles, "vx") == Doubles{1, 4});
  CHECK(numbers_of(particles, "vz") == Doubles{3, 6});
  CHECK(numbers_of(particles, "iy") == Doubles{1, 0});
  CHECK(numbers_of(particles, "iz") == Doubles{0, -1});
  CHECK(numbers_of(particles, "orientation_w") == Doubles{1, 0});
  CHECK(numbers_of(particles, "orientation_x") == Doubles{0, 1});
  CHECK(numbers_of(particles, "log/particles/pair/energies") == Doubles{-1.5, -2.5});
  const ParticleFiles files;
  ParticleRequest one;
  one.numbers = {"vy"};
  const Particles wanted = read_particles(files.write("a.gsd", sample_gsd()), one);
  REQUIRE(wanted.numbers.size() == 1);
  CHECK(wanted.numbers[0].values == Doubles{2, 5});
}

TEST_CASE("GSD: the box is triclinic, and its centre is the origin") {
  const Particles particles = gsd_frame(sample_gsd(), 0);
  REQUIRE(particles.cell);
  CHECK(particles.cell->edges == std::array<Vec3d, 3>{Vec3d{4, 0, 0}, {3, 6, 0}, {2, -4, 8}});
  CHECK(particles.cell->origin == Vec3d{-4.5, -1, -4});
  const Particles flat = gsd_frame(
      gsd_file({{gsd_floats("configuration/box", 6, {4, 6, 0, 0, 0, 0}), gsd_count(1)}}), 0);
  CHECK_FALSE(flat.cell);
}

TEST_CASE("GSD: a frame inherits what it lacks from frame 0, or has defaults") {
  const Particles second = gsd_frame(sample_gsd(), 1);
  CHECK(second.positions == gsd_frame(sample_gsd(), 0).positions);
  CHECK(second.facts.time == 10);
  CHECK(second.cell->edges[0].x == 4);
  const Particles third = gsd_frame(sample_gsd(), 2);
  CHECK(third.positions == std::vector<Vec3d>{{1, 1, 1}, {2, 2, 2}});
  CHECK(third.radii == Doubles{0.5, 0.25});
  CHECK(third.types.names == std::vector<std::string>{"long", "A"});
  CHECK(numbers_of(third, "vx") == Doubles{1, 4});
  CHECK(third.facts.time == 30);
  CHECK(third.cell->edges[0] == Vec3d{5, 0, 0});
}

TEST_CASE("GSD: frame 0 defines nothing for another number of particles") {
  const std::string bytes =
      gsd_file({{gsd_count(1),
                 gsd_floats("particles/position", 3, {1, 2, 3}),
                 gsd_floats("particles/diameter", 1, {4}),
                 gsd_floats("particles/mass", 1, {5}),
                 {"particles/types", 5, 1, 2, std::string("B\0", 2)}},
                {gsd_count(2), gsd_floats("particles/position", 3, {0, 0, 0, 1, 1, 1})},
                {gsd_count(0)}});
  const Particles particles = gsd_frame(bytes, 1);
  CHECK(particles.count() == 2);
  CHECK(particles.radii == Doubles{0.5, 0.5});
  CHECK(particles.numbers.empty());
  CHECK(particles.types.names == std::vector<std::string>{"B"});
  REQUIRE(particles.facts.notes.size() == 1);
  CHECK(particles.facts.notes[0].key == "default_diameters");
  CHECK(particles.facts.notes[0].count == 2);
  const ParticleFiles files;
  const auto file = files.write("a.gsd", bytes);
  CHECK(test::message_of<InputError>([&] {
          read_particles(file, {.frame = FrameChoice{2, false}});
        }).find("frame 2 has no particles") != std::string::npos);
  CHECK(particles.facts.frames == 3U);
}

TEST_CASE("GSD: without diameters, the shapes of the types give the radii of spheres") {
  const std::string sphere = R"({"type": "Sphere", "diameter": 3})";
  std::string shapes = sphere + std::string(1, '\0') + R"({"type": 7, "diameter": 3})";
  shapes.resize(2 * (sphere.size() + 1));
  const test::GsdFrameParts parts{
      gsd_count(2),
      gsd_floats("particles/position", 3, {0, 0, 0, 1, 1, 1}),
      {"particles/types", 5, 2, 2, std::string("A\0B\0", 4)},
      gsd_part<std::uint32_t>("particles/typeid", 3, 1, {1, 0}),
      {"particles/type_shapes", 5, 2, static_cast<std::uint32_t>(sphere.size() + 1), shapes}};
  const Particles particles = gsd_frame(gsd_file({parts}), 0);
  CHECK(particles.radii == Doubles{0.5, 1.5});
  REQUIRE(particles.facts.notes.size() == 1);
  CHECK(particles.facts.notes[0].count == 1);
}

TEST_CASE("GSD: one particle at the origin needs no positions, more particles do") {
  CHECK(gsd_frame(gsd_file({{gsd_count(1)}}), 0).positions == std::vector<Vec3d>{{0, 0, 0}});
  CHECK(says(gsd_file({{gsd_count(2)}}), "frame 0 has no positions"));
}

TEST_CASE("GSD: invalid headers, indexes and chunks are refused in one line") {
  const std::string good = sample_gsd();
  CHECK(says(with(good, 44, test::bytes_of(std::uint32_t{3} << 16U)), "version 3.0 of GSD"));
  CHECK(says(gsd_file({{gsd_count(1)}}, 2, "mine"), "the file has the schema 'mine'"));
  CHECK(says(gsd_file({{}}), "no particles"));
  CHECK(says(with(good, 8, u64(std::uint64_t{1} << 40U)), "ends within its data"));
  CHECK(says(with(good, 16, u64(UINT64_MAX)), "the header is not valid"));
  CHECK(says(with(good, 16, u64(std::uint64_t{1} << 40U)), "ends within its data"));
  CHECK(says(with(good, 24, u64(UINT64_MAX)), "an impossible place or size of data"));
  CHECK(says(with(good, 32, u64(UINT64_MAX)), "the header is not valid"));
  CHECK(says(with(good, entry_at(good, 1), u64(1000)), "the index has an invalid entry"));
  CHECK(says(with(good, entry_at(good, 1) + 30, "\x0c"), "the index has an invalid entry"));
  CHECK(says(with(good, entry_at(good, 7) + 8, u64(UINT64_MAX)), "particles/position has"));
  CHECK(says(with(good, entry_at(good, 7) + 8, u64(3)), "has 3 rows for 2 particles"));
  CHECK(says(with(good, entry_at(good, 7) + 16, u64(good.size() - 8)), "ends within its data"));
  CHECK(says(with(good, entry_at(good, 7) + 24, test::bytes_of(std::uint32_t{2})),
             "has 2 columns instead of 3"));
  CHECK(says(gsd_file({{gsd_count(200'000'000)}}), "200000000 atoms"));
  CHECK(says(gsd_file({{gsd_count(1), gsd_part<std::uint32_t>("particles/typeid", 3, 1, {1})}}),
             "a particle has the type 1 of 1 types"));
  CHECK(says(gsd_file({{gsd_count(1), gsd_floats("particles/diameter", 1, {0})}}), "radius 0 is"));
  CHECK(says(gsd_file({{gsd_count(1), gsd_floats("configuration/box", 3, {1, 1, 1})}}),
             "the box does not have 6 numbers"));
  CHECK(says(gsd_file({{gsd_count(1), {"particles/position", 11, 1, 3, "abc"}}}),
             "texts instead of numbers"));
  CHECK(says(gsd_file({{gsd_count(1), gsd_floats("particles/types", 1, {1})}}),
             "the chunk particles/types does not have texts"));
}

TEST_CASE("GSD: every truncated file is refused in one line or has fewer frames") {
  const ParticleFiles files;
  const std::string bytes = sample_gsd();
  for (std::size_t length = 1; length < bytes.size() - 96; length += 3) {
    const auto file = files.write("a.gsd", bytes.substr(0, length));
    const std::string found =
        test::message_of<InputError>([&] { read_particles(file, {.all = true}); });
    CHECK_FALSE(found.empty());
    CHECK(found.find('\n') == std::string::npos);
  }
}

TEST_CASE("GSD: chunks that share bytes and counts beyond the file allocate no memory") {
  const std::uint64_t before = test::peak_address_space();
  constexpr std::uint32_t particles = 10'000;
  test::GsdFrameParts parts{gsd_count(particles),
                            gsd_floats("particles/position", 3, std::vector<float>(3 * particles))};
  for (int i = 0; i < 1000; ++i) {
    parts.push_back({"log/particles/" + std::to_string(i), 9, particles, 1, ""});
  }
  const std::string shared = gsd_file({parts});
  const ParticleFiles files;
  for (const std::string& bytes : {shared, packed(shared)}) {
    const auto file = files.write("a.gsd", bytes);
    const std::string found =
        test::message_of<InputError>([&] { read_particles(file, {.all = true}); });
    CHECK_FALSE(found.empty());
  }
  const std::string bomb = gsd_file(
      {{gsd_count(100'000'000), {"particles/position", 9, 100'000'000, 3, std::string(12, '\0')}}});
  CHECK(says(bomb, "ends within its data"));
  CHECK(says(packed(bomb), "ends within its data"));
  CHECK(test::peak_address_space() - before < 64'000'000);
}

}  // namespace parray

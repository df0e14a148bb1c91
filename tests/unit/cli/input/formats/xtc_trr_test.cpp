#include <doctest/doctest.h>

#include <string>

#include "tests/support/particle_columns.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_trajectories.h"
#include "tests/support/trajectory_checks.h"

namespace parray {
namespace {

using test::check_cuts;
using test::everything;
using test::Frame;
using test::has_edges;
using test::has_note;
using test::last_frame;
using test::near_stored;
using test::ParticleFiles;
using test::same_positions;

}  // namespace

TEST_CASE("XTC: packed positions in nm become angstrom, with time and cell") {
  const ParticleFiles files;
  const auto file = files.write("a.xtc", test::packed_xtc() + test::packed_xtc());
  const Particles particles = read_particles(file, everything);
  Frame water;
  for (int i = 0; i < 5; ++i) {
    const Vec3d oxygen{3.1 * i, 5, 7 - 0.5 * i};
    water.insert(water.end(),
                 {oxygen, oxygen + Vec3d{0.96, 0.1, 0}, oxygen + Vec3d{-0.24, 0.93, 0}});
  }
  CHECK(same_positions(particles.positions, water));
  CHECK(particles.facts.time == 1.5);
  CHECK(particles.facts.frames == 2U);
  CHECK(has_edges(particles, {20, 0, 0}, {5, 30, 0}, {0, 0, 40}));
  CHECK(has_note(particles, "length_unit"));
  CHECK(particles.facts.length_unit == "angstrom");
  check_cuts("a.xtc", test::packed_xtc(), 1);
}

TEST_CASE("XTC: coordinates too large for one number are packed separately") {
  const ParticleFiles files;
  const Particles particles = read_particles(files.write("a.xtc", test::wide_xtc()));
  REQUIRE(particles.count() == 11);
  for (std::size_t i = 0; i < 11; ++i) {
    const auto x = static_cast<double>(i);
    CHECK(near_stored(particles.positions[i], 10.0 * Vec3d{-20000 + 3800 * x, 5 * x, 0.25 * x * x},
                      1e-6));
  }
  CHECK_FALSE(particles.cell);
}

TEST_CASE("XTC: few atoms are not packed, and an unfinished frame is not the last") {
  const ParticleFiles files;
  const std::string two =
      test::plain_xtc_frame({{0.1, 0.2, 0.3}}, 0) + test::plain_xtc_frame({{0.4, 0.5, 0.6}}, 2);
  const Particles particles =
      read_particles(files.write("a.xtc", two + two.substr(0, 30)), last_frame);
  CHECK(same_positions(particles.positions, {{4, 5, 6}}));
  CHECK(particles.facts.time == 2);
  CHECK(particles.facts.frames == 2U);
  CHECK(has_note(particles, "unreadable_frames"));
}

TEST_CASE("XTC: invalid packed data are refused") {
  const ParticleFiles files;
  const std::string good = test::packed_xtc();
  const auto with = [&](std::size_t at, std::int32_t value) {
    return files.message("a.xtc", std::string(good).replace(at, 4, test::xdr(value)));
  };
  CHECK(with(0, 1994).find("not a frame of XTC") != std::string::npos);
  CHECK(with(52, 14).find("two different numbers of atoms") != std::string::npos);
  CHECK(with(60, 600).find("coordinates are not valid") != std::string::npos);  // least above most
  CHECK(with(84, 8).find("coordinates are not valid") != std::string::npos);    // no such size
  CHECK(with(84, 73).find("coordinates are not valid") != std::string::npos);
  CHECK(with(88, -4).find("size is negative") != std::string::npos);
  CHECK(with(88, 20).find("coordinates are not valid") != std::string::npos);  // too few bits
}

TEST_CASE("TRR: single and double precision, skipped velocities, frames without positions") {
  const ParticleFiles files;
  const Frame nm{{0.1, 0.2, 0.3}, {0.4, 0.5, 0.6}};
  const std::string bytes = test::trr_frame<float>({}, 0.5F) + test::trr_frame<double>(nm, 1.25);
  const Particles particles = read_particles(files.write("a.trr", bytes), everything);
  CHECK(same_positions(particles.positions, {{1, 2, 3}, {4, 5, 6}}));
  CHECK(particles.facts.time == 1.25);
  CHECK(particles.facts.frame == 1);
  CHECK(particles.facts.frames == 2U);
  CHECK(has_edges(particles, {30, 0, 0}, {0, 30, 0}, {0, 0, 30}));
  check_cuts("a.trr", test::trr_frame<float>(nm, 0.5F), 1);
}

}  // namespace parray

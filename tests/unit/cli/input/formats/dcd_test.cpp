#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "tests/support/particle_columns.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_trajectories.h"
#include "tests/support/trajectory_checks.h"

namespace parray {
namespace {

using test::check_cuts;
using test::DcdParts;
using test::everything;
using test::first_frame;
using test::has_edges;
using test::last_frame;
using test::ParticleFiles;
using test::same_positions;
using test::second_frame;

}  // namespace

TEST_CASE("DCD: frames of both byte orders, with their steps as times") {
  const ParticleFiles files;
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    for (const bool charmm : {true, false}) {
      DcdParts parts;
      parts.order = order;
      parts.charmm = charmm;
      const auto file = files.write("a.dcd", test::dcd_file({first_frame, second_frame}, parts));
      const Particles particles = read_particles(file, everything);
      CHECK(same_positions(particles.positions, first_frame));
      CHECK(particles.facts.frames == 2U);
      CHECK(particles.facts.time == 100);
      CHECK(particles.elements.empty());
      CHECK(particles.types.empty());
      CHECK_FALSE(particles.cell);
      const Particles end = read_particles(file, last_frame);
      CHECK(same_positions(end.positions, second_frame));
      CHECK(end.facts.time == 150);
    }
  }
}

TEST_CASE("DCD: the cell as angles, cosines and a matrix") {
  const ParticleFiles files;
  const auto cell = [&](const std::array<double, 6>& six) {
    DcdParts parts;
    parts.cells = {six};
    return read_particles(files.write("a.dcd", test::dcd_file({first_frame}, parts)));
  };
  const double half_root = std::sqrt(0.75);
  CHECK(has_edges(cell({10, 90, 20, 90, 90, 30}), {10, 0, 0}, {0, 20, 0}, {0, 0, 30}));
  CHECK(has_edges(cell({10, 60, 20, 90, 90, 30}), {10, 0, 0}, {10, 20 * half_root, 0}, {0, 0, 30}));
  CHECK(has_edges(cell({10, 0.5, 20, 0, 0, 30}), {10, 0, 0}, {10, 20 * half_root, 0}, {0, 0, 30}));
  CHECK(has_edges(cell({10, -2, 20, -3, -4, 30}), {10, -2, -3}, {-2, 20, -4}, {-3, -4, 30}));
  CHECK_FALSE(cell({0, 0, 0, 0, 0, 0}).cell);
}

TEST_CASE("DCD: fixed atoms are only in the first frame") {
  const ParticleFiles files;
  DcdParts parts;
  parts.moving = {2};
  const std::string bytes = test::dcd_file({first_frame, {{40, 50, 60}}, {{41, 51, 61}}}, parts);
  const auto file = files.write("a.dcd", bytes);
  CHECK(same_positions(read_particles(file, last_frame).positions,
                       {{1, 2, 3}, {41, 51, 61}, {7, 8, 9}}));
  CHECK(read_particles(file, everything).facts.frames == 3U);
}

TEST_CASE("DCD: surplus title lines are skipped") {
  const ParticleFiles files;
  DcdParts parts;
  parts.extra_title_lines = 2;
  CHECK(same_positions(
      read_particles(files.write("a.dcd", test::dcd_file({first_frame}, parts))).positions,
      first_frame));
}

TEST_CASE("DCD: damaged files are refused with the place") {
  const ParticleFiles files;
  const std::string good = test::dcd_file({first_frame, second_frame});
  CHECK(files.message("a.dcd", "CORD" + good).starts_with("a.dcd: byte 0: this is not a DCD file"));
  std::string velocities = good;
  velocities.replace(4, 4, "VELD");
  CHECK(files.message("a.dcd", velocities).find("velocities instead of positions") !=
        std::string::npos);
  std::string huge = good;
  huge.replace(92 + 92 + 4, 4, test::bytes_of(std::int32_t{2'000'000'000}));
  CHECK(files.message("a.dcd", huge)
            .find("2000000000 atoms: the file is probably damaged, copy it again") !=
        std::string::npos);
  check_cuts("a.dcd", good, 2);
}

}  // namespace parray

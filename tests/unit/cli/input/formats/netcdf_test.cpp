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
using test::first_frame;
using test::has_edges;
using test::last_frame;
using test::ParticleFiles;
using test::same_positions;
using test::second_frame;

}  // namespace

TEST_CASE("AMBER netCDF: versions 1, 2 and 5 are read, frames by seeking, with time and cell") {
  const ParticleFiles files;
  for (const int version : {1, 2, 5}) {
    CAPTURE(version);
    const auto file =
        files.write("a.nc", test::amber_netcdf({first_frame, second_frame, first_frame}, version));
    const Particles particles = read_particles(file, {.frame = FrameChoice{1, false}, .all = true});
    CHECK(same_positions(particles.positions, second_frame));
    CHECK(particles.facts.time == 2.5);
    CHECK(particles.facts.frames == 3U);
    CHECK(has_edges(particles, {10, 0, 0}, {10, 20 * std::sqrt(0.75), 0}, {0, 0, 30}));
    CHECK(read_particles(file, last_frame).facts.time == 5);
  }
  check_cuts("a.nc", test::amber_netcdf({first_frame, second_frame}), 2);
}

TEST_CASE("netCDF-4 and netCDF of other programs are refused with their kind") {
  const ParticleFiles files;
  std::string other = test::amber_netcdf({first_frame});
  other.replace(other.find("coordinates"), 11, "temperature");
  CHECK(files.message("a.nc", other).find("no variable coordinates") != std::string::npos);
  CHECK(files.message("a.nc", "\x89HDF\r\n\x1a\n and so on").find("nccopy") != std::string::npos);
  CHECK(files.message("a.nc", "CDF\x07" + other.substr(4)).find("not a netCDF file") !=
        std::string::npos);
}

}  // namespace parray

#include <doctest/doctest.h>

#include "tests/support/particle_columns.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_trajectories.h"
#include "tests/support/trajectory_checks.h"

namespace parray {
namespace {

using test::first_frame;
using test::last_frame;
using test::ParticleFiles;
using test::same_positions;
using test::second_frame;

}  // namespace

TEST_CASE("trajectories are also read from compressed files") {
  const ParticleFiles files;
  const auto dcd =
      files.write("a.dcd.gz", test::packed(test::dcd_file({first_frame, second_frame})));
  CHECK(same_positions(read_particles(dcd, last_frame).positions, second_frame));
  const auto netcdf =
      files.write("a.nc.gz", test::packed(test::amber_netcdf({first_frame, second_frame})));
  CHECK(same_positions(read_particles(netcdf, last_frame).positions, second_frame));
}

}  // namespace parray

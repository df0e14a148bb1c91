#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_trajectories.h"

namespace parray {
namespace {

using test::Frame;

using test::ParticleFiles;

const Frame first{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};

const Frame second{{-1, 2, 3}, {-4, 5, 6}, {-7, 8, 9}};

const ParticleRequest last{.frame = FrameChoice{0, true}};

bool near(const Vec3d& a, const Vec3d& b, double tolerance = 1e-5) {
  return length(a - b) <= tolerance * (1 + length(b));
}

bool same(const std::vector<Vec3d>& a, const Frame& b, double tolerance = 1e-5) {
  return std::ranges::equal(a, b, [&](auto& p, auto& q) { return near(p, q, tolerance); });
}

}  // namespace

TEST_CASE("trajectories are also read from compressed files") {
  const ParticleFiles files;
  const auto dcd = files.write("a.dcd.gz", test::packed(test::dcd_file({first, second})));
  CHECK(same(read_particles(dcd, last).positions, second));
  const auto netcdf = files.write("a.nc.gz", test::packed(test::amber_netcdf({first, second})));
  CHECK(same(read_particles(netcdf, last).positions, second));
}

}  // namespace parray

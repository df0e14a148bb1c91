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

const ParticleRequest all{.all = true};

const ParticleRequest last{.frame = FrameChoice{0, true}};

bool near(const Vec3d& a, const Vec3d& b, double tolerance = 1e-5) {
  return length(a - b) <= tolerance * (1 + length(b));
}

bool same(const std::vector<Vec3d>& a, const Frame& b, double tolerance = 1e-5) {
  return std::ranges::equal(a, b, [&](auto& p, auto& q) { return near(p, q, tolerance); });
}

bool has_edges(const Particles& particles, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  if (!particles.cell) return false;
  const auto& edges = particles.cell->edges;
  return near(edges[0], a) && near(edges[1], b) && near(edges[2], c);
}

/// Every file that is cut somewhere is refused in one line, or has fewer frames.
void check_cuts(const char* name, const std::string& bytes, std::size_t whole_frames) {
  const ParticleFiles files;
  for (std::size_t length = 1; length < bytes.size(); length += length < 400 ? 1 : 13) {
    const auto file = files.write(name, bytes.substr(0, length));
    try {
      const Particles particles = read_particles(file, all);
      CHECK(particles.facts.frames.value_or(0) < whole_frames);
    } catch (const InputError& error) {
      CHECK(std::string_view(error.what()).find('\n') == std::string_view::npos);
    }
  }
}

}  // namespace

TEST_CASE("AMBER netCDF: versions 1, 2 and 5 are read, frames by seeking, with time and cell") {
  const ParticleFiles files;
  for (const int version : {1, 2, 5}) {
    CAPTURE(version);
    const auto file = files.write("a.nc", test::amber_netcdf({first, second, first}, version));
    const Particles particles = read_particles(file, {.frame = FrameChoice{1, false}, .all = true});
    CHECK(same(particles.positions, second));
    CHECK(particles.facts.time == 2.5);
    CHECK(particles.facts.frames == 3U);
    CHECK(has_edges(particles, {10, 0, 0}, {10, 20 * std::sqrt(0.75), 0}, {0, 0, 30}));
    CHECK(read_particles(file, last).facts.time == 5);
  }
  check_cuts("a.nc", test::amber_netcdf({first, second}), 2);
}

TEST_CASE("netCDF-4 and netCDF of other programs are refused with their kind") {
  const ParticleFiles files;
  std::string other = test::amber_netcdf({first});
  other.replace(other.find("coordinates"), 11, "temperature");
  CHECK(files.message("a.nc", other).find("no variable coordinates") != std::string::npos);
  CHECK(files.message("a.nc", "\x89HDF\r\n\x1a\n and so on").find("nccopy") != std::string::npos);
  CHECK(files.message("a.nc", "CDF\x07" + other.substr(4)).find("not a netCDF file") !=
        std::string::npos);
}

}  // namespace parray

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_trajectories.h"

namespace parray {
namespace {

using test::DcdParts;
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

bool has_note(const Particles& particles, std::string_view key) {
  return std::ranges::any_of(particles.facts.notes, [&](auto& note) { return note.key == key; });
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

TEST_CASE("DCD: frames of both byte orders, with their steps as times") {
  const ParticleFiles files;
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    for (const bool charmm : {true, false}) {
      DcdParts parts;
      parts.order = order;
      parts.charmm = charmm;
      const auto file = files.write("a.dcd", test::dcd_file({first, second}, parts));
      const Particles particles = read_particles(file, all);
      CHECK(same(particles.positions, first));
      CHECK(particles.facts.frames == 2U);
      CHECK(particles.facts.time == 100);
      CHECK(particles.elements.empty());
      CHECK(particles.types.empty());
      CHECK_FALSE(particles.cell);
      const Particles end = read_particles(file, last);
      CHECK(same(end.positions, second));
      CHECK(end.facts.time == 150);
    }
  }
}

TEST_CASE("DCD: the cell as angles, cosines and a matrix") {
  const ParticleFiles files;
  const auto cell = [&](const std::array<double, 6>& six) {
    DcdParts parts;
    parts.cells = {six};
    return read_particles(files.write("a.dcd", test::dcd_file({first}, parts)));
  };
  const double half_root = std::sqrt(0.75);
  CHECK(has_edges(cell({10, 90, 20, 90, 90, 30}), {10, 0, 0}, {0, 20, 0}, {0, 0, 30}));
  CHECK(has_edges(cell({10, 60, 20, 90, 90, 30}), {10, 0, 0}, {10, 20 * half_root, 0}, {0, 0, 30}));
  CHECK(has_edges(cell({10, 0.5, 20, 0, 0, 30}), {10, 0, 0}, {10, 20 * half_root, 0}, {0, 0, 30}));
  CHECK(has_edges(cell({10, -2, 20, -3, -4, 30}), {10, -2, -3}, {-2, 20, -4}, {-3, -4, 30}));
  CHECK_FALSE(cell({0, 0, 0, 0, 0, 0}).cell);
}

TEST_CASE("DCD: atoms that are fixed stand in the first frame alone") {
  const ParticleFiles files;
  DcdParts parts;
  parts.moving = {2};
  const std::string bytes = test::dcd_file({first, {{40, 50, 60}}, {{41, 51, 61}}}, parts);
  const auto file = files.write("a.dcd", bytes);
  CHECK(same(read_particles(file, last).positions, {{1, 2, 3}, {41, 51, 61}, {7, 8, 9}}));
  CHECK(read_particles(file, all).facts.frames == 3U);
}

TEST_CASE("DCD: more lines of title than their record counts are passed over") {
  const ParticleFiles files;
  DcdParts parts;
  parts.extra_title_lines = 2;
  CHECK(
      same(read_particles(files.write("a.dcd", test::dcd_file({first}, parts))).positions, first));
}

TEST_CASE("DCD: damage is refused with the place") {
  const ParticleFiles files;
  const std::string good = test::dcd_file({first, second});
  CHECK(files.message("a.dcd", "CORD" + good).starts_with("a.dcd: byte 0: not a DCD file"));
  std::string velocities = good;
  velocities.replace(4, 4, "VELD");
  CHECK(files.message("a.dcd", velocities).find("velocities, not positions") != std::string::npos);
  std::string huge = good;
  huge.replace(92 + 92 + 4, 4, test::bytes_of(std::int32_t{2'000'000'000}));
  CHECK(files.message("a.dcd", huge).find("2000000000 atoms: is the file damaged?") !=
        std::string::npos);
  check_cuts("a.dcd", good, 2);
}

TEST_CASE("XTC: packed positions in nm become angstrom, with time and cell") {
  const ParticleFiles files;
  const auto file = files.write("a.xtc", test::packed_xtc() + test::packed_xtc());
  const Particles particles = read_particles(file, all);
  Frame water;
  for (int i = 0; i < 5; ++i) {
    const Vec3d oxygen{3.1 * i, 5, 7 - 0.5 * i};
    water.insert(water.end(),
                 {oxygen, oxygen + Vec3d{0.96, 0.1, 0}, oxygen + Vec3d{-0.24, 0.93, 0}});
  }
  CHECK(same(particles.positions, water));
  CHECK(particles.facts.time == 1.5);
  CHECK(particles.facts.frames == 2U);
  CHECK(has_edges(particles, {20, 0, 0}, {5, 30, 0}, {0, 0, 40}));
  CHECK(has_note(particles, "length_unit"));
  check_cuts("a.xtc", test::packed_xtc(), 1);
}

TEST_CASE("XTC: coordinates too wide for one number are packed each by itself") {
  const ParticleFiles files;
  const Particles particles = read_particles(files.write("a.xtc", test::wide_xtc()));
  REQUIRE(particles.count() == 11);
  for (std::size_t i = 0; i < 11; ++i) {
    const auto x = static_cast<double>(i);
    CHECK(near(particles.positions[i], 10.0 * Vec3d{-20000 + 3800 * x, 5 * x, 0.25 * x * x}, 1e-6));
  }
  CHECK_FALSE(particles.cell);
}

TEST_CASE("XTC: few atoms are not packed, and an unfinished frame is not the last") {
  const ParticleFiles files;
  const std::string two =
      test::plain_xtc_frame({{0.1, 0.2, 0.3}}, 0) + test::plain_xtc_frame({{0.4, 0.5, 0.6}}, 2);
  const Particles particles = read_particles(files.write("a.xtc", two + two.substr(0, 30)), last);
  CHECK(same(particles.positions, {{4, 5, 6}}));
  CHECK(particles.facts.time == 2);
  CHECK(particles.facts.frames == 2U);
  CHECK(has_note(particles, "unreadable_frames"));
}

TEST_CASE("XTC: packed data that cannot be are refused") {
  const ParticleFiles files;
  const std::string good = test::packed_xtc();
  const auto with = [&](std::size_t at, std::int32_t value) {
    return files.message("a.xtc", std::string(good).replace(at, 4, test::xdr(value)));
  };
  CHECK(with(0, 1994).find("no frame of XTC") != std::string::npos);
  CHECK(with(52, 14).find("two numbers of atoms") != std::string::npos);
  CHECK(with(60, 600).find("cannot be") != std::string::npos);  // least above most
  CHECK(with(84, 8).find("cannot be") != std::string::npos);    // no such size
  CHECK(with(84, 73).find("cannot be") != std::string::npos);
  CHECK(with(88, -4).find("negative size") != std::string::npos);
  CHECK(with(88, 20).find("cannot be") != std::string::npos);  // too few bits
}

TEST_CASE("TRR: single and double precision, velocities passed over, frames without positions") {
  const ParticleFiles files;
  const Frame nm{{0.1, 0.2, 0.3}, {0.4, 0.5, 0.6}};
  const std::string bytes = test::trr_frame<float>({}, 0.5F) + test::trr_frame<double>(nm, 1.25);
  const Particles particles = read_particles(files.write("a.trr", bytes), all);
  CHECK(same(particles.positions, {{1, 2, 3}, {4, 5, 6}}));
  CHECK(particles.facts.time == 1.25);
  CHECK(particles.facts.frame == 1);
  CHECK(particles.facts.frames == 2U);
  CHECK(has_edges(particles, {30, 0, 0}, {0, 30, 0}, {0, 0, 30}));
  check_cuts("a.trr", test::trr_frame<float>(nm, 0.5F), 1);
}

TEST_CASE("AMBER netCDF: versions 1, 2 and 5, frames by jumps, with time and cell") {
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

TEST_CASE("netCDF that is no trajectory of AMBER, or netCDF-4, is refused as that") {
  const ParticleFiles files;
  std::string other = test::amber_netcdf({first});
  other.replace(other.find("coordinates"), 11, "temperature");
  CHECK(files.message("a.nc", other).find("no variable coordinates") != std::string::npos);
  CHECK(files.message("a.nc", "\x89HDF\r\n\x1a\n and so on").find("nccopy") != std::string::npos);
  CHECK(files.message("a.nc", "CDF\x07" + other.substr(4)).find("not a netCDF file") !=
        std::string::npos);
}

TEST_CASE("trajectories are read from packed files, too") {
  const ParticleFiles files;
  const auto dcd = files.write("a.dcd.gz", test::packed(test::dcd_file({first, second})));
  CHECK(same(read_particles(dcd, last).positions, second));
  const auto netcdf = files.write("a.nc.gz", test::packed(test::amber_netcdf({first, second})));
  CHECK(same(read_particles(netcdf, last).positions, second));
}

}  // namespace parray

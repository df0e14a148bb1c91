#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "cli/output/picture/srgb.h"
#include "tests/support/particle_columns.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/three_particles.h"

namespace parray {
namespace {

using test::binary_positions;
using test::bytes_of;
using test::everything;
using test::names_of;
using test::numbers_of;
using test::packed;
using test::ParticleFiles;
using test::ply_header;
using test::three_positions;
using test::xyz_properties;

}  // namespace

TEST_CASE("PLY is read as text and as binary data of both byte orders") {
  const ParticleFiles files;
  const std::string ascii =
      ply_header("ascii", xyz_properties) + "1 -2 3.5\n0 0.25 -1e3\n-0.125 7 0\n";
  const std::string little =
      ply_header("binary_little_endian", xyz_properties) + binary_positions(std::endian::little);
  const std::string big =
      ply_header("binary_big_endian", xyz_properties) + binary_positions(std::endian::big);
  for (const std::string& file : {ascii, little, big, packed(ascii), packed(big)}) {
    const Particles particles = files.read("a.ply", file);
    CHECK(particles.positions == three_positions());
    CHECK(particles.radii.empty());
    CHECK(particles.colors.empty());
    CHECK(particles.elements.empty());
    CHECK(particles.types.empty());
    CHECK(particles.types.names.empty());
  }
}

TEST_CASE("every scalar type of PLY is read with its sign") {
  const ParticleFiles files;
  const std::string header =
      "ply\nformat binary_big_endian 1.0\nelement vertex 1\nproperty char x\nproperty short y\n"
      "property int32 z\nproperty uint8 a\nproperty ushort b\nproperty uint c\nproperty float64 "
      "radius\nend_header\n";
  constexpr auto big = std::endian::big;
  const Particles particles = files.read(
      "a.ply", header + bytes_of(std::int8_t{-1}, big) + bytes_of(std::int16_t{-300}, big) +
                   bytes_of(std::int32_t{-70000}, big) + bytes_of(std::uint8_t{255}, big) +
                   bytes_of(std::uint16_t{65535}, big) + bytes_of(std::uint32_t{1}, big) +
                   bytes_of(0.3, big));
  CHECK(particles.positions == std::vector<Vec3d>{{-1, -300, -70000}});
  CHECK(particles.radii == std::vector<double>{0.3});
}

TEST_CASE("PLY's radii and colours are read: uchar with the sRGB curve, float as it is") {
  const ParticleFiles files;
  const std::string one =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
      "property float y\nproperty float z\n";
  Particles particles =
      files.read("a.ply", one +
                              "property float radius\nproperty uchar red\nproperty uchar green\n"
                              "property uchar blue\nend_header\n1 2 3 0.5 255 128 0\n");
  CHECK(particles.radii == std::vector<double>{0.5});
  CHECK(particles.colors == std::vector<Vec3d>{{1, srgb_decode(128.0 / 255), 0}});
  particles = files.read("a.ply", one +
                                      "property float red\nproperty float green\n"
                                      "property float blue\nend_header\n1 2 3 1 0.5 0\n");
  CHECK(particles.colors == std::vector<Vec3d>{{1, 0.5, 0}});
  particles = files.read("a.ply", one + "property float r\nend_header\n1 2 3 4\n");
  CHECK(particles.radii == std::vector<double>{4});
  particles = files.read("a.ply", one +
                                      "property uchar r\nproperty uchar g\nproperty uchar b\n"
                                      "end_header\n1 2 3 4 0 255\n");
  CHECK(particles.radii.empty());
  CHECK(particles.colors == std::vector<Vec3d>{{srgb_decode(4.0 / 255), 0, 1}});
}

TEST_CASE("PLY's other properties, lists and elements are skipped, before and after vertices") {
  const ParticleFiles files;
  const std::string header = R"(
element camera 2
property list uchar int values
property double focus
element vertex 2
property list ushort double before
property float x
property float quality
property float y
property float z
property list uint8 uint8 after
element face 1
property list uchar int vertex_indices
end_header
)";
  const Particles ascii = files.read("a.ply", "ply\nformat ascii 1.0" + header + R"(2 7 8 0.5
0 nan
1 9.5 1 nan 2 3 0
0 4 x 5 6 3 1 2 3
3 0 1 1
)");
  const auto count = [](int n) { return bytes_of(static_cast<std::uint8_t>(n)); };
  const Particles binary = files.read(
      "b.ply", "ply\nformat binary_little_endian 1.0" + header +  //
                   count(2) + bytes_of(7) + bytes_of(8) + bytes_of(0.5) + count(0) + bytes_of(0.5) +
                   bytes_of(std::uint16_t{1}) + bytes_of(9.5) + bytes_of(1.0F) + bytes_of(NAN) +
                   bytes_of(2.0F) + bytes_of(3.0F) + count(0) +  //
                   bytes_of(std::uint16_t{0}) + bytes_of(4.0F) + bytes_of(9.0F) + bytes_of(5.0F) +
                   bytes_of(6.0F) + count(3) + "abc" +  //
                   count(3) + bytes_of(0) + bytes_of(1) + bytes_of(1));
  const std::vector<Vec3d> expected{{1, 2, 3}, {4, 5, 6}};
  CHECK(ascii.positions == expected);
  CHECK(binary.positions == expected);
}

TEST_CASE("PLY: numbers of vertices, as text and binary, and line ends of CR") {
  const ParticleFiles files;
  const std::string header =
      "element vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
      "property float Quality\nproperty uchar flag\n";
  const std::string text =
      "ply\nformat ascii 1.0\n" + header + "end_header\n1 2 3 0.5 7\n4 5 6 nan 8\n";
  std::string binary = "ply\nformat binary_little_endian 1.0\n" + header + "end_header\n";
  for (const float x : {1.0F, 2.0F, 3.0F, 0.5F}) binary += test::bytes_of(x);
  binary += "\x07";
  for (const float x : {4.0F, 5.0F, 6.0F, std::nanf("")}) binary += test::bytes_of(x);
  binary += "\x08";
  std::string returns = text;
  std::ranges::replace(returns, '\n', '\r');
  for (const std::string& bytes : {text, binary, returns}) {
    const auto file = files.write("a.ply", bytes);
    CHECK(read_particles(file).numbers.empty());
    const Particles particles = read_particles(file, everything);
    CHECK(particles.positions[1] == Vec3d{4, 5, 6});
    CHECK(names_of(particles) == "quality flag");
    CHECK(numbers_of(particles, "quality")[0] == 0.5);
    CHECK(std::isnan(numbers_of(particles, "quality")[1]));
    CHECK(numbers_of(particles, "flag") == std::vector<double>{7, 8});
  }
}

}  // namespace parray

#include <doctest/doctest.h>

#include <string>

#include "cli/input/particles/file_place.h"
#include "cli/input/scene_file/particle_source.h"
#include "cli/input/select/selection.h"
#include "common/base/error.h"
#include "tests/support/message_of.h"
#include "tests/support/particle_columns.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::unknown_number;

std::vector<double> radii(const std::string& scale, const std::vector<double>& masses) {
  Particles particles;
  particles.positions.resize(masses.size());
  particles.numbers.push_back({"mass", masses});
  apply(radius_scale_from(scale), particles);
  return particles.radii;
}

}  // namespace

TEST_CASE("a number of the particles becomes their radius") {
  CHECK(radii("mass", {1, 2.5, 1e-9}) == std::vector<double>{1, 2.5, 1e-9});
  CHECK(radii(" Mass ", {3}) == std::vector<double>{3});
}

TEST_CASE("LOW:HIGH maps the least and the largest number to these radii") {
  CHECK(radii("mass:0.5:2.5", {-10, 10, 0}) == std::vector<double>{0.5, 2.5, 1.5});
  CHECK(radii("mass:1:3", {7, 7}) == std::vector<double>{2, 2});
  CHECK(radii("mass:1:3", {-1.7e308, 1.7e308, 0}) == std::vector<double>{1, 3, 2});
}

TEST_CASE("numbers that are no radii are refused, and the message names the particle") {
  using test::message_of;
  CHECK(message_of<SourceError>([] {
          (void)radii("mass", {1, 0});
        }) ==
        "mass of particle 1 is 0, which is not a radius: write mass:LOW:HIGH to scale the numbers");
  CHECK(
      message_of<SourceError>([] { (void)radii("mass", {-1}); }).starts_with("mass of particle 0"));
  CHECK(message_of<SourceError>([] {
          (void)radii("mass:1:2", {1, 2, unknown_number});
        }) == "mass of particle 2 is not known: select particles with a known number");
  CHECK_THROWS_AS(radii("speed", {1}), UnknownNumber);
}

TEST_CASE("radii by index, and the particles that messages name, count removed particles") {
  Particles particles;
  particles.positions.resize(4);
  particles.numbers.push_back({"mass", {1, 2, 3, unknown_number}});
  keep(particles, {0, 0, 1, 1});
  CHECK(test::message_of<SourceError>([&] {
          apply(radius_scale_from("mass"), particles);
        }).starts_with("mass of particle 3 is not known"));
  apply(radius_scale_from("index"), particles);
  CHECK(particles.radii == std::vector<double>{2, 3});
}

TEST_CASE("texts of radii are read and written, others are refused") {
  for (const std::string text :
       {"mass", "mass:0.5:2", "z:1e-15:1e+15", "velocity:0", "velocity:1:0.5:2"}) {
    CHECK(text_of(radius_scale_from(text)) == text);
  }
  CHECK(radius_scale_from("velocity:1:0.5:2").by == "velocity:1");
  for (const std::string text :
       {"", ":1:2", "mass:", ":1", "mass:2:1", "mass:1:1", "mass:0:1", "mass:1:x", "mass:nan:2",
        "mass:1:1e16", "mass:1:3:2", "mass::1:2"}) {
    CAPTURE(text);
    CHECK_THROWS_AS(radius_scale_from(text), InputError);
  }
}

}  // namespace parray

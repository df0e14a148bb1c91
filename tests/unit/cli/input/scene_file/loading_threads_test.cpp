/// What is loaded does not depend on how many threads load it, nor on which way a text takes.

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "cli/input/scene_file/duplicates.h"
#include "cli/input/scene_file/scene_file.h"
#include "cli/input/scene_file/sphere_text.h"
#include "cli/input/view/auto_scene.h"
#include "common/base/bands.h"
#include "common/scene/origin.h"
#include "common/scene/requirements.h"
#include "common/scene/scene_bytes.h"
#include "tests/support/dice.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/scene_text.h"

namespace parray {
namespace {

using test::bytes_of;
using test::Dice;
using test::message_of;
using test::ParticleFiles;
using test::read_scene_text;
using test::small_scene;

constexpr std::array<int, 3> thread_counts{1, 2, 5};
constexpr std::size_t many = 200'000;  ///< bands for five threads, and several blocks of a file

Scene random_scene(const Vec3d& middle, std::size_t places) {
  Dice dice(7);
  std::vector<Sphere> kinds;
  for (std::size_t i = 0; i < places; ++i) {
    kinds.push_back({middle + dice.in_cube(50), dice.between(0.1, 2), 0});
  }
  Scene scene = small_scene();
  scene.spheres.clear();
  for (std::size_t i = 0; i < many; ++i) {
    scene.spheres.push_back(kinds[dice.below(places)]);
    scene.spheres.back().material = dice.below32(2);
  }
  return scene;
}

/// Rows of x, y, z, radius as floats and a colour of bytes. `bad`: rows whose radius is negative.
std::string ply(std::endian order, std::size_t rows, const std::vector<std::size_t>& bad = {}) {
  std::string bytes = std::string("ply\nformat binary_") +
                      (order == std::endian::little ? "little" : "big") +
                      "_endian 1.0\nelement vertex " + std::to_string(rows) +
                      "\nproperty float x\nproperty float y\nproperty float z\n"
                      "property double radius\nproperty uchar red\nproperty uchar green\n"
                      "property uchar blue\nend_header\n";
  Dice dice(3);
  for (std::size_t i = 0; i < rows; ++i) {
    const bool is_bad = std::ranges::find(bad, i) != bad.end();
    for (int axis = 0; axis < 3; ++axis) {
      bytes += bytes_of(static_cast<float>(dice.between(-9, 9)), order);
    }
    bytes += bytes_of(is_bad ? -1.0 : dice.between(0.1, 1), order);
    for (int channel = 0; channel < 3; ++channel) bytes += static_cast<char>(dice.below(5) * 60);
  }
  return bytes;
}

std::string scene_text(const std::string& spheres) {
  return R"({"version": 1, "camera": {"look_from": [0, 0, 9], "look_at": [0, 0, 0], "vfov": 40},
 "materials": {"a": {"type": "diffuse", "albedo": [1, 0, 0]},
               "b": {"type": "metal", "albedo": [0, 1, 0]}},
 "spheres": [)" +
         spheres + "]}";
}

/// Spheres as most files write them; with an escape in each name, the parser has to take them all.
std::string sphere_items(std::size_t count, bool escaped) {
  static constexpr std::array<const char*, 3> blanks{"", " ", "\n\t "};
  Dice dice(11);
  std::ostringstream out;
  out.precision(17);
  for (std::size_t i = 0; i < count; ++i) {
    const char* const blank = blanks.at(dice.below(3));
    const bool b = dice.one_in(2);
    const std::string name = escaped ? (b ? "\\u0062" : "\\u0061") : (b ? "b" : "a");
    const Vec3d p = dice.in_cube(dice.ten_to(-20, 14));
    const std::string material = "\"material\":" + (blank + ("\"" + name + "\""));
    out << (i > 0 ? "," : "") << blank << '{' << (b ? material + "," : "") << "\"center\"" << blank
        << ":[" << p.x << ',' << blank << p.y << blank << ',' << (i % 7 == 0 ? "-0" : "1E+2")
        << "]," << blank << "\"radius\":" << dice.ten_to(-3, 3) << (b ? "" : "," + material)
        << blank << '}';
  }
  return out.str();
}

}  // namespace

TEST_CASE("bands contain every item once for any number of threads, and throw the first error") {
  for (const int threads : thread_counts) {
    for (const std::size_t items : {std::size_t{0}, std::size_t{1}, std::size_t{90'001}}) {
      const Bands bands(items, threads);
      std::vector<int> seen(items);
      bands.run([&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) ++seen[i];
      });
      CHECK(std::ranges::count(seen, 1) == static_cast<std::ptrdiff_t>(items));
      CHECK(message_of<std::runtime_error>([&] {
              bands.run([](std::size_t band, std::size_t, std::size_t) {
                throw std::runtime_error(std::to_string(band));
              });
            }) == "0");
    }
  }
  CHECK(Bands(many, 5).count() == 5);
  CHECK(Bands(100, 5).count() == 1);
}

TEST_CASE("duplicates are the same for any number of threads and equal those of a full search") {
  const Scene scene = random_scene({}, many / 2);
  std::vector<Sphere> kept;
  std::set<std::array<double, 4>> places;
  for (const Sphere& sphere : scene.spheres) {
    const Vec3d& c = sphere.center;
    if (places.insert({c.x, c.y, c.z, sphere.radius}).second) kept.push_back(sphere);
  }
  REQUIRE(kept.size() < scene.spheres.size());
  for (const int threads : thread_counts) {
    Scene own = scene;
    const Duplicates found = remove_duplicates(own, threads);
    REQUIRE(own.spheres.size() == kept.size());
    CHECK(found.count == many - kept.size());
    CHECK(std::ranges::equal(own.spheres, kept, {}, &Sphere::center, &Sphere::center));
    CHECK(scene.spheres[found.first].center == scene.spheres[found.first_of].center);
  }
}

TEST_CASE("a million spheres in one place are one") {
  Scene scene = small_scene();
  scene.spheres.assign(1'000'000, {{1, 2, 3}, 1, 0});
  const Duplicates found = remove_duplicates(scene, 5);
  CHECK(scene.spheres.size() == 1);
  CHECK(found.count == 999'999);
  CHECK(found.first == 1);
  CHECK(found.first_of == 0);
}

TEST_CASE("requirements are the same for any number of threads") {
  for (const Vec3d& middle : {Vec3d{}, Vec3d{1e6, -2e6, 5e5}}) {
    Scene scene = random_scene(middle, many);
    scene.camera.look_from = middle + Vec3d{0, 0, 200};
    const Requirements one = requirements_of(scene);
    for (const int threads : thread_counts) {
      const Requirements r = requirements_of(scene, threads);
      CHECK(r.origin == one.origin);
      CHECK(r.extent == one.extent);
      CHECK(r.stored_shift == one.stored_shift);
      CHECK(r.nearest == one.nearest);
      CHECK(r.smallest_radius == one.smallest_radius);
      CHECK(r.largest_radius == one.largest_radius);
      CHECK(r.diffuse == one.diffuse);
      CHECK(r.metal == one.metal);
      CHECK(r.diffuse + r.metal == many);
    }
  }
}

TEST_CASE("the origin is the exact median, even where a sample of the spheres misleads") {
  const Vec3d far{1e6, 1e6, 1e6};
  Scene scene = random_scene(far, many);
  // Every sphere that a regular sample of this many would take is somewhere else.
  const std::size_t step = many / 4096;
  for (std::size_t i = 0; i < many; i += step) scene.spheres[i].center = far + Vec3d{-60, 70, 1e3};
  scene.camera.look_from = far;
  Vec3d middle;
  for (double Vec3d::*axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
    std::vector<double> values;
    for (const Sphere& sphere : scene.spheres) values.push_back(sphere.center.*axis);
    std::ranges::sort(values);
    middle.*axis = values[values.size() / 2];
  }
  for (const int threads : thread_counts) CHECK(scene_origin(scene, threads) == middle);
}

TEST_CASE("particles of binary PLY are the same for any number of threads and either byte order") {
  const ParticleFiles files;
  const auto path = files.write("p.ply", ply(std::endian::little, many));
  const Particles one = read_particles(path);
  REQUIRE(one.count() == many);
  for (const auto& other :
       {path, files.write("q.ply", ply(std::endian::big, many)),
        files.write("p.ply.gz", test::packed(ply(std::endian::little, many)))}) {
    for (const int threads : thread_counts) {
      const Particles particles = read_particles(other, {.threads = threads});
      CHECK(particles.positions == one.positions);
      CHECK(particles.radii == one.radii);
      CHECK(particles.colors == one.colors);
    }
  }
}

TEST_CASE("an automatic scene is the same for any number of threads") {
  const ParticleFiles files;
  const auto path = files.write("p.ply", ply(std::endian::little, many));
  const Scene one = auto_scene(path, {}, auto_scene_settings()).file.scene;
  for (const int threads : thread_counts) {
    CHECK(auto_scene(path, {}, auto_scene_settings(), {}, threads).file.scene == one);
  }
}

TEST_CASE("errors in binary PLY name the first invalid particle for any number of threads") {
  const ParticleFiles files;
  const std::size_t header = ply(std::endian::little, many).find("end_header\n") + 11;
  constexpr std::size_t row_bytes = 3 * 4 + 8 + 3;
  constexpr std::size_t last_property = 22;  // where the reader stands when it has read a row
  for (const std::size_t bad : {std::size_t{70'000}, std::size_t{140'000}, many - 2}) {
    const auto path = files.write("p.ply", ply(std::endian::little, many, {bad, many - 1}));
    const std::string place =
        "p.ply: byte " + std::to_string(header + bad * row_bytes + last_property) + ": radius -1 ";
    for (const int threads : thread_counts) {
      const std::string message =
          message_of<InputError>([&] { read_particles(path, {.threads = threads}); });
      CHECK(message.find(place) != std::string::npos);
    }
  }
}

TEST_CASE("the parser and the fast path read the same spheres from scene JSON") {
  const Scene quick = read_scene_text(scene_text(sphere_items(20'000, false))).scene;
  const Scene slow = read_scene_text(scene_text(sphere_items(20'000, true))).scene;
  CHECK(quick.spheres.size() == 20'000);
  CHECK(quick == slow);
  CHECK(scene_identity(quick) == scene_identity(slow));
}

TEST_CASE("after many spheres, the fast path reports errors like the parser") {
  for (const char* const fault :
       {R"(,{"center":[0,0,0],"radius":-1,"material":"a"})",
        R"(,{"center":[0,0,1e16],"radius":1,"material":"a"})",
        R"(,{"center":[0,0,01],"radius":1,"material":"a"})",
        R"(,{"center":[0,0,1.],"radius":1,"material":"a"})",
        R"(,{"center":[0,0,+1],"radius":1,"material":"a"})",
        R"(,{"center":[0,0],"radius":1,"material":"a"})",
        R"(,{"center":[0,0,0],"radius":1,"material":"none"})",
        R"(,{"center":[0,0,0],"radius":1,"radius":1})",
        R"(,{"center":[0,0,0],"radius":1,"material":"a","extra":1})",
        R"(,{"center":[0,0,0],"radius":1})", R"(,{"center":[0,0,0],"radius":nan,"material":"a"})",
        ",,", ",]", ",", R"(,{"center":[0,0,0)"}) {
    CAPTURE(fault);
    const auto message = [&](bool escaped) {
      const std::string text = scene_text(sphere_items(3'000, escaped) + fault);
      return message_of<InputError>([&] { read_scene_text(text); });
    };
    CHECK(message(false) != "no error");
    CHECK(message(false) == message(true));
  }
}

TEST_CASE("the fast path reads only valid spheres and leaves the rest to the parser") {
  const auto item = [](const std::string& number) {
    return R"(,{"center":[)" + number + R"(,0,0],"radius":1,"material":"a"})";
  };
  for (const char* const good : {"0", "-0", "1", "-12.5", "0.5e3", "1E-7", "1e+3", "1e15"}) {
    CAPTURE(good);
    const auto found = next_sphere_text(item(good));
    REQUIRE(found);
    CHECK(found->bytes == item(good).size());
    CHECK(found->sphere.center.x == std::stod(good));
  }
  for (const char* const bad : {"", "-", "+1", "01", ".5", "1.", "1e", "1e+", "0x1", "inf", "NaN",
                                "1e16", "1e999", "1 2", "\"1\"", "null", "[1]"}) {
    CAPTURE(bad);
    CHECK_FALSE(next_sphere_text(item(bad)));
  }
  const std::string whole = item("1");
  for (std::size_t cut = 0; cut < whole.size(); ++cut) {
    CHECK_FALSE(next_sphere_text(std::string_view(whole).substr(0, cut)));
  }
}

}  // namespace parray

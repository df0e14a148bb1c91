#include "common/scene/requirements.h"

#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

#include "common/scene/settings.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_materials.h"
#include "tests/support/shipped_scene.h"

namespace parray {
namespace {

using test::diffuse;
using test::glass;
using test::metal;
using test::shipped;
using Names = std::vector<std::string>;

/// A pinhole at the origin and nothing to see.
Scene empty_scene() {
  Scene scene;
  scene.camera.look_from = {0, 0, 0};
  scene.camera.aperture = 0;
  scene.camera.tan_half_vfov = 0.25;
  return scene;
}

Scene with_spheres(const std::vector<Material>& materials, const std::vector<Sphere>& spheres) {
  Scene scene = empty_scene();
  scene.materials = materials;
  scene.spheres = spheres;
  return scene;
}

RenderSettings resolved(const Scene& scene, const RenderSettings& asked = {}) {
  return resolve_settings(requirements_of(scene), asked).settings;
}

/// A speck around which the largest number is `spread` of its radii, in a wide view.
Scene of_spread(double spread) {
  Scene scene = with_spheres({diffuse(0.5)}, {{{0, 0, 0}, 1 / spread, 0}, {{0, 1, 0}, 0.5, 0}});
  scene.camera.tan_half_vfov = 1e6;
  return scene;
}

}  // namespace

TEST_CASE("requirements count the spheres of each kind") {
  const Scene scene = with_spheres({diffuse(0.5), metal(0), glass(1.5)}, {{{0, 0, 0}, 1, 0},
                                                                          {{1, 0, 0}, 1, 1},
                                                                          {{2, 0, 0}, 1, 1},
                                                                          {{3, 0, 0}, 1, 2},
                                                                          {{4, 0, 0}, 1, 0},
                                                                          {{5, 0, 0}, 1, 0}});
  const Requirements r = requirements_of(scene);
  CHECK(r.spheres == 6);
  CHECK(r.diffuse == 3);
  CHECK(r.metal == 2);
  CHECK(r.dielectric == 1);
}

TEST_CASE("an empty scene requires nothing") {
  const Requirements r = requirements_of(empty_scene());
  CHECK(r.spheres == 0);
  CHECK(r.features().empty());
  CHECK(r.smallest_radius == 0);
  CHECK(r.largest_radius == 0);
  CHECK_FALSE(r.one_radius);
  CHECK(r.spread() == 0);
  CHECK(resolved(empty_scene()).precision == Precision::f32);
}

TEST_CASE("each feature is there when the scene has it and not otherwise") {
  const auto features = [](const Scene& scene) { return requirements_of(scene).features(); };
  CHECK(features(with_spheres({diffuse(0.5)}, {{{0, 0, 0}, 1, 0}})) == Names{"diffuse"});
  CHECK(features(with_spheres({metal(0)}, {{{0, 0, 0}, 1, 0}})) == Names{"metal"});
  CHECK(features(with_spheres({metal(0.1)}, {{{0, 0, 0}, 1, 0}})) == Names{"metal", "fuzz"});
  CHECK(features(with_spheres({glass(1.5)}, {{{0, 0, 0}, 1, 0}})) == Names{"dielectric"});
  CHECK(features(with_spheres({diffuse(0.5)}, {{{0, 0, 0}, 1, 0}, {{3, 0, 0}, 2, 0}})) ==
        Names{"diffuse", "many-radii"});
  Scene lens = empty_scene();
  lens.camera.aperture = 0.1;
  CHECK(features(lens) == Names{"lens"});
  // A material that no sphere wears costs nothing.
  CHECK(features(with_spheres({diffuse(0.5), metal(1), glass(1.5)}, {{{0, 0, 0}, 1, 0}})) ==
        Names{"diffuse"});
}

TEST_CASE("one radius is recognised exactly") {
  CHECK(requirements_of(with_spheres({diffuse(0.5)}, {{{0, 0, 0}, 0.1, 0}, {{1, 0, 0}, 0.1, 0}}))
            .one_radius);
  CHECK_FALSE(
      requirements_of(with_spheres({diffuse(0.5)},
                                   {{{0, 0, 0}, 0.1, 0}, {{1, 0, 0}, std::nextafter(0.1, 1), 0}}))
          .one_radius);
}

TEST_CASE("the extent is the largest number among centres, radii, the eye and its lens") {
  Scene scene = with_spheres({diffuse(0.5)}, {{{-3, 1, 2}, 0.5, 0}, {{0, 0, 0}, 2, 0}});
  CHECK(requirements_of(scene).extent == 3);
  CHECK(requirements_of(scene).smallest_radius == 0.5);
  CHECK(requirements_of(scene).largest_radius == 2);
  CHECK(requirements_of(scene).spread() == 6);
  CHECK(requirements_of(scene).computed_shift() == 3 * 0x1p-24);
  scene.spheres[1].radius = 4;
  CHECK(requirements_of(scene).extent == 4);
  scene.camera.look_from = {1, -9, 2};
  CHECK(requirements_of(scene).extent == 9);
  scene.camera.aperture = 2;
  CHECK(requirements_of(scene).extent == 10);
}

TEST_CASE("the nearest surface is measured from the eye, out of a sphere or inside it") {
  Scene scene = with_spheres({diffuse(0.5)}, {{{0, 0, -5}, 1, 0}, {{0, 0, 0}, 7, 0}});
  scene.camera.tan_half_vfov = 0.25;
  CHECK(requirements_of(scene).nearest == 4);
  CHECK(requirements_of(scene).view_height == 2);
  scene.camera.look_from = {0, 0, 6.5};
  CHECK(requirements_of(scene).nearest == 0.5);
  CHECK(requirements_of(empty_scene()).nearest == 0);
}

TEST_CASE("what storing in single precision moves is found in every coordinate and the radius") {
  const double moved = 1 + 0x1p-26;
  const Scene exact = with_spheres({diffuse(0.5)}, {{{1, 2, 3}, 1, 0}, {{0.5, -8, 0}, 0.25, 0}});
  CHECK(requirements_of(exact).stored_shift == 0);
  for (int place = 0; place < 4; ++place) {
    Scene scene = exact;
    Sphere& last = scene.spheres[1];
    (place == 0   ? last.center.x
     : place == 1 ? last.center.y
     : place == 2 ? last.center.z
                  : last.radius) = moved;
    CHECK(requirements_of(scene).stored_shift == 0x1p-26);
  }
}

TEST_CASE(
    "automatic precision: f32 while computing moves surfaces by 2^-8 of the smallest radius") {
  CHECK(resolved(of_spread(0x1p16)).precision == Precision::f32);
  CHECK(resolved(of_spread(0x1p17)).precision == Precision::mixed);
  Scene border = of_spread(0x1p16);
  border.spheres[0].radius = std::nextafter(border.spheres[0].radius, 0);
  CHECK(requirements_of(border).spread() > 0x1p16);
  CHECK(resolved(border).precision == Precision::mixed);
}

TEST_CASE("automatic precision: f32 while computing moves them by 2^-13 of the nearest view") {
  Scene scene = with_spheres({diffuse(0.5)}, {{{0, 0, -2}, 1, 0}});  // extent 2, nearest 1
  scene.camera.tan_half_vfov = 0x1p-11;
  CHECK(requirements_of(scene).computed_shift() == 0x1p-13 * requirements_of(scene).view_height);
  CHECK(resolved(scene).precision == Precision::f32);
  scene.camera.tan_half_vfov = std::nextafter(0x1p-11, 0);
  CHECK(resolved(scene).precision == Precision::mixed);
}

TEST_CASE("automatic precision: where storing in single precision would be seen, it is f64") {
  Scene scene = of_spread(0x1p17);
  scene.spheres[1].center.x = 0x1p-25 + 0x1p-49;  // moved by 2^-49, unseen
  CHECK(requirements_of(scene).stored_shift == 0x1p-49);
  CHECK(resolved(scene).precision == Precision::mixed);
  scene.spheres[1].center.y += 0x1p-25;  // by 2^-25: 2^-8 of the smallest radius
  CHECK(resolved(scene).precision == Precision::mixed);
  scene.spheres[1].center.y += 0x1p-50;
  CHECK(resolved(scene).precision == Precision::f64);
  // Nor is it when the view is narrow.
  Scene narrow = with_spheres({diffuse(0.5)}, {{{0, 0, -2}, 1 + 0x1p-25, 0}});
  narrow.camera.tan_half_vfov = 0x1p-15;
  CHECK(resolved(narrow).precision == Precision::f64);
  narrow.spheres[0].radius = 1;
  CHECK(resolved(narrow).precision == Precision::mixed);
}

TEST_CASE("an eye on a surface gets the precision that leaves the surface where it is") {
  Scene scene = with_spheres({diffuse(0.5)}, {{{0, 0, -1}, 1, 0}});
  CHECK(requirements_of(scene).view_height == 0);
  CHECK(resolved(scene).precision == Precision::mixed);
  scene.spheres.push_back({{9, 0.1, 0}, 1, 0});
  CHECK(resolved(scene).precision == Precision::f64);
}

TEST_CASE("precision does not depend on the scene's unit or on where its camera looks") {
  for (const double scale : {0x1p-30, 1.0, 0x1p30}) {
    for (const double spread : {0x1p10, 0x1p16, 0x1p20}) {
      Scene scene = of_spread(spread);
      for (Sphere& sphere : scene.spheres) {
        sphere.center = scale * sphere.center;
        sphere.radius *= scale;
      }
      CHECK(resolved(scene).precision == resolved(of_spread(spread)).precision);
    }
  }
}

TEST_CASE("a distant camera asks for double arithmetic") {
  Scene scene = with_spheres({diffuse(0.5)}, {{{0, 0, 0}, 1, 0}});
  scene.camera.look_from = {0, 0, 1e6};
  CHECK(resolved(scene).precision == Precision::mixed);
}

TEST_CASE("what the user asks for is never overruled") {
  RenderSettings asked;
  asked.precision = Precision::f32;
  asked.accelerator = AcceleratorKind::linear;
  asked.row_order = RowOrder::sequential;
  const auto result = resolve_settings(requirements_of(of_spread(0x1p20)), asked);
  CHECK(result.settings == asked);
  CHECK(result.precision_reason == "asked for");
  CHECK(result.accelerator_reason == "asked for");
  asked.accelerator = AcceleratorKind::bvh;
  CHECK(resolved(empty_scene(), asked).accelerator == AcceleratorKind::bvh);
}

TEST_CASE("the reasons name the numbers in plain words") {
  const auto reasons = [](const Scene& scene) {
    return resolve_settings(requirements_of(scene), {});
  };
  CHECK(reasons(of_spread(0x1p17)).precision_reason ==
        "computing in single precision would move surfaces by up to 5.96e-08, 1/128 of the "
        "smallest radius (invisible up to 1/256); storing in it moves them by 0");
  CHECK(reasons(of_spread(8)).precision_reason ==
        "computing in single precision moves surfaces by up to 5.96e-08, less than a millionth of "
        "the smallest radius (invisible up to 1/256)");
  Scene narrow = with_spheres({diffuse(0.5)}, {{{0, 0, -2}, 1.1, 0}});
  narrow.camera.tan_half_vfov = 1e-9;
  CHECK(reasons(narrow).precision_reason ==
        "storing in single precision would move surfaces by up to 2.38e-08, 13.2 times the "
        "picture's height at the nearest surface (invisible up to 1/8192)");
  CHECK(reasons(empty_scene()).precision_reason == "no shapes");
  CHECK(reasons(of_spread(0x1p17)).accelerator_reason.find("2 spheres") != std::string::npos);
}

TEST_CASE("a handful of spheres is searched in line, more through the hierarchy") {
  std::vector<Sphere> spheres;
  AcceleratorKind last = AcceleratorKind::linear;
  int changes = 0;
  for (int count = 0; count <= 100; ++count) {
    const AcceleratorKind kind = resolved(with_spheres({diffuse(0.5)}, spheres)).accelerator;
    CHECK(kind != AcceleratorKind::automatic);
    changes += kind != last ? 1 : 0;
    last = kind;
    spheres.push_back({{static_cast<double>(count), 0, 0}, 0.5, 0});
  }
  CHECK(last == AcceleratorKind::bvh);
  CHECK(changes == 1);
}

TEST_CASE("rows are interleaved with the weighted policy only, unless asked for") {
  for (const SchedulePolicy policy :
       {SchedulePolicy::static_split, SchedulePolicy::guided, SchedulePolicy::factoring}) {
    RenderSettings asked;
    asked.schedule = policy;
    CHECK(resolved(empty_scene(), asked).row_order == RowOrder::sequential);
    asked.row_order = RowOrder::interleaved;
    CHECK(resolved(empty_scene(), asked).row_order == RowOrder::interleaved);
  }
  CHECK(resolved(empty_scene()).row_order == RowOrder::interleaved);
}

TEST_CASE("resolving twice changes nothing more, and leaves the rest alone") {
  RenderSettings asked;
  asked.width = 7;
  asked.height = 9;
  asked.samples_per_pixel = 11;
  asked.max_depth = 13;
  asked.seed = 17;
  const RenderSettings once = resolved(of_spread(0x1p20), asked);
  CHECK(resolved(of_spread(0x1p20), once) == once);
  RenderSettings back = once;
  back.precision = asked.precision;
  back.accelerator = asked.accelerator;
  back.row_order = asked.row_order;
  CHECK(back == asked);
}

TEST_CASE("the shipped scenes require what they show") {
  const auto of = [](const std::string& name) { return requirements_of(shipped(name).scene); };
  const Requirements weekend = of("one-weekend-484.json");
  CHECK(weekend.spheres == 484);
  CHECK(weekend.diffuse + weekend.metal + weekend.dielectric == 484);
  CHECK(weekend.features() ==
        Names{"diffuse", "metal", "fuzz", "dielectric", "lens", "many-radii"});
  CHECK(of("furnace.json").features() ==
        Names{"diffuse", "metal", "dielectric", "lens", "many-radii"});
}

}  // namespace parray

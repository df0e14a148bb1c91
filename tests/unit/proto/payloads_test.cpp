#include "proto/payloads.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <memory>
#include <utility>

#include "tests/support/rooms.h"

namespace parray {
namespace {

std::uint64_t size_of(Scene scene) {
  return ScenePayload(std::make_shared<const Scene>(std::move(scene))).size();
}

}  // namespace

TEST_CASE("the size of a scene includes its spheres, capsules and materials") {
  const std::uint64_t empty = size_of({});
  Scene scene;
  scene.materials.resize(10);
  CHECK(size_of(scene) == empty + 10 * sizeof(Material));
  scene.materials.clear();
  scene.spheres.resize(10);
  CHECK(size_of(scene) == empty + 10 * sizeof(Sphere));
  scene.spheres.clear();
  scene.capsules.resize(10);
  CHECK(size_of(scene) == empty + 10 * sizeof(Capsule));
}

TEST_CASE("a payload has a size if it holds a scene, even one without shapes") {
  CHECK(ScenePayload().size() == 0);
  CHECK(size_of({}) > 0);
}

}  // namespace parray

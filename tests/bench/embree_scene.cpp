#include "tests/bench/embree_scene.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "tests/bench/bench.h"

namespace parray::peer {
namespace {

/// The lowest 21 bits, two zeros after each.
std::uint64_t spread_bits(std::uint64_t x) {
  x = (x | x << 32) & 0x001F00000000FFFF;
  x = (x | x << 16) & 0x001F0000FF0000FF;
  x = (x | x << 8) & 0x100F00F00F00F00F;
  x = (x | x << 4) & 0x10C30C30C30C30C3;
  return (x | x << 2) & 0x1249249249249249;
}

Vec3d center_of(const Sphere& sphere) { return sphere.center; }
Vec3d center_of(const Capsule& capsule) { return 0.5 * (capsule.from + capsule.to); }

/// Indices of the shapes along a Morton curve through the box of their centres.
template <typename Shape>
std::vector<std::uint32_t> morton_order(const std::vector<Shape>& spheres) {
  Vec3d lo = center_of(spheres.front());
  Vec3d hi = lo;
  for (const Shape& sphere : spheres) {
    const Vec3d c = center_of(sphere);
    lo = {std::min(lo.x, c.x), std::min(lo.y, c.y), std::min(lo.z, c.z)};
    hi = {std::max(hi.x, c.x), std::max(hi.y, c.y), std::max(hi.z, c.z)};
  }
  const double cells = 0x1p21 - 1;
  const double scale = cells / std::max({hi.x - lo.x, hi.y - lo.y, hi.z - lo.z, 0x1p-100});
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys(spheres.size());
  for (std::uint32_t i = 0; i < spheres.size(); ++i) {
    const auto cell = [scale](double x) {
      return spread_bits(static_cast<std::uint64_t>(scale * x));
    };
    const Vec3d from = center_of(spheres[i]) - lo;
    keys[i] = {cell(from.x) | cell(from.y) << 1 | cell(from.z) << 2, i};
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::uint32_t> order;
  order.reserve(keys.size());
  for (const auto& [code, index] : keys) order.push_back(index);
  return order;
}

float* put_vertex(const Vec3d& center, double radius, float* to) {
  const auto point = vec_cast<float>(center);
  *to++ = point.x;
  *to++ = point.y;
  *to++ = point.z;
  *to++ = static_cast<float>(radius);
  return to;
}

}  // namespace

#if !defined(PARRAY_PEER_ISA)
#define PARRAY_PEER_ISA ""
#endif

EmbreeScene::EmbreeScene(const Scene& scene)
    : device_(rtcNewDevice(PARRAY_PEER_ISA "threads=1,hugepages=1")) {
  const FlushDenormals mode;
  check();
  rtcSetDeviceMemoryMonitorFunction(device_, count_memory, this);
  scene_ = rtcNewScene(device_);
  rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_NONE);
  rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
  const bool curves = scene.spheres.empty();
  RTCGeometry geometry = rtcNewGeometry(
      device_, curves ? RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE : RTC_GEOMETRY_TYPE_SPHERE_POINT);
  if (curves) {
    fill(scene.capsules, geometry);
  } else {
    fill(scene.spheres, geometry);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_, geometry);
  rtcReleaseGeometry(geometry);
  const double begin = bench::cpu_seconds();
  rtcCommitScene(scene_);
  build_seconds_ = bench::cpu_seconds() - begin;
  check();
}

EmbreeScene::~EmbreeScene() {
  rtcReleaseScene(scene_);
  rtcReleaseDevice(device_);
}

bool EmbreeScene::count_memory(void* self, ssize_t bytes, bool) {
  auto& scene = *static_cast<EmbreeScene*>(self);
  scene.bytes_ += static_cast<std::size_t>(bytes);  // a negative change wraps round, as it should
  scene.peak_bytes_ = std::max(scene.peak_bytes_, scene.bytes_);
  return true;
}

float* EmbreeScene::vertices(RTCGeometry geometry, std::size_t count) const {
  auto* const vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 4 * sizeof(float), count));
  check();
  return vertices;
}

void EmbreeScene::fill(const std::vector<Sphere>& spheres, RTCGeometry geometry) {
  float* vertex = vertices(geometry, spheres.size());
  material_of_.reserve(spheres.size());
  for (const std::uint32_t index : morton_order(spheres)) {
    const Sphere& sphere = spheres[index];
    vertex = put_vertex(sphere.center, sphere.radius, vertex);
    material_of_.push_back(sphere.material);
  }
}

void EmbreeScene::fill(const std::vector<Capsule>& capsules, RTCGeometry geometry) {
  float* vertex = vertices(geometry, 2 * capsules.size());
  auto* first = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, sizeof(std::uint32_t), capsules.size()));
  check();
  material_of_.reserve(capsules.size());
  for (const std::uint32_t index : morton_order(capsules)) {
    const Capsule& capsule = capsules[index];
    vertex = put_vertex(capsule.from, capsule.radius, vertex);
    vertex = put_vertex(capsule.to, capsule.radius, vertex);
    *first++ = static_cast<std::uint32_t>(2 * material_of_.size());
    material_of_.push_back(capsule.material);
  }
}

void EmbreeScene::check() const {
  const RTCError error = rtcGetDeviceError(device_);
  if (error != RTC_ERROR_NONE) throw std::runtime_error("Embree: error " + std::to_string(error));
}

}  // namespace parray::peer

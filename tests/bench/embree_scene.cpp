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

/// Indices of the spheres along a Morton curve through the box of their centres.
std::vector<std::uint32_t> morton_order(const std::vector<Sphere>& spheres) {
  Vec3d lo = spheres.front().center;
  Vec3d hi = lo;
  for (const Sphere& sphere : spheres) {
    const Vec3d& c = sphere.center;
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
    const Vec3d from = spheres[i].center - lo;
    keys[i] = {cell(from.x) | cell(from.y) << 1 | cell(from.z) << 2, i};
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::uint32_t> order;
  order.reserve(keys.size());
  for (const auto& [code, index] : keys) {
    order.push_back(index);
  }
  return order;
}

}  // namespace

#if !defined(PARRAY_PEER_ISA)
#define PARRAY_PEER_ISA ""
#endif

EmbreeScene::EmbreeScene(const std::vector<Sphere>& spheres)
    : device_(rtcNewDevice(PARRAY_PEER_ISA "threads=1,hugepages=1")) {
  const FlushDenormals mode;
  check();
  rtcSetDeviceMemoryMonitorFunction(device_, count_memory, this);
  scene_ = rtcNewScene(device_);
  rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_NONE);
  rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
  RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_SPHERE_POINT);
  fill(spheres, geometry);
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

void EmbreeScene::fill(const std::vector<Sphere>& spheres, RTCGeometry geometry) {
  auto* vertex = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 4 * sizeof(float), spheres.size()));
  check();
  material_of_.reserve(spheres.size());
  for (const std::uint32_t index : morton_order(spheres)) {
    const Sphere& sphere = spheres[index];
    const auto center = vec_cast<float>(sphere.center);
    *vertex++ = center.x;
    *vertex++ = center.y;
    *vertex++ = center.z;
    *vertex++ = static_cast<float>(sphere.radius);
    material_of_.push_back(sphere.material);
  }
}

void EmbreeScene::check() const {
  const RTCError error = rtcGetDeviceError(device_);
  if (error != RTC_ERROR_NONE) {
    throw std::runtime_error("Embree: error " + std::to_string(error));
  }
}

}  // namespace parray::peer

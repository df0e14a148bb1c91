#include "common/scene/scene_bytes.h"

#include <array>
#include <bit>
#include <cstring>
#include <span>

#include "common/base/bytes.h"
#include "common/base/sha256.h"
#include "common/math/largest_component.h"
#include "common/scene/limits.h"

namespace parray::scene {
namespace {

/// The first bytes of a scene, before a digit.
constexpr std::string_view magic = "PRSCENE";
constexpr std::size_t material_bytes = 1 + 5 * sizeof(double);
/// Bounds for the tangents of the readers' range of vfov, with some room.
constexpr double least_tangent = 1e-9;
constexpr double largest_tangent = 1e6;

/// Hashes its input and never holds more than a part of it.
class HashWriter {
 public:
  template <typename T>
  void put(T value) {
    const auto raw = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
    put_raw(raw);
  }
  void put_bytes(std::string_view bytes) { put_raw(as_byte_span(bytes)); }
  std::string hex() {
    flush();
    return hash_.hex();
  }

 private:
  void put_raw(std::span<const std::byte> raw) {
    if (fill_ + raw.size() > part_.size()) flush();
    std::memcpy(part_.data() + fill_, raw.data(), raw.size());
    fill_ += raw.size();
  }
  void flush() {
    hash_.add(std::span(part_).first(fill_));
    fill_ = 0;
  }

  Sha256 hash_;
  std::array<std::byte, 1 << 14> part_;
  std::size_t fill_ = 0;
};

void put_vec(auto& out, const Vec3d& v) {
  out.put(v.x);
  out.put(v.y);
  out.put(v.z);
}

double get_number(ByteReader& in, double lowest, double highest) {
  const auto value = in.get<double>();
  if (!(value >= lowest && value <= highest)) throw DecodeError("scene: a number is out of range");
  return value;
}

Vec3d get_vec(ByteReader& in, double lowest, double highest) {
  Vec3d v;
  v.x = get_number(in, lowest, highest);
  v.y = get_number(in, lowest, highest);
  v.z = get_number(in, lowest, highest);
  return v;
}

/// The form of a scene's bytes, which their first digit tells.
struct Form {
  Projection projection = Projection::perspective;
  bool capsules = false;

  [[nodiscard]] char digit() const {
    return static_cast<char>('1' + (projection == Projection::orthographic ? 1 : 0) +
                             (capsules ? 2 : 0));
  }
};

Form get_form(ByteReader& in) {
  const std::string_view start = in.get_bytes(magic.size() + 1);
  for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
    for (const bool capsules : {false, true}) {
      const Form form{projection, capsules};
      if (start == std::string(magic) + form.digit()) return form;
    }
  }
  throw DecodeError(
      "scene: the data do not begin with PRSCENE1 to PRSCENE4: use the same version of ParRay on "
      "all machines");
}

Camera get_camera(ByteReader& in, Projection projection) {
  constexpr double reach = limits::max_length;
  Camera camera;
  camera.projection = projection;
  camera.look_from = get_vec(in, -reach, reach);
  camera.look_at = get_vec(in, -reach, reach);
  camera.up = get_vec(in, -reach, reach);
  const bool parallel = projection == Projection::orthographic;
  camera.view_height = parallel ? get_number(in, limits::min_radius, reach) : 0;
  camera.vfov = parallel ? 0 : get_number(in, 0, 180);
  camera.aperture = get_number(in, 0, reach);
  camera.focus_distance = get_number(in, limits::min_radius, reach);
  camera.tan_half_vfov = parallel ? 0 : get_number(in, least_tangent, largest_tangent);
  const Vec3d back = camera.look_from - camera.look_at;
  if (!(length(back) > 0) || !(length(cross(camera.up, back)) > 0)) {
    throw DecodeError("scene: impossible camera");
  }
  return camera;
}

Material get_material(ByteReader& in) {
  Material material;
  const auto type = in.get<std::uint8_t>();
  if (type > static_cast<std::uint8_t>(MaterialType::dielectric)) {
    throw DecodeError("scene: unknown material type");
  }
  material.type = static_cast<MaterialType>(type);
  material.albedo = get_vec(in, 0, 1);
  material.fuzz = get_number(in, 0, 1);
  material.ior = get_number(in, limits::min_radius, limits::max_length);
  return material;
}

Sphere get_sphere(ByteReader& in, std::size_t material_count) {
  Sphere sphere;
  sphere.center = get_vec(in, -limits::max_length, limits::max_length);
  sphere.radius = get_number(in, limits::min_radius, limits::max_length);
  sphere.material = in.get<std::uint32_t>();
  if (sphere.material >= material_count) {
    throw DecodeError("scene: the material of a sphere does not exist");
  }
  return sphere;
}

Capsule get_capsule(ByteReader& in, std::size_t material_count) {
  constexpr double reach = limits::max_length;
  Capsule capsule;
  capsule.from = get_vec(in, -reach, reach);
  capsule.to = get_vec(in, -reach, reach);
  capsule.radius = get_number(in, limits::min_radius, reach);
  capsule.material = in.get<std::uint32_t>();
  if (capsule.material >= material_count) {
    throw DecodeError("scene: the material of a capsule does not exist");
  }
  if (!has_valid_ends(capsule)) {
    throw DecodeError("scene: the ends of a capsule are too near to each other");
  }
  return capsule;
}

/// Reads a count that fits the remaining bytes, so that a false count cannot cause a large
/// allocation.
std::size_t get_count(ByteReader& in, std::uint64_t most, std::size_t item_bytes) {
  const auto count = in.get<std::uint64_t>();
  if (count > most || count > in.left() / item_bytes) {
    throw DecodeError("scene: a count exceeds its limit or the data that follows");
  }
  return static_cast<std::size_t>(count);
}

void put_camera(auto& out, const Camera& camera) {
  const bool parallel = camera.projection == Projection::orthographic;
  put_vec(out, camera.look_from);
  put_vec(out, camera.look_at);
  put_vec(out, camera.up);
  out.put(parallel ? camera.view_height : camera.vfov);
  out.put(camera.aperture);
  out.put(camera.focus_distance);
  if (!parallel) out.put(camera.tan_half_vfov);
}

void put_scene(auto& out, const Scene& scene) {
  out.put_bytes(magic);
  out.put(Form{scene.camera.projection, !scene.capsules.empty()}.digit());
  put_camera(out, scene.camera);
  put_vec(out, scene.sky.horizon);
  put_vec(out, scene.sky.zenith);
  out.put(static_cast<std::uint64_t>(scene.materials.size()));
  for (const Material& material : scene.materials) {
    out.put(static_cast<std::uint8_t>(material.type));
    put_vec(out, material.albedo);
    out.put(material.fuzz);
    out.put(material.ior);
  }
  out.put(static_cast<std::uint64_t>(scene.spheres.size()));
  for (const Sphere& sphere : scene.spheres) {
    put_vec(out, sphere.center);
    out.put(sphere.radius);
    out.put(sphere.material);
  }
  if (scene.capsules.empty()) return;
  out.put(static_cast<std::uint64_t>(scene.capsules.size()));
  for (const Capsule& capsule : scene.capsules) {
    put_vec(out, capsule.from);
    put_vec(out, capsule.to);
    out.put(capsule.radius);
    out.put(capsule.material);
  }
}

}  // namespace

bool has_valid_ends(const Capsule& capsule) {
  return capsule.from == capsule.to ||
         largest_component(capsule.to - capsule.from) >= 2 * limits::min_radius;
}

std::string scene_to_bytes(const Scene& scene) {
  ByteWriter out;
  out.reserve(256 + material_bytes * scene.materials.size() +
              scene_bytes_of_sphere * scene.spheres.size() +
              scene_bytes_of_capsule * scene.capsules.size());
  put_scene(out, scene);
  return out.take();
}

Scene scene_from_bytes(std::string_view bytes) {
  ByteReader in(bytes);
  Scene scene;
  const Form form = get_form(in);
  scene.camera = get_camera(in, form.projection);
  scene.sky.horizon = get_vec(in, 0, limits::max_radiance);
  scene.sky.zenith = get_vec(in, 0, limits::max_radiance);
  const std::size_t material_count = get_count(in, limits::max_materials, material_bytes);
  scene.materials.reserve(material_count);
  for (std::size_t i = 0; i < material_count; ++i) scene.materials.push_back(get_material(in));
  const std::size_t sphere_count = get_count(in, limits::max_shapes, scene_bytes_of_sphere);
  scene.spheres.reserve(sphere_count);
  for (std::size_t i = 0; i < sphere_count; ++i) {
    scene.spheres.push_back(get_sphere(in, material_count));
  }
  if (form.capsules) {
    const std::size_t capsule_count =
        get_count(in, limits::max_shapes - sphere_count, scene_bytes_of_capsule);
    if (capsule_count == 0) throw DecodeError("scene: a list of capsules is empty");
    scene.capsules.reserve(capsule_count);
    for (std::size_t i = 0; i < capsule_count; ++i) {
      scene.capsules.push_back(get_capsule(in, material_count));
    }
  }
  in.expect_end();
  return scene;
}

std::string scene_identity(std::string_view scene_bytes) {
  return sha256_hex(as_byte_span(scene_bytes));
}

std::string scene_identity(const Scene& scene) {
  HashWriter out;
  put_scene(out, scene);
  return out.hex();
}

}  // namespace parray::scene

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

/// Writes the parts of a scene. `Out`: a ByteWriter or HashWriter.
template <typename Out>
struct SceneWriter {
  Out& out;

  void plain(const auto& value) { out.put(value); }
  void number(double value, double /*least*/, double /*most*/) { out.put(value); }
  void check(bool /*good*/, const char* /*fault*/) {}
  void list(const auto& items, std::uint64_t /*most*/, std::size_t /*item_bytes*/,
            const auto& put) {
    out.put(static_cast<std::uint64_t>(items.size()));
    for (const auto& item : items) put(item);
  }
};

/// Reads the parts of a scene. Throws DecodeError if a check fails.
struct SceneReader {
  ByteReader in;

  void plain(auto& value) { in.numbers(value); }
  void number(double& value, double least, double most) {
    in.numbers(value);
    check(value >= least && value <= most, "a number is out of range");
  }
  // Not static, like that of SceneWriter.
  // NOLINTNEXTLINE(readability-convert-member-functions-to-static)
  void check(bool good, const char* fault) {
    if (!good) throw DecodeError(std::string("scene: ") + fault);
  }
  /// Checks that the count fits the remaining bytes, so that a false count cannot cause a large
  /// allocation.
  void list(auto& items, std::uint64_t most, std::size_t item_bytes, const auto& get) {
    const auto count = in.get<std::uint64_t>();
    check(count <= most && count <= in.left() / item_bytes,
          "a count exceeds its limit or the data that follows");
    items.reserve(count);
    for (std::uint64_t i = 0; i < count; ++i) get(items.emplace_back());
  }
};

// The parts of a scene in the order of its bytes, with the checks of a reader. `io` is a
// SceneWriter or a SceneReader.

void pass_vec(auto& io, auto& v, double least, double most) {
  io.number(v.x, least, most);
  io.number(v.y, least, most);
  io.number(v.z, least, most);
}

void pass_camera(auto& io, auto& camera) {
  constexpr double reach = limits::max_length;
  const bool parallel = camera.projection == Projection::orthographic;
  pass_vec(io, camera.look_from, -reach, reach);
  pass_vec(io, camera.look_at, -reach, reach);
  pass_vec(io, camera.up, -reach, reach);
  if (parallel) {
    io.number(camera.view_height, limits::min_radius, reach);
  } else {
    io.number(camera.vfov, 0, 180);
  }
  io.number(camera.aperture, 0, reach);
  io.number(camera.focus_distance, limits::min_radius, reach);
  if (!parallel) io.number(camera.tan_half_vfov, least_tangent, largest_tangent);
  const Vec3d back = camera.look_from - camera.look_at;
  io.check(length(back) > 0 && length(cross(camera.up, back)) > 0, "impossible camera");
}

void pass_material(auto& io, auto& material) {
  io.plain(material.type);
  io.check(material.type <= MaterialType::dielectric, "unknown material type");
  pass_vec(io, material.albedo, 0, 1);
  io.number(material.fuzz, 0, 1);
  io.number(material.ior, limits::min_radius, limits::max_length);
}

void pass_sphere(auto& io, auto& sphere, std::size_t material_count) {
  pass_vec(io, sphere.center, -limits::max_length, limits::max_length);
  io.number(sphere.radius, limits::min_radius, limits::max_length);
  io.plain(sphere.material);
  io.check(sphere.material < material_count, "the material of a sphere does not exist");
}

void pass_capsule(auto& io, auto& capsule, std::size_t material_count) {
  constexpr double reach = limits::max_length;
  pass_vec(io, capsule.from, -reach, reach);
  pass_vec(io, capsule.to, -reach, reach);
  io.number(capsule.radius, limits::min_radius, reach);
  io.plain(capsule.material);
  io.check(capsule.material < material_count, "the material of a capsule does not exist");
  io.check(has_valid_ends(capsule), "the ends of a capsule are too near to each other");
}

void pass_scene(auto& io, auto& scene, bool capsules) {
  pass_camera(io, scene.camera);
  pass_vec(io, scene.sky.horizon, 0, limits::max_radiance);
  pass_vec(io, scene.sky.zenith, 0, limits::max_radiance);
  const auto& materials = scene.materials;
  io.list(scene.materials, limits::max_materials, material_bytes,
          [&](auto& material) { pass_material(io, material); });
  io.list(scene.spheres, limits::max_shapes, scene_bytes_of_sphere,
          [&](auto& sphere) { pass_sphere(io, sphere, materials.size()); });
  if (!capsules) return;
  io.list(scene.capsules, limits::max_shapes - scene.spheres.size(), scene_bytes_of_capsule,
          [&](auto& capsule) { pass_capsule(io, capsule, materials.size()); });
  io.check(!scene.capsules.empty(), "a list of capsules is empty");
}

template <typename Out>
void put_scene(Out& out, const Scene& scene) {
  const Form form{scene.camera.projection, !scene.capsules.empty()};
  out.put_bytes(magic);
  out.put(form.digit());
  SceneWriter<Out> writer{out};
  pass_scene(writer, scene, form.capsules);
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
  SceneReader reader{ByteReader(bytes)};
  const Form form = get_form(reader.in);
  Scene scene;
  scene.camera.projection = form.projection;
  if (form.projection == Projection::orthographic) scene.camera.vfov = 0;
  pass_scene(reader, scene, form.capsules);
  reader.in.expect_end();
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

#include "tests/bench/embree_peer.h"

#include <algorithm>
#include <limits>

#include "common/scene/settings.h"
#include "tests/bench/embree_scene.h"
#include "tests/bench/embree_shading.h"

namespace parray {
namespace peer {

Lens::Lens(const Camera& camera, std::uint32_t width, std::uint32_t height)
    : inverse_width_(1.0F / static_cast<float>(width)),
      inverse_height_(1.0F / static_cast<float>(height)),
      inverse_focus_(static_cast<float>(1 / camera.focus_distance)),
      pinhole_(!(camera.aperture > 0)) {
  const Vec3d back = math::normalize(camera.look_from - camera.look_at);
  const Vec3d right = math::normalize(cross(camera.up, back));
  const Vec3d up = cross(back, right);
  const double film_height = 2 * camera.tan_half_vfov;
  const double film_width = film_height * width / height;
  const double lens = camera.aperture / 2;
  origin_ = vec_cast<float>(camera.look_from);
  right_ = vec_cast<float>(film_width * right);
  down_ = vec_cast<float>(-film_height * up);
  corner_ = vec_cast<float>((-0.5 * film_width) * right + (0.5 * film_height) * up - back);
  lens_right_ = vec_cast<float>(lens * right);
  lens_up_ = vec_cast<float>(lens * up);
}

MaterialColumns::MaterialColumns(const std::vector<Material>& materials) {
  for (const Material& material : materials) {
    const auto albedo = vec_cast<float>(material.albedo);
    red.push_back(albedo.x);
    green.push_back(albedo.y);
    blue.push_back(albedo.z);
    fuzz.push_back(material.type == MaterialType::metal ? static_cast<float>(material.fuzz) : -1);
    ior.push_back(material.type == MaterialType::dielectric ? static_cast<float>(material.ior) : 0);
  }
}

}  // namespace peer

namespace {

using lanes::Floats;
using lanes::Masks;
using lanes::Words;

/// How far from its origin a ray may hit: rounding of what the origin was computed from.
template <typename F>
F near_limit(const Vec3<F>& origin, const F& t, const F& radius) {
  const auto size = [](const F& x) { return peer::larger(x, -x); };
  return 0x1p-17F * (size(origin.x) + size(origin.y) + size(origin.z) + t + radius);
}

/// Live paths as columns; a column has room for one vector more than there are paths.
struct Paths {
  static constexpr std::size_t capacity = 1024;
  template <typename T>
  using Column = std::array<T, capacity + lanes::width>;

  std::size_t count = 0;
  alignas(64) Column<float> origin_x, origin_y, origin_z;
  alignas(64) Column<float> direction_x, direction_y, direction_z;
  alignas(64) Column<float> near;
  alignas(64) Column<float> red, green, blue;
  alignas(64) Column<std::uint32_t> pixel, sample, slot;
};

/// Radiance of the samples of a wave, by slot.
struct Radiance {
  alignas(64) Paths::Column<float> red, green, blue;
};

/// Paths side by side in registers.
struct Block {
  Vec3<Floats> origin;
  Vec3<Floats> direction;
  Floats near;
  Vec3<Floats> throughput;
  Words pixel, sample, slot;
};

Block load_block(const Paths& paths, std::size_t i) {
  using lanes::load;
  return {
      {load<Floats>(&paths.origin_x[i]), load<Floats>(&paths.origin_y[i]),
       load<Floats>(&paths.origin_z[i])},
      {load<Floats>(&paths.direction_x[i]), load<Floats>(&paths.direction_y[i]),
       load<Floats>(&paths.direction_z[i])},
      load<Floats>(&paths.near[i]),
      {load<Floats>(&paths.red[i]), load<Floats>(&paths.green[i]), load<Floats>(&paths.blue[i])},
      load<Words>(&paths.pixel[i]),
      load<Words>(&paths.sample[i]),
      load<Words>(&paths.slot[i])};
}

/// Appends the lanes of `mask`. Never overtakes the block that was loaded last.
void append(const Block& block, unsigned mask, Paths& paths) {
  const auto put = [mask, i = paths.count](auto& column, const auto& values) {
    lanes::store(&column[i], lanes::pack(values, mask));
  };
  put(paths.origin_x, block.origin.x);
  put(paths.origin_y, block.origin.y);
  put(paths.origin_z, block.origin.z);
  put(paths.direction_x, block.direction.x);
  put(paths.direction_y, block.direction.y);
  put(paths.direction_z, block.direction.z);
  put(paths.near, block.near);
  put(paths.red, block.throughput.x);
  put(paths.green, block.throughput.y);
  put(paths.blue, block.throughput.z);
  put(paths.pixel, block.pixel);
  put(paths.sample, block.sample);
  put(paths.slot, block.slot);
  paths.count += static_cast<std::size_t>(__builtin_popcount(mask));
}

/// What Embree found for a block's rays.
struct Hits {
  Floats t;
  Vec3<Floats> normal;  ///< outward, as long as the radius
  Words sphere;         ///< RTC_INVALID_GEOMETRY_ID: none
};

RTCIntersectContext make_context(RTCIntersectContextFlags flags) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = flags;
  return context;
}

constexpr float infinity = std::numeric_limits<float>::max();  // -ffast-math knows no infinity

#if defined(__AVX512F__) && defined(__AVX512DQ__)
using Packet = RTCRayHit16;
constexpr auto intersect = rtcIntersect16;
#else
using Packet = RTCRayHit8;
constexpr auto intersect = rtcIntersect8;
#endif

Hits intersect_packet(RTCScene scene, RTCIntersectContext& context, const Block& block,
                      const Masks& live) {
  using lanes::load;
  using lanes::store;
  Packet packet;
  store(packet.ray.org_x, block.origin.x);
  store(packet.ray.org_y, block.origin.y);
  store(packet.ray.org_z, block.origin.z);
  store(packet.ray.tnear, block.near);
  store(packet.ray.dir_x, block.direction.x);
  store(packet.ray.dir_y, block.direction.y);
  store(packet.ray.dir_z, block.direction.z);
  store(packet.ray.time, Floats{});
  store(packet.ray.tfar, Floats{} + infinity);
  store(packet.ray.mask, ~Words{});
  store(packet.ray.flags, Words{});
  store(packet.hit.primID, ~Words{});
  store(packet.hit.geomID, ~Words{});
  store(packet.hit.instID[0], ~Words{});
  alignas(64) Masks valid = live;
  intersect(reinterpret_cast<const int*>(&valid), scene, &context, &packet);
  return {
      load<Floats>(packet.ray.tfar),
      {load<Floats>(packet.hit.Ng_x), load<Floats>(packet.hit.Ng_y), load<Floats>(packet.hit.Ng_z)},
      load<Words>(packet.hit.primID)};
}

RTCRayHit make_ray(float ox, float oy, float oz, float near, float dx, float dy, float dz) {
  RTCRayHit ray;
  ray.ray = {ox, oy, oz, near, dx, dy, dz, 0, infinity, ~0U, 0, 0};
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  ray.hit.primID = RTC_INVALID_GEOMETRY_ID;
  ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return ray;
}

/// Adds the samples of neighbouring pixels, `count` slots each.
void add_samples(const Radiance& radiance, std::uint32_t count, std::span<PeerSums> sums) {
  const std::array<const float*, 3> channels{radiance.red.data(), radiance.green.data(),
                                             radiance.blue.data()};
  for (std::size_t pixel = 0; pixel < sums.size(); ++pixel) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const float* values = channels[channel] + pixel * count;
      float sum = 0;
      float squares = 0;
      for (std::uint32_t i = 0; i < count; ++i) {
        sum += values[i];
        squares += values[i] * values[i];
      }
      sums[pixel].sum[channel] += sum;
      sums[pixel].sum_of_squares[channel] += squares;
    }
  }
}

}  // namespace

class EmbreePeer::Body {
 public:
  Body(const Scene& scene, const RenderSettings& settings);

  void trace_single(const PixelRun& run, const SampleRange& samples, std::span<PeerSums> sums,
                    TraceCounts& counts) const;
  void trace_waves(const PixelRun& run, const SampleRange& samples, std::span<PeerSums> sums,
                   TraceCounts& counts) const;

  [[nodiscard]] const peer::EmbreeScene& spheres() const { return spheres_; }

 private:
  Vec3<float> radiance(std::uint32_t x, std::uint32_t y, std::uint32_t sample,
                       TraceCounts& counts) const;
  void start_paths(std::uint32_t x, std::uint32_t y, const SampleRange& samples,
                   std::uint32_t first_slot, Paths& paths) const;
  void finish_paths(Paths& paths, Radiance& radiance, TraceCounts& counts) const;
  void add_misses(const Block& block, const Masks& missed, Radiance& radiance) const;
  void bounce_block(const Block& block, const Hits& hits, const Masks& hit, std::uint32_t bounce,
                    Paths& next) const;
  [[nodiscard]] std::array<std::uint32_t, 2> key() const {
    return {static_cast<std::uint32_t>(seed_), static_cast<std::uint32_t>(seed_ >> 32)};
  }

  peer::Lens lens_;
  peer::SkyLight sky_;
  peer::MaterialColumns materials_;
  peer::EmbreeScene spheres_;
  std::uint32_t width_;
  std::uint32_t max_depth_;
  std::uint64_t seed_;
};

EmbreePeer::Body::Body(const Scene& scene, const RenderSettings& settings)
    : lens_(scene.camera, settings.width, settings.height),
      sky_{vec_cast<float>(scene.sky.horizon),
           vec_cast<float>(scene.sky.zenith - scene.sky.horizon)},
      materials_(scene.materials),
      spheres_(scene),
      width_(settings.width),
      max_depth_(settings.max_depth),
      seed_(settings.seed) {}

Vec3<float> EmbreePeer::Body::radiance(std::uint32_t x, std::uint32_t y, std::uint32_t sample,
                                       TraceCounts& counts) const {
  const peer::Address<float> address{y * width_ + x, sample, key()};
  RTCIntersectContext context = make_context(RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
  auto [origin, d] = lens_.ray(static_cast<float>(x), static_cast<float>(y), address);
  Vec3<float> throughput{1, 1, 1};
  float near = 0;
  for (std::uint32_t bounce = 0; bounce < max_depth_; ++bounce) {
    ++counts.rays;
    RTCRayHit ray = make_ray(origin.x, origin.y, origin.z, near, d.x, d.y, d.z);
    rtcIntersect1(spheres_.handle(), &context, &ray);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return throughput * sky_.radiance(d);
    if (bounce + 1 == max_depth_) break;
    const Vec3<float> outward{ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z};
    const float square = dot(outward, outward);
    const float inverse_radius = lanes::inverse_square_root(square);
    const bool leaving = dot(outward, d) > 0;
    const auto scattered = peer::scatter(materials_, spheres_.material_of()[ray.hit.primID], d,
                                         (leaving ? -inverse_radius : inverse_radius) * outward,
                                         leaving, address, bounce);
    if (scattered.absorbed) break;
    throughput = throughput * scattered.albedo;
    origin = origin + ray.ray.tfar * d;
    near = near_limit(origin, ray.ray.tfar, square * inverse_radius);
    d = scattered.direction;
  }
  return {};
}

void EmbreePeer::Body::trace_single(const PixelRun& run, const SampleRange& samples,
                                    std::span<PeerSums> sums, TraceCounts& counts) const {
  for (std::uint32_t x = run.x_begin; x < run.x_end; ++x) {
    PeerSums pixel;
    for (std::uint32_t s = samples.begin; s < samples.end; ++s) {
      const Vec3<float> value = radiance(x, run.y, s, counts);
      pixel.sum[0] += value.x;
      pixel.sum[1] += value.y;
      pixel.sum[2] += value.z;
      pixel.sum_of_squares[0] += value.x * value.x;
      pixel.sum_of_squares[1] += value.y * value.y;
      pixel.sum_of_squares[2] += value.z * value.z;
    }
    counts.samples += samples.count();
    for (std::size_t c = 0; c < 3; ++c) {
      sums[x - run.x_begin].sum[c] += pixel.sum[c];
      sums[x - run.x_begin].sum_of_squares[c] += pixel.sum_of_squares[c];
    }
  }
}

void EmbreePeer::Body::start_paths(std::uint32_t x, std::uint32_t y, const SampleRange& samples,
                                   std::uint32_t first_slot, Paths& paths) const {
  for (std::uint32_t s = samples.begin; s < samples.end; s += lanes::width) {
    Block block;
    block.pixel = Words{} + (y * width_ + x);
    block.sample = s + lanes::iota();
    block.slot = first_slot + (s - samples.begin) + lanes::iota();
    const auto ray = lens_.ray(Floats{} + static_cast<float>(x), Floats{} + static_cast<float>(y),
                               peer::Address<Floats>{block.pixel, block.sample, key()});
    block.origin = ray.origin;
    block.direction = ray.direction;
    block.near = Floats{};
    block.throughput = peer::splat<Floats>({1, 1, 1});
    append(block, lanes::bits(block.sample < samples.end), paths);
  }
}

void EmbreePeer::Body::add_misses(const Block& block, const Masks& missed,
                                  Radiance& radiance) const {
  const Vec3<Floats> value = block.throughput * sky_.radiance(block.direction);
  for (unsigned left = lanes::bits(missed); left != 0; left &= left - 1) {
    const int lane = __builtin_ctz(left);
    const std::uint32_t slot = block.slot[lane];
    radiance.red[slot] = value.x[lane];
    radiance.green[slot] = value.y[lane];
    radiance.blue[slot] = value.z[lane];
  }
}

void EmbreePeer::Body::bounce_block(const Block& block, const Hits& hits, const Masks& hit,
                                    std::uint32_t bounce, Paths& next) const {
  const Vec3<Floats>& d = block.direction;
  const Floats square = dot(hits.normal, hits.normal);
  const Floats inverse_radius = lanes::inverse_square_root(square);
  const Masks leaving = dot(hits.normal, d) > 0;
  const Words sphere = hit ? hits.sphere : Words{};  // a lane without a hit may gather anything
  const Words material = lanes::gather(spheres_.material_of(), sphere);
  const Vec3<Floats> m = lanes::select(leaving, -inverse_radius, inverse_radius) * hits.normal;
  const auto scattered =
      peer::scatter(materials_, material, d, m, leaving,
                    peer::Address<Floats>{block.pixel, block.sample, key()}, bounce);
  Block onward = block;
  onward.origin = block.origin + hits.t * d;
  onward.direction = scattered.direction;
  onward.near = near_limit(onward.origin, hits.t, square * inverse_radius);
  onward.throughput = block.throughput * scattered.albedo;
  append(onward, lanes::bits(hit & ~scattered.absorbed), next);
}

void EmbreePeer::Body::finish_paths(Paths& paths, Radiance& radiance, TraceCounts& counts) const {
  for (std::uint32_t bounce = 0; bounce < max_depth_ && paths.count != 0; ++bounce) {
    RTCIntersectContext context = make_context(bounce == 0 ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT
                                                           : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
    const std::size_t count = paths.count;
    counts.rays += count;
    paths.count = 0;
    for (std::size_t i = 0; i < count; i += lanes::width) {
      const Block block = load_block(paths, i);
      const auto alive = static_cast<std::uint32_t>(count - i);
      const Masks live = lanes::iota() < alive;
      const Hits hits = intersect_packet(spheres_.handle(), context, block, live);
      const Masks hit = live & (hits.sphere != RTC_INVALID_GEOMETRY_ID);
      add_misses(block, live & ~hit, radiance);
      if (bounce + 1 < max_depth_ && lanes::any(hit)) bounce_block(block, hits, hit, bounce, paths);
    }
  }
}

void EmbreePeer::Body::trace_waves(const PixelRun& run, const SampleRange& samples,
                                   std::span<PeerSums> sums, TraceCounts& counts) const {
  static thread_local Paths paths;
  static thread_local Radiance radiance;
  const std::uint32_t n = std::min<std::uint32_t>(samples.count(), Paths::capacity);
  const std::uint32_t pixels = static_cast<std::uint32_t>(Paths::capacity) / n;
  for (std::uint32_t s = samples.begin; s < samples.end; s += n) {
    const SampleRange part{s, std::min(s + n, samples.end)};
    for (std::uint32_t x = run.x_begin; x < run.x_end; x += pixels) {
      const std::uint32_t end = std::min(x + pixels, run.x_end);
      paths.count = 0;
      for (std::uint32_t i = x; i < end; ++i) {
        start_paths(i, run.y, part, (i - x) * part.count(), paths);
      }
      radiance.red.fill(0);
      radiance.green.fill(0);
      radiance.blue.fill(0);
      finish_paths(paths, radiance, counts);
      counts.samples += std::uint64_t{end - x} * part.count();
      add_samples(radiance, part.count(), sums.subspan(x - run.x_begin, end - x));
    }
  }
}

EmbreePeer::EmbreePeer(const Scene& scene, const RenderSettings& settings)
    : body_(std::make_unique<Body>(scene, settings)) {}
EmbreePeer::~EmbreePeer() = default;

void EmbreePeer::trace(Variant variant, const PixelRun& run, const SampleRange& samples,
                       std::span<PeerSums> sums, TraceCounts& counts) const {
  const peer::FlushDenormals mode;
  if (variant == Variant::single) {
    body_->trace_single(run, samples, sums, counts);
  } else {
    body_->trace_waves(run, samples, sums, counts);
  }
}

std::size_t EmbreePeer::bytes() const { return body_->spheres().bytes(); }
std::size_t EmbreePeer::peak_bytes() const { return body_->spheres().peak_bytes(); }
double EmbreePeer::build_seconds() const { return body_->spheres().build_seconds(); }

const char* embree_version() { return RTC_VERSION_STRING; }

}  // namespace parray

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "common/scene/scene.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"
#include "tests/support/rooms.h"

namespace parray {

/// Sums of a pixel's samples, per channel. Floating point: the peer need not be exact.
struct PeerSums {
  std::array<double, 3> sum{};
  std::array<double, 3> sum_of_squares{};
};

/// ParRay's integrator on Embree's sphere points: the rival of the benchmark. Single precision, the
/// same random numbers at the same addresses, and as fast as Embree lets it be:
///
/// - one thread, high build quality, huge pages, denormals flushed; no scene flags, because packets
///   were slower with them [measured: compact 0.89 to 1.0, robust 0.96] and with every other
///   `hair_accel`;
/// - spheres in Morton order, because Embree's leaves hold indices [measured: 1.16 at 1 M];
/// - camera rays are flagged coherent, bounces incoherent. No faster: bounces sorted by octant,
///   packets of 8 under AVX-512, rtcIntersect1 under vectorised shading; streams are packets
///   inside.
///
/// Lives in a library of its own: it is built with -ffast-math -march=native, and no inline
/// function of it may be the copy that the linker keeps for ParRay.
///
/// The epsilon: hits nearer than 2^-17 (|origin|_1 + t + radius) are ignored, in proportion to the
/// numbers that the origin was computed from. Below 2^-18 rays meet the surface that they leave.
class EmbreePeer {
 public:
  enum class Variant {
    single,  ///< one path after another: rtcIntersect1, scalar shading
    packet,  ///< waves of a thousand paths: rtcIntersect16 (8 without AVX-512), vectorised shading
  };

  /// Builds at once, on the calling thread. Throws std::runtime_error where Embree fails.
  [[gnu::visibility("default")]] EmbreePeer(const Scene& scene, const RenderSettings& settings);
  [[gnu::visibility("default")]] ~EmbreePeer();
  EmbreePeer& operator=(EmbreePeer&&) = delete;

  /// As PathTracer::trace().
  [[gnu::visibility("default")]] void trace(Variant variant, const PixelRun& run,
                                            const SampleRange& samples, std::span<PeerSums> sums,
                                            TraceCounts& counts) const;

  /// What Embree holds, the vertex buffer included.
  [[nodiscard, gnu::visibility("default")]] std::size_t bytes() const;
  /// The most that it held while building.
  [[nodiscard, gnu::visibility("default")]] std::size_t peak_bytes() const;
  /// Processor time of rtcCommitScene alone: ordering the spheres and filling the vertex buffer
  /// come before it.
  [[nodiscard, gnu::visibility("default")]] double build_seconds() const;

 private:
  class Body;
  std::unique_ptr<Body> body_;
};

/// Version of the Embree that this is built for, such as "3.13.5".
[[gnu::visibility("default")]] const char* embree_version();

}  // namespace parray

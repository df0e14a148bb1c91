#pragma once

#include <embree3/rtcore.h>
#include <pmmintrin.h>
#include <xmmintrin.h>

#include <cstdint>
#include <vector>

#include "common/scene/scene.h"
#include "tests/support/rooms.h"

namespace parray::peer {

/// What Embree asks of a thread that traces: denormals are zero, for as long as this lives.
class FlushDenormals {
 public:
  FlushDenormals() : before_(_mm_getcsr()) {
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
  }
  ~FlushDenormals() { _mm_setcsr(before_); }
  FlushDenormals& operator=(FlushDenormals&&) = delete;

 private:
  unsigned before_;
};

/// The spheres of a scene in Embree's hands, or else its capsules, as round linear curves. They are
/// in Morton order: primitive i is not shape i.
class EmbreeScene {
 public:
  /// `scene` has shapes of one kind. Throws std::runtime_error where Embree fails.
  explicit EmbreeScene(const Scene& scene);
  ~EmbreeScene();
  EmbreeScene& operator=(EmbreeScene&&) = delete;

  [[nodiscard]] RTCScene handle() const { return scene_; }
  /// Index of the material of each primitive.
  [[nodiscard]] const std::uint32_t* material_of() const { return material_of_.data(); }

  /// What Embree holds, the vertex buffer included, and the most that it ever held.
  [[nodiscard]] std::size_t bytes() const { return bytes_; }
  [[nodiscard]] std::size_t peak_bytes() const { return peak_bytes_; }
  /// Processor time of rtcCommitScene.
  [[nodiscard]] double build_seconds() const { return build_seconds_; }

 private:
  static bool count_memory(void* self, ssize_t bytes, bool post);
  [[nodiscard]] float* vertices(RTCGeometry geometry, std::size_t count) const;
  void fill(const std::vector<Sphere>& spheres, RTCGeometry geometry);
  void fill(const std::vector<Capsule>& capsules, RTCGeometry geometry);
  void check() const;

  std::vector<std::uint32_t> material_of_;
  std::size_t bytes_ = 0;  // one thread builds
  std::size_t peak_bytes_ = 0;
  double build_seconds_ = 0;
  RTCDevice device_;
  RTCScene scene_ = nullptr;
};

}  // namespace parray::peer

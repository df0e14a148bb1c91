#pragma once

#include <cstdint>
#include <vector>

#include "common/trace/integrator/path_tracer.h"

namespace parray::plan {

/// A smaller picture of tiles that are spread evenly over a picture. Its pixels have the samples,
/// noise and cost of the picture's pixels.
class PartOfPicture final : public PathTracer {
 public:
  /// Size of the tiles in pixels.
  struct Tile {
    std::uint32_t width = 32;
    std::uint32_t height = 32;
  };

  /// Takes tiles with about `pixels` pixels in total, at least one tile. Takes the whole picture,
  /// of `width` x `height` pixels, if `pixels` is more than 70 % of it. `tracer` makes the picture
  /// and must outlive this object.
  PartOfPicture(const PathTracer& tracer, std::uint32_t width, std::uint32_t height,
                std::uint64_t pixels, Tile tile);

  [[nodiscard]] std::uint32_t width() const { return static_cast<std::uint32_t>(column_.size()); }
  [[nodiscard]] std::uint32_t height() const { return static_cast<std::uint32_t>(row_.size()); }
  [[nodiscard]] double pixels() const { return static_cast<double>(width()) * height(); }
  /// Return the column or row in the picture, for each column or row of the part.
  [[nodiscard]] const std::vector<std::uint32_t>& columns() const { return column_; }
  [[nodiscard]] const std::vector<std::uint32_t>& rows() const { return row_; }

  void trace_run(const PixelRun& run, const RunSamples& samples, std::span<PixelSums> sums,
                 TraceCounts& counts) const override;
  void first_hits(const PixelRun& run, const SampleRange& samples,
                  std::span<FirstHit> hits) const override;
  void add_sky_samples(const PixelRun& run, const RunSamples& samples,
                       std::span<SkySamples> sky) const override;

 private:
  /// Calls visit(run of the picture, index of its first pixel in `run`) for all parts of a run.
  void for_stretches(const PixelRun& run, const auto& visit) const;

  const PathTracer& tracer_;
  std::vector<std::uint32_t> column_;
  std::vector<std::uint32_t> row_;
};

}  // namespace parray::plan

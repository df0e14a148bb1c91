#pragma once

#include <cstddef>

#include "cli/input/formats/ply_header.h"
#include "cli/input/formats/row_layout.h"
#include "cli/input/particles/particles.h"

namespace parray::input {

/// The vertices of binary data as rows of one size, read many at a time.
class PlyRows {
 public:
  /// `vertex` has no lists; `swapped`: its bytes are in the other order than this machine's. All
  /// must outlive this.
  PlyRows(const PlyElement& vertex, const RowLayout& layout, bool swapped);

  [[nodiscard]] std::size_t row_bytes() const { return row_bytes_; }

  /// Writes `count` rows to the columns of `out` that the layout has, from `first` on. False when
  /// ParticleColumns would refuse one of them.
  bool read(const char* rows, std::size_t count, Particles& out, std::size_t first) const;

 private:
  template <typename Put>
  bool read_property(std::size_t property, const char* rows, std::size_t count, double least,
                     double most, const Put& put) const;
  bool read_vectors(const std::array<std::size_t, 3>& properties, const char* rows,
                    std::size_t count, double least, double most, Vec3d* to) const;

  const PlyElement& vertex_;
  const RowLayout& layout_;
  bool swapped_;
  std::size_t row_bytes_ = 0;
  std::vector<std::size_t> offsets_;  // by property
};

}  // namespace parray::input

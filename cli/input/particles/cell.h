#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "cli/input/particles/particles.h"
#include "common/math/vec.h"

/// The cells of particles, and operations on particles in a periodic cell.
namespace parray::input {

/// Returns the cell at the origin with edges of these lengths (> 0) and the angles alpha (between b
/// and c), beta (a and c) and gamma (a and b) in degrees. a lies along x, b in the xy plane
/// (International Tables for Crystallography, volume B, section 3.3.1). Returns nothing if no cell
/// has these lengths and angles, or if a length is above limits::max_length.
std::optional<ParticleCell> cell_from(const Vec3d& lengths, const Vec3d& angles);

/// Returns `cell`, or nothing if the cell has no volume or is not finite.
std::optional<ParticleCell> valid_cell(const ParticleCell& cell);

/// Returns x, y or z of a vector for the axis 0, 1 or 2.
inline double component(const Vec3d& v, std::size_t axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

/// An image of the cell: whole numbers of edges a, b, c by which it is shifted.
using CellImage = std::array<std::int64_t, 3>;

/// Positions as fractions of the edges of a cell, which has a volume.
class CellFractions {
 public:
  explicit CellFractions(const ParticleCell& cell);

  /// Returns the fractions of a position: 0 to 1 inside the cell.
  [[nodiscard]] Vec3d of(const Vec3d& position) const;
  /// Returns the translation by fractions of the edges.
  [[nodiscard]] Vec3d translation(const Vec3d& fractions) const;
  [[nodiscard]] Vec3d translation(const CellImage& image) const;
  /// Returns the distances between opposite faces.
  [[nodiscard]] Vec3d heights() const;
  /// Returns the image of the cell that contains the fractions: 0 along edges that are not
  /// periodic. A fraction just below a whole number counts as that number.
  [[nodiscard]] CellImage image_of(const Vec3d& fractions) const;
  /// Returns the image whose translation brings `to` nearest to `from`: 0 along edges that are not
  /// periodic.
  [[nodiscard]] CellImage nearest(const Vec3d& from, const Vec3d& to) const;

 private:
  ParticleCell cell_;
  std::array<Vec3d, 3> slopes_;
};

/// How often the cell is repeated along its edges.
struct Replicas {
  std::array<std::uint32_t, 3> counts{1, 1, 1};  ///< > 0

  [[nodiscard]] bool any() const { return *this != Replicas{}; }
  friend bool operator==(const Replicas&, const Replicas&) = default;
};

/// Parses "3x3x2": three whole numbers from 1 to limits::max_shapes. Throws InputError, which names
/// no place, for other texts.
Replicas replicas_from(std::string_view text);
/// Returns the text that replicas_from() parses to `replicas`. Returns "" for 1x1x1.
std::string text_of(const Replicas& replicas);

// The particles of all functions below have a cell.

/// Repeats particles and cell. The cell becomes the whole block of copies, as in OVITO. The
/// original particles come first. A bond across a face leads to the next copy. Throws InputError,
/// before it allocates, if there would be more than limits::max_shapes particles.
void replicate(Particles& particles, const Replicas& replicas);

/// Adds copies of the particles on a face of the cell to the opposite faces. A particle is on a
/// face if its distance, in fractions of the edges, is at most `tolerance`. Adds no copy where a
/// particle already is, and none along edges that are not periodic. Returns the number of copies.
std::uint64_t add_boundary_copies(Particles& particles, const Vec3d& tolerance);

/// Moves each molecule by whole periodic edges, so that its centroid is inside the cell along
/// these. `molecule` has the number of each particle's molecule, from 0; empty: each particle is
/// one.
void wrap(Particles& particles, std::span<const std::uint32_t> molecule = {});

/// Moves all particles, so that the centroid of those of `mask` (at least one) is at the centre of
/// the cell. Along periodic edges, the centroid takes each particle at its image that is nearest to
/// the circular mean: Bai and Breen, J. Graphics Tools 13 (2008) 53. So a group that crosses a face
/// counts as one.
void center_on(Particles& particles, const ParticleMask& mask);

}  // namespace parray::input

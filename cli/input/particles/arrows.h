#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/color/legend.h"
#include "cli/input/particles/particles.h"
#include "common/scene/scene.h"

/// Arrows for vectors of the particles, such as velocities.
namespace parray::input {

inline constexpr std::array<std::string_view, 2> arrow_words{"velocity", "force"};

/// Default length of the longest arrow, as a multiple of typical_distance() of the particles.
inline constexpr double longest_arrow = 2;

/// Parses arrow_words, the name of a vector, or three names of columns separated by commas. Returns
/// the text in lower case. Throws InputError, which names no place, for other texts.
std::string arrows_from(std::string_view text);

/// Returns the names of numeric columns that may hold the vectors. For "velocity": vx, velocity_x
/// and so on. For another NAME: NAMEx, NAME_x and so on. `arrows` is a result of arrows_from(), or
/// empty.
std::set<std::string, std::less<>> numbers_of_arrows(std::string_view arrows);

/// The numbers that set the scale and the width of arrows. All frames of a film have the same ones.
struct ArrowMeasure {
  double longest = 0;  ///< length of the longest vector, in the unit of the vectors
  double spacing = 0;  ///< typical_distance() of the particles; 0: there are no neighbours

  /// Adds a later frame: keeps the longest vector of all frames, and the spacing of the first frame
  /// that has one.
  void add(const ArrowMeasure& frame);
  friend bool operator==(const ArrowMeasure&, const ArrowMeasure&) = default;
};

/// The arrows of particles.
struct ParticleArrows {
  std::vector<Vec3d> arrows;  ///< from the centre to the tip, one per particle; 0: no arrow
  double width = 0;           ///< radius of the shafts of long arrows
  Legend legend;              ///< the value of the longest arrow
  ArrowMeasure measure{};     ///< of these particles
};

/// Returns the arrows of particles, at least one. `scale` is the length of the arrow of a vector of
/// length 1. Not given: the longest arrow has longest_arrow times the distance of typical
/// neighbours. Particles whose vector is not known have no arrow, and a note counts them.
/// `measure`: of all frames of a film. Not given: that of the particles.
///
/// Throws UnknownNumber (selection.h) if the particles lack the columns. Throws SourceError for
/// "arrow_scale" if arrows are too long, or if particles without neighbours need a scale.
ParticleArrows arrows_of(std::string_view arrows, const std::optional<double>& scale,
                         Particles& particles, const std::optional<ArrowMeasure>& measure = {});

/// Appends an arrow of one material. `width` is that of ParticleArrows: the radius of the shaft. An
/// arrow is a capsule for the shaft and a chain of balls for the head. The balls shrink towards the
/// tip by a constant factor, so that they look like a cone. Arrows that are short for their width
/// become thinner. Does nothing for an arrow that would be too thin for limits::min_radius, such as
/// one of length 0.
void append_arrow(const Vec3d& center, const Vec3d& arrow, double width, std::uint32_t material,
                  std::vector<Capsule>& capsules);

/// Largest number of capsules of an arrow.
inline constexpr std::uint64_t capsules_of_arrow = 21;

}  // namespace parray::input

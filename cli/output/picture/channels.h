#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/rooms.h"

namespace parray::picture {

/// A named extra channel of a picture: one value a pixel, top row first. What counts or names
/// something is a whole number: a float is exact up to 2^24 only, and there are scenes of 50
/// million spheres.
struct Channel {
  std::string name;  ///< as EXR has it: "Z", "N.X"; none of R, G, B
  std::variant<std::vector<float>, std::vector<std::uint32_t>> values;

  friend bool operator==(const Channel&, const Channel&) = default;
};
using Channels = std::vector<Channel>;

/// The channel of Aov::samples: what tracing a picture again needs to know of each pixel.
inline constexpr const char* samples_channel = "samples";

/// What a picture can show beside radiance ("arbitrary output variables").
enum class Aov : std::uint8_t { depth, normal, albedo, sphere, cost, samples, half_width };
using Aovs = std::set<Aov>;

/// Known once the picture is rendered; the others are traced from the scene.
inline bool is_statistic(Aov aov) { return aov == Aov::samples || aov == Aov::half_width; }

/// Names as they stand in options and reports.
std::string_view name_of(Aov aov);

/// The value of "depth,normal,...", any order. Throws InputError that names an unknown name and the
/// nearest known one, or all.
Aovs aovs_from(std::string_view names);

/// The opposite, in one order.
std::string text_of(const Aovs& aovs);

}  // namespace parray::picture

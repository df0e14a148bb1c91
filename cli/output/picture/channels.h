#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/rooms.h"

namespace parray::picture {

/// A named extra channel of a picture: one value per pixel, top row first. Counts and numbers are
/// integers, because floats are exact only up to 2^24.
struct Channel {
  std::string name;  ///< name in EXR files: "Z", "N.X"; not R, G, B
  std::variant<std::vector<float>, std::vector<std::uint32_t>> values;

  friend bool operator==(const Channel&, const Channel&) = default;
};
using Channels = std::vector<Channel>;

/// The channel of Aov::samples. Tracing the picture again needs it.
inline constexpr const char* samples_channel = "samples";

/// What a picture can contain in addition to radiance ("arbitrary output variables").
enum class Aov : std::uint8_t { depth, normal, albedo, sphere, cost, samples, half_width };
using Aovs = std::set<Aov>;

/// Returns whether the channel follows from the statistics of the picture. All others are traced
/// from the scene.
inline bool is_statistic(Aov aov) { return aov == Aov::samples || aov == Aov::half_width; }

/// Returns the name in options and reports: "depth", "half-width".
std::string_view name_of(Aov aov);

/// Parses "depth,normal,...", in any order. Throws InputError for an unknown name. The message
/// suggests the nearest known name or lists all.
Aovs aovs_from(std::string_view names);

/// Returns the names, separated by commas, in a fixed order.
std::string text_of(const Aovs& aovs);

}  // namespace parray::picture

#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <utility>
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

/// Returns the values of a channel. Null: there is no such channel with values of this type.
template <typename Value>
const std::vector<Value>* values_in(const Channels& channels, std::string_view name) {
  for (const Channel& channel : channels) {
    const auto* const values = std::get_if<std::vector<Value>>(&channel.values);
    if (channel.name == name && values != nullptr) return values;
  }
  return nullptr;
}

/// Adds the channels `prefix` + "R", "G" and "B". `rgb` has these three values for each pixel.
void add_rgb(Channels& channels, const std::string& prefix, const auto& rgb) {
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<float> values(rgb.size() / 3);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(rgb[3 * i + c]);
    channels.push_back({prefix + "RGB"[c], std::move(values)});
  }
}

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

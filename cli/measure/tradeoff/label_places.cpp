#include "cli/measure/tradeoff/label_places.h"

#include <algorithm>
#include <cmath>

namespace parray::tradeoff {
namespace {

/// Directions and distances that are tried, the best first.
std::vector<Place> offsets_of(const Named& name, Place toward) {
  const double straight = std::atan2(toward.y, toward.x);
  std::vector<Place> offsets;
  for (const double distance : {8, 16, 26, 38, 52, 70, 90, 115, 145, 180, 220}) {
    for (const double turn : {0.0, 0.35, -0.35, 0.7, -0.7, 1.0, -1.0}) {
      const double x = std::cos(straight + turn);
      const double y = std::sin(straight + turn);
      offsets.push_back({x * (distance + name.width / 2), y * (distance + name.height / 2)});
    }
  }
  return offsets;
}

}  // namespace

bool Box::overlaps(const Box& other) const {
  return std::abs(centre.x - other.centre.x) < (width + other.width) / 2 &&
         std::abs(centre.y - other.centre.y) < (height + other.height) / 2;
}

bool Box::contains(const Box& other) const {
  return std::abs(centre.x - other.centre.x) <= (width - other.width) / 2 &&
         std::abs(centre.y - other.centre.y) <= (height - other.height) / 2;
}

std::vector<std::optional<Place>> place_names(const std::vector<Named>& names,
                                              const std::vector<Box>& markers, const Box& area,
                                              Place toward) {
  std::vector<std::optional<Place>> places;
  std::vector<Box> taken = markers;
  for (const Named& name : names) {
    places.emplace_back();
    for (const Place& offset : offsets_of(name, toward)) {
      const Box box{{name.at.x + offset.x, name.at.y + offset.y}, name.width, name.height};
      const bool free = area.contains(box) && std::ranges::none_of(taken, [&](const Box& other) {
                          return box.overlaps(other);
                        });
      if (!free) continue;
      places.back() = box.centre;
      taken.push_back(box);
      break;
    }
  }
  return places;
}

}  // namespace parray::tradeoff

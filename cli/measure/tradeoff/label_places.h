#pragma once

#include <optional>
#include <vector>

#include "common/rooms.h"

/// Where the names of points in a plot can stand without covering each other. Pure functions.
namespace parray::tradeoff {

/// In the plot's own unit, y downwards.
struct Place {
  double x = 0;
  double y = 0;
};

struct Box {
  Place centre;
  double width = 0;
  double height = 0;
  [[nodiscard]] bool overlaps(const Box& other) const;
  [[nodiscard]] bool contains(const Box& other) const;
};

/// What is to be named: a point, and the size of its name.
struct Named {
  Place at;
  double width = 0;
  double height = 0;
};

/// Centres of names, near their points, on the side that `toward` points to if there is room:
/// inside of `area`, apart from each other and from all of `markers`. None where there is no room.
std::vector<std::optional<Place>> place_names(const std::vector<Named>& names,
                                              const std::vector<Box>& markers, const Box& area,
                                              Place toward);

}  // namespace parray::tradeoff

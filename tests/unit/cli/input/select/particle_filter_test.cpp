#include "cli/input/select/particle_filter.h"

#include <doctest/doctest.h>

#include <array>
#include <string>
#include <vector>

#include "cli/input/select/columns.h"
#include "tests/support/rooms.h"

namespace parray {

TEST_CASE("none hides no class in any letter case, as the words of classes") {
  for (const char* text : {"none", "None", " NONE "}) CHECK(hide_from(text).empty());
  CHECK(hide_from("Virtual") == std::vector<std::string>{"virtual"});
}

TEST_CASE("hidden particles do not change the index of the others") {
  Particles water;
  water.residue_names = {{"SOL"}, {0, 0, 0, 0, 0, 0, 0, 0}};
  water.atom_names = {{"OW", "HW1", "HW2", "MW"}, {0, 1, 2, 3, 0, 1, 2, 3}};
  water.positions.resize(8);
  apply({}, water);
  REQUIRE(water.count() == 6);
  const NumberSource index = number_source("index", water);
  REQUIRE(index);
  std::array<double, 6> numbers{};
  index(0, numbers);
  CHECK(numbers == std::array<double, 6>{0, 1, 2, 4, 5, 6});
}

}  // namespace parray

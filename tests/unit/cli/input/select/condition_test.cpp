#include <doctest/doctest.h>

#include "cli/input/select/selection.h"
#include "tests/support/rooms.h"

namespace parray {

TEST_CASE("old names of nucleic acids, with * instead of ', are selected like new names") {
  Particles old;
  old.atom_names.names = {"P", "O5*", "C5*", "C5", "O3*", "N9"};
  old.residue_names.names = {"DA"};
  for (std::uint32_t i = 0; i < old.atom_names.names.size(); ++i) {
    old.atom_names.index.push_back(i);
    old.residue_names.index.push_back(0);
    old.positions.emplace_back();
  }
  CHECK(Selection("backbone").mask(old) == ParticleMask{1, 1, 1, 0, 1, 0});
  CHECK(Selection("name C5'").mask(old) == ParticleMask{0, 0, 1, 0, 0, 0});
}

}  // namespace parray

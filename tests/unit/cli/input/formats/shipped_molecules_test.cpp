#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "cli/input/particles/elements.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

std::map<std::string, int> composition(const Particles& particles) {
  std::map<std::string, int> counts;
  for (const std::uint8_t number : particles.elements) {
    ++counts[std::string(element(number).symbol)];
  }
  return counts;
}

}  // namespace

TEST_CASE("the shipped molecules have the expected atoms") {
  const std::filesystem::path folder = PARRAY_SOURCE_DIR "/scenes/particles";
  CHECK(composition(read_particles(folder / "caffeine.xyz")) ==
        std::map<std::string, int>{{"C", 8}, {"H", 10}, {"N", 4}, {"O", 2}});
  CHECK(composition(read_particles(folder / "helix.pdb")) ==
        std::map<std::string, int>{{"C", 36}, {"N", 12}, {"O", 18}, {"S", 2}});
}

TEST_CASE("in the shipped molecules no two atoms are closer than a bond length") {
  for (const char* name : {"caffeine.xyz", "helix.pdb"}) {
    const auto particles =
        read_particles(std::filesystem::path(PARRAY_SOURCE_DIR) / "scenes" / "particles" / name);
    for (std::size_t i = 0; i < particles.count(); ++i) {
      double nearest = 1e9;
      for (std::size_t j = 0; j < particles.count(); ++j) {
        if (i == j) continue;
        nearest = std::min(nearest, length(particles.positions[i] - particles.positions[j]));
      }
      CHECK(nearest > 1.05);
      const bool water = particles.count() > 65 && i >= 65;
      if (!water) CHECK(nearest < 1.85);
    }
  }
}

}  // namespace parray

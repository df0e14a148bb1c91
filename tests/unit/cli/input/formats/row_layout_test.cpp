#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_trajectories.h"

namespace parray {
namespace {

using test::ParticleFiles;

const ParticleRequest all{.all = true};

/// The names of the number columns, with blanks between.
std::string names_of(const Particles& particles) {
  std::string names;
  for (const NumberColumn& column : particles.numbers) {
    names += (names.empty() ? "" : " ") + column.name;
  }
  return names;
}

std::vector<double> numbers(const Particles& particles, std::string_view name) {
  const auto found = std::ranges::find(particles.numbers, name, &NumberColumn::name);
  return found == particles.numbers.end() ? std::vector<double>{} : found->values;
}

}  // namespace

TEST_CASE("numeric columns are read only on request") {
  const ParticleFiles files;
  const auto table = files.write("a.csv", "x,y,z,vx,name,Charge [e]\n1,2,3,4,n,-1\n5,6,7,8,m,\n");
  CHECK(read_particles(table).numbers.empty());
  CHECK(names_of(read_particles(table, {.numbers = {"charge"}})) == "charge");
  const Particles every = read_particles(table, all);
  CHECK(names_of(every) == "vx charge");  // the names are no numbers
  CHECK(numbers(every, "vx") == std::vector<double>{4, 8});
  CHECK(std::isnan(numbers(every, "charge").at(1)));
}

}  // namespace parray

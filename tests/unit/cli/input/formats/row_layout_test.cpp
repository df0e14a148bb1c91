#include <doctest/doctest.h>

#include <cmath>

#include "tests/support/particle_columns.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::everything;
using test::names_of;
using test::numbers_of;
using test::ParticleFiles;

}  // namespace

TEST_CASE("numeric columns are read only on request") {
  const ParticleFiles files;
  const auto table = files.write("a.csv", "x,y,z,vx,name,Charge [e]\n1,2,3,4,n,-1\n5,6,7,8,m,\n");
  CHECK(read_particles(table).numbers.empty());
  CHECK(names_of(read_particles(table, {.numbers = {"charge"}})) == "charge");
  const Particles every = read_particles(table, everything);
  CHECK(names_of(every) == "vx charge");  // the names are no numbers
  CHECK(numbers_of(every, "vx") == std::vector<double>{4, 8});
  CHECK(std::isnan(numbers_of(every, "charge").at(1)));
}

}  // namespace parray

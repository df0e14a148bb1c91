#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "cli/input/formats/format_table.h"
#include "cli/input/particles/elements.h"
#include "cli/output/picture/srgb.h"
#include "tests/support/molecule_files.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_trajectories.h"

namespace parray {
namespace {

using test::ParticleFiles;

std::vector<Vec3d> three() { return {{1, -2, 3.5}, {0, 0.25, -1e3}, {-0.125, 7, 0}}; }

std::vector<std::string> types_of(const Particles& particles) {
  std::vector<std::string> types;
  for (const std::uint32_t type : particles.types.index) {
    types.push_back(particles.types.names.at(type));
  }
  return types;
}

using Names = std::vector<std::string>;

using Elements = std::vector<std::uint8_t>;

}  // namespace

TEST_CASE("CSV is read with every separator, quotes, comments and any letter case") {
  const ParticleFiles files;
  const std::vector<std::string> tables = {
      "x,y,z,type\n1,-2,3.5,a\n0,0.25,-1e3,b c\n-0.125,7,0,a\n",
      "# made by hand\n\n Type ; X;Y;Z\na;1;-2;3.5\n#x\nb c;0;+0.25;-1E3\n \t\na;-0.125;7;0",
      "x\ty\tz\ttype\tnote\n1\t-2\t3.5\ta\t\n0\t0.25\t-1e3\tb c\t,;\n-0.125\t7\t0\ta\tx",
      "  x y   z   type\n1 -2 3.5 a\n0 0.25 -1e3 \"b c\"\n\t-0.125 7 0 a  \n",
      ("\xEF\xBB\xBF\"x\",\"y\",\"z\",\"a,\"\"b\"\"\",\"type\"\r\n\"1\",-2,3.5,\"\",a\r\n"
       "0,0.25,-1e3,\"\"\"\",\"b c\"\r\n-0.125, 7 ,0,,\"a\" \r\n")};
  for (const std::string& table : tables) {
    CAPTURE(table);
    const Particles particles = files.read("a.csv", table);
    CHECK(particles.positions == three());
    CHECK(types_of(particles) == Names{"a", "b c", "a"});
    CHECK(particles.types.names == Names{"a", "b c"});
    CHECK(particles.elements.empty());
    CHECK(particles.radii.empty());
  }
}

TEST_CASE("CSV: a quote after empty tab-separated fields keeps its column") {
  const ParticleFiles files;
  const Particles particles = files.read("a.csv", "a\tb\tx\ty\tz\n\t\t\"1\"\t2\t3\n");
  CHECK(particles.positions == std::vector<Vec3d>{{1, 2, 3}});
}

TEST_CASE("CSV: r is a radius, but red if there are columns g and b") {
  const ParticleFiles files;
  CHECK(files.read("a.csv", "x,y,z,r\n0,0,0,2\n").radii == std::vector<double>{2});
  const Particles colored = files.read("a.csv", "x,y,z,r,g,b\n0,0,0,1,0.5,0\n");
  CHECK(colored.radii.empty());
  CHECK(colored.colors == std::vector<Vec3d>{{1, 0.5, 0}});
  const Particles both = files.read("a.csv", "x,y,z,red,green,blue,r\n0,0,0,1,0.5,0,3\n");
  CHECK(both.radii == std::vector<double>{3});
  CHECK(both.colors == std::vector<Vec3d>{{1, 0.5, 0}});
}

TEST_CASE("CSV: a colour component above 1 makes all colours 8-bit sRGB") {
  const ParticleFiles files;
  const Particles particles =
      files.read("a.csv", "x,y,z,Red,Green,Blue\n0,0,0,1,0,1\n0,0,1,255,128,0\n");
  CHECK(particles.colors == std::vector<Vec3d>{{srgb_decode(1.0 / 255), 0, srgb_decode(1.0 / 255)},
                                               {1, srgb_decode(128.0 / 255), 0}});
}

TEST_CASE(
    "CSV: elements are symbols or atomic numbers, and also types if there is no column of types") {
  const ParticleFiles files;
  Particles particles = files.read("a.csv", "x,y,z,element\n0,0,0,CL\n0,0,1,6\n0,0,2,X\n0,0,3,\n");
  CHECK(particles.elements == Elements{17, 6, 0, 0});
  CHECK(types_of(particles) == Names{"CL", "6", "X", ""});
  particles = files.read("a.csv", "x,y,z,element,type\n0,0,0,O,water\n");
  CHECK(particles.elements == Elements{8});
  CHECK(types_of(particles) == Names{"water"});
}

TEST_CASE("CSV: columns of positions have the names of other programs, with units in brackets") {
  const ParticleFiles files;
  for (const char* header :
       {"X,Y,Z", "x [nm],y [nm],z [nm]", "pos_x,pos_y,pos_z", "PositionX,PositionY,PositionZ",
        "Position X,Position Y,Position Z", "\"Points:0\",\"Points:1\",\"Points:2\"",
        "Points_0,Points_1,Points_2", "Position.X,Position.Y,Position.Z", "x_coord,y_coord,z_coord",
        "Center X (um),Center Y (um),Center Z (um)"}) {
    CAPTURE(header);
    const Particles particles = files.read("a.csv", std::string(header) + "\n1,2,3\n");
    CHECK(particles.positions == std::vector<Vec3d>{{1, 2, 3}});
  }
  CHECK(files.message("a.csv", "px,py\n1,2\n").find("no column 'x'") != std::string::npos);
  const Particles both = files.read("a.csv", "pos_x,pos_y,pos_z,x,y,z\n1,1,1,7,8,9\n");
  CHECK(both.positions[0] == Vec3d{7, 8, 9});
  const Particles balls = files.read("a.csv", "x,y,z,diameter\n1,2,3,4\n");
  CHECK(balls.radii == std::vector<double>{2});
}

}  // namespace parray

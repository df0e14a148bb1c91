#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "cli/output/picture/srgb.h"
#include "tests/support/molecule_files.h"
#include "tests/support/particle_columns.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/three_particles.h"

namespace parray {
namespace {

using test::Elements;
using test::Names;
using test::ParticleFiles;
using test::three_positions;
using test::types_of;

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
    CHECK(particles.positions == three_positions());
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

TEST_CASE("CSV: a comment before the rows may have the names of the columns") {
  const ParticleFiles files;
  for (const char* table :
       {"# x y z speed [m/s]\n1 2 3 4\n", "#x,y,z,speed [m/s]\n1,2,3,4\n",
        "# x, y, z, speed [m/s]\n1 2 3 4\n", "// X Y Z Speed [m/s]\n1\n1 2 3 4\n",
        "# made by hand in 2026\n# columns: x y z speed [m/s]\n# the end\n1 2 3 4\n",
        "% x y z speed\n% m m m m/s\n1 2 3 4\n", "# x y z speed\n# [m] [m] [m] [m/s]\n1 2 3 4\n",
        "# x y z speed\n# m m m [m/s]\n1 2 3 4\n"}) {
    for (const char* name : {"a.txt", "a.xyz", "a.csv"}) {
      CAPTURE(table);
      const Particles particles = read_particles(files.write(name, table), {.numbers = {"speed"}});
      CHECK(particles.positions == std::vector<Vec3d>{{1, 2, 3}});
      CHECK(particles.radii.empty());
      REQUIRE(particles.numbers.size() == 1);
      CHECK(particles.numbers[0].unit == "m/s");
      CHECK(particles.facts.notes.empty());
    }
  }
  CHECK(files.message("a.txt", "# id x y z x\n1 2 3 4 5\n") ==
        "a.txt:1: two columns are named 'x': rename one");
  const Particles guessed = files.read("a.txt", "# three other words\n1 2 3\n");
  CHECK(guessed.facts.notes.size() == 1);
}

TEST_CASE("CSV: decimal commas are read unless the separator is a comma") {
  const ParticleFiles files;
  const auto table = files.write("a.csv", "x;y;z;type;v\n1,5;-2;0,25;a,b;3,5\n1;2;3;c;\n");
  const Particles particles = read_particles(table, {.numbers = {"v"}});
  CHECK(particles.positions == std::vector<Vec3d>{{1.5, -2, 0.25}, {1, 2, 3}});
  CHECK(particles.types.names == Names{"a,b", "c"});
  CHECK(particles.numbers[0].values[0] == 3.5);
  CHECK(test::note(particles, "decimal_commas") == 2);
  CHECK(files.message("a.csv", "x,y,z\n\"1,5\",2,3\n").starts_with("a.csv:2: x '1,5' is not"));
  CHECK(files.message("a.csv", "x;y;z\n1.5;2;3\n1,5;2;3\n") ==
        "a.csv:3: the table mixes decimal commas (line 3) and decimal points (line 2): write "
        "points in all numbers");
}

TEST_CASE("CSV: units of columns are kept, and radii get the unit of the positions") {
  const ParticleFiles files;
  for (const char* table :
       {"x [m],y [m],z [m],radius [mm],speed [m/s]\n0,0,0,50,1\n",
        "x_m y_m z_m diameter_mm speed(m/s)\n0 0 0 100 1\n",
        "x,y,z,radius,speed\nm,m,m,mm,m/s\n0,0,0,50,1\n",
        "# %ECSV 1.0\n# datatype:\n# - {name: x, unit: m, datatype: float64}\n"
        "# - {name: y, unit: m, datatype: float64}\n# - {name: z, unit: m, datatype: float64}\n"
        "# - {name: radius, unit: mm, datatype: float64}\n"
        "# - {name: speed, unit: m/s, datatype: float64}\nx y z radius speed\n0 0 0 50 1\n"}) {
    CAPTURE(table);
    const Particles particles = read_particles(files.write("a.csv", table), {.numbers = {"speed"}});
    CHECK(particles.facts.length_unit == "m");
    CHECK(particles.numbers.at(0).unit == "m/s");
    CHECK(particles.radii[0] == doctest::Approx(0.05));
    CHECK(test::note(particles, "converted_radii") == 1);
  }
  const Particles plain = files.read("a.csv", "x [m],y [m],z [m],radius\n0,0,0,50\n");
  CHECK(plain.radii == std::vector<double>{50});
  CHECK(plain.facts.notes.empty());
  CHECK(files.message("a.csv", "x [m],y [m],z [mm]\n0,0,0\n") ==
        "a.csv:1: x is in m, but z is in mm: use one unit for all coordinates");
}

TEST_CASE("CSV: a table of sky coordinates is refused with the formula for positions") {
  const ParticleFiles files;
  const std::string says = ": the table has ra and dec, but no x, y and z: add x = d cos(dec)";
  CHECK(files.message("a.csv", "id,ra,dec,parallax\n1,2,3,4\n").starts_with("a.csv:1" + says));
  CHECK(files.message("a.txt", "# ra dec plx\n2 3 4\n").starts_with("a.txt:1" + says));
}

}  // namespace parray

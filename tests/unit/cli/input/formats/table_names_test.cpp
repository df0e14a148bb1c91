#include "cli/input/formats/table_names.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "tests/support/message_of.h"
#include "tests/support/molecule_files.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::Names;

using Words = std::vector<std::string_view>;

std::string unit_for(const std::string& header) {
  return unit_of_positions(table_names(words_of_header(header)), {});
}

}  // namespace

TEST_CASE("positions have the names of many programs, also with a unit") {
  for (const char* header :
       {"x y z", "X [m] Y [m] Z [m]", "x(mm) y(mm) z(mm)", "x_pc,y_pc,z_pc", "X_PC\tY_PC\tZ_PC",
        "Rx Ry Rz", "pos_x;pos_y;pos_z", "pos_x_mm,pos_y_mm,pos_z_mm",
        R"("Points:0","Points:1","Points:2")", "Position (X),Position (Y),Position (Z)",
        "pos[0],pos[1],pos[2]", "xu yu zu", "x [-],y [-],z [-]"}) {
    CAPTURE(header);
    const TableNames table = table_names(words_of_header(header));
    CHECK(table.has_positions);
    CHECK(table.names == Names{"x", "y", "z"});
  }
  for (const char* header : {"vx vy vz", "fx fy fz", "nx ny nz", "x_vel y_vel z_vel", "a b c",
                             "\u0394x \u0394y \u0394z", "x_pc y_kpc z_pc", "x y depth"}) {
    CAPTURE(header);
    CHECK_FALSE(table_names(words_of_header(header)).has_positions);
  }
}

TEST_CASE("a column x without y and z does not hide positions with other names") {
  const TableNames table = table_names(words_of_header("x pos_x pos_y pos_z"));
  CHECK(table.has_positions);
  CHECK(table.names == Names{"other x", "x", "y", "z"});
  CHECK(table_names(words_of_header("x y z pos_x pos_y pos_z")).names ==
        Names{"x", "y", "z", "pos_x", "pos_y", "pos_z"});
  CHECK_FALSE(table_names(words_of_header("x y pos_z")).has_positions);
}

TEST_CASE("units stand in brackets after names, or at the end of names of lengths") {
  const TableNames table =
      table_names(Words{"x [\u00b5m]", "y (um)", "z_micron", "Radius_MM", "speed [m/s]", "c_s[1]",
                        "v (x)", "q [-]", "n [1]", "w_mm", "bad [\xff]", "x_err"});
  CHECK(table.names == Names{"x", "y", "z", "radius", "speed", "c_s[1]", "v (x)", "q", "n", "w_mm",
                             "bad", "x_err"});
  CHECK(table.units == Names{"um", "um", "um", "mm", "m/s", "", "", "", "", "", "", ""});
}

TEST_CASE("positions have one unit of length, or none") {
  CHECK(unit_for("x_pc y_pc z_pc") == "pc");
  CHECK(unit_for("x [A],y [\u00c5],z [angstrom]") == "angstrom");
  CHECK(unit_for("x [\xb5m],y [\xb5m],z [\xb5m]") == "um");  // Latin-1
  CHECK(unit_for("x [px],y [px],z [px]") == "px");
  CHECK(unit_for("x y z").empty());
  CHECK(test::message_of<InputError>([] { unit_for("x [m],y [m],z [mm]"); }) ==
        ": x is in m, but z is in mm: use one unit for all coordinates");
  CHECK(test::message_of<InputError>([] { unit_for("x [m],y,z [m]"); }) ==
        ": x is in m, but y is in no unit: use one unit for all coordinates");
}

TEST_CASE("brackets belong to the name before them, and in a line of units each is one word") {
  CHECK(words_of_header("x [m] y (m) vx [km / s]") == Words{"x [m]", "y (m)", "vx [km / s]"});
  CHECK(words_of_header("[m] (m) [km / s]") == Words{"[m]", "(m)", "[km / s]"});
}

TEST_CASE("a row of units gives all columns their units if it has lengths for positions") {
  TableNames table = table_names({"x", "y", "z", "v"});
  CHECK_FALSE(take_units({"1", "2", "3", "4"}, table));
  CHECK_FALSE(take_units({"m", "m", "mm", "m/s"}, table));
  CHECK_FALSE(take_units({"m", "m", "m"}, table));
  CHECK(table.units == Names(4));
  CHECK(take_units({"(m)", "[m]", "m", "[m/s]"}, table));
  CHECK(table.units == Names{"m", "m", "m", "m/s"});
}

TEST_CASE("sky coordinates are refused with the formula, unless there are positions") {
  const auto refusal = [](const std::string& header) {
    return test::message_of<InputError>(
        [&] { refuse_sky_coordinates(table_names(words_of_header(header)), {.file = "a"}); });
  };
  CHECK(refusal("source_id,ra,dec,parallax") ==
        "a: the table has ra and dec, but no x, y and z: add x = d cos(dec) cos(ra), "
        "y = d cos(dec) sin(ra), z = d sin(dec), where d is the distance, 1000 / parallax in "
        "parsecs");
  CHECK(refusal("RAJ2000 DEJ2000").ends_with("where d is the distance"));
  CHECK(refusal("GLON,GLAT,dist").starts_with("a: the table has glon and glat, but"));
  CHECK(refusal("ra,dec,x,y,z") == "no error");
  CHECK(refusal("a,b,c") == "no error");
}

}  // namespace parray

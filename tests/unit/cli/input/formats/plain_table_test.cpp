// Tables of numbers without names of columns.

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "cli/output/picture/srgb.h"
#include "tests/support/particle_columns.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::everything;
using test::names_of;
using test::ParticleFiles;

/// Returns the text of the note on the columns; empty: none.
std::string note_on(const Particles& particles) {
  for (const ParticleNote& note : particles.facts.notes) {
    if (note.key == "guessed_columns") return note.text;
  }
  return "";
}

std::string read_as(const std::string& columns) {
  return "particles in a table without names of columns, read as " + columns;
}

Vec3d srgb(int red, int green, int blue) {
  return linear_of_srgb8(
      {static_cast<double>(red), static_cast<double>(green), static_cast<double>(blue)});
}

}  // namespace

TEST_CASE("three columns are positions with every separator, under every name") {
  const ParticleFiles files;
  const std::vector<Vec3d> positions{{1.5, -2, 3}, {4, 5e-1, 6}};
  for (const char* table :
       {"1.5 -2 3\n4 5e-1 6\n", "1.5,-2,3\n4,5e-1,6\n", "1.5, -2, 3\n4, 5e-1, 6",
        "1.5;-2;3\n4;5e-1;6\n", "1.5\t-2\t3\r\n4\t5e-1\t6\r\n", "\"1.5\",\"-2\",\"3\"\n4,5e-1,6\n",
        "# made by hand\n1.5 -2 3\n\n// more\n% and more\n  4 5e-1 6  \n", "1.5,-2,3,\n4,5e-1,6,\n",
        "1,5 -2 3\n4 5e-1 6\n", "1,5;-2;3\n4;0,5;6\n", "1,5\t-2\t3\n4\t0,5\t6\n",
        "2\n1.5 -2 3\n4 5e-1 6\n", "0,1,2\n1.5,-2,3\n4,5e-1,6\n",
        ",0,1,2\n0,1.5,-2,3\n1,4,5e-1,6"}) {
    for (const char* name : {"a.txt", "a.xyz", "a.pts", "a.csv", "a.asc", "a.pdb", "noname"}) {
      CAPTURE(table);
      CAPTURE(name);
      const Particles particles = files.read(name, table);
      CHECK(particles.facts.format == "CSV");
      CHECK(particles.positions == positions);
      CHECK(particles.radii.empty());
      CHECK(note_on(particles).starts_with(read_as("x, y, z")));
    }
  }
}

TEST_CASE("tables of whole numbers are no POSCAR, though their lines look like counts of atoms") {
  const ParticleFiles files;
  const std::string rows = "0 0 1\n0 1 0\n1 0 0\n1 1 0\n2 1 1\n2 2 1\n";
  CHECK(files.read("a.txt", rows + "3 1 1\n3 2 1\n").count() == 8);
  CHECK(files.read("a.txt", "x y z\n" + rows + "3 1 1\n").count() == 7);
}

TEST_CASE("the fourth of four columns is the radius if all its numbers are positive") {
  const ParticleFiles files;
  const Particles grains = files.read("a.txt", "0 0 0 0.5\n1 2 3 0.25\n");
  CHECK(grains.radii == std::vector<double>{0.5, 0.25});
  CHECK(note_on(grains) == read_as("x, y, z, radius"));
  const auto scan = files.write("b.txt", "0 0 0 0.5\n1 2 3 0\n");
  CHECK(read_particles(scan).radii.empty());
  const Particles read = read_particles(scan, everything);
  CHECK(note_on(read) == read_as("x, y, z, c4"));
  CHECK(names_of(read) == "c4");
  CHECK(read.numbers[0].values == std::vector<double>{0.5, 0});
}

TEST_CASE("the last of six columns are colours if they are whole numbers to 255") {
  const ParticleFiles files;
  const Particles cloud = files.read("a.xyz", "0 0 0 255 0 128\n1 1 1 1 1.0 2.55e+02\n");
  CHECK(cloud.colors == std::vector<Vec3d>{srgb(255, 0, 128), srgb(1, 1, 255)});
  CHECK(note_on(cloud) == read_as("x, y, z, red, green, blue"));
  for (const char* table : {"0 0 0 255 0 128\n1 1 1 1 1 256\n", "0 0 0 255 0 128\n1 1 1 1 1 0.5\n",
                            "0 0 0 0 0 1\n1 1 1 0 0 0\n", "0 0 0 9 9 9\n1 1 1 9 9 -9\n"}) {
    CAPTURE(table);
    const Particles velocities = read_particles(files.write("b.txt", table), everything);
    CHECK(velocities.colors.empty());
    CHECK(names_of(velocities) == "c4 c5 c6");
    CHECK(note_on(velocities) == read_as("x, y, z, c4, c5, c6"));
  }
}

TEST_CASE("further columns are numbers on request, named by their place") {
  const ParticleFiles files;
  const auto seven = files.write("a.txt", "0 0 0 9 255 0 7\n1 1 1 8 0 255 6\n");
  CHECK(read_particles(seven).numbers.empty());
  CHECK(read_particles(seven).colors.empty());
  const Particles last = read_particles(seven, {.numbers = {"c7"}});
  CHECK(names_of(last) == "c7");
  CHECK(last.numbers[0].values == std::vector<double>{7, 6});
  CHECK(names_of(read_particles(seven, everything)) == "c4 c5 c6 c7");
  CHECK(note_on(files.read("b.txt", "1 2 3 4 5 6 7 8 9 10 11\n1 2 3 4 5 6 7 8 9 10 11\n")) ==
        read_as("x, y, z, c4, c5, c6, c7 to c11"));
}

TEST_CASE("a scan with a count has an intensity before its colours") {
  const ParticleFiles files;
  const auto scan = files.write("a.pts", "2\n0 0 0 -1200 255 0 7\n1 1 1 300 0 255 6\n");
  const Particles cloud = read_particles(scan, everything);
  CHECK(cloud.colors == std::vector<Vec3d>{srgb(255, 0, 7), srgb(0, 255, 6)});
  CHECK(names_of(cloud) == "c4");
  CHECK(cloud.numbers[0].values == std::vector<double>{-1200, 300});
}

TEST_CASE("a note tells of decimal commas, and a table that also has points is refused") {
  const ParticleFiles files;
  CHECK(note_on(files.read("a.csv", "1,5;2;3\n4,5;2;3\n")) ==
        read_as("x, y, z, with decimal commas"));
  CHECK(files.message("a.csv", "1,5;2;3\n4;5;6\n7;8.5;9\n") ==
        "a.csv:3: the table mixes decimal commas (line 1) and decimal points (line 3): write "
        "points in all numbers");
}

TEST_CASE("a table of numbers with a wrong row is refused with the row's line") {
  const ParticleFiles files;
  const auto message = [&](const std::string& text) { return files.message("a.txt", text); };
  CHECK(message("1 2 3\n4 5 6\n7 nan 9\n") ==
        "a.txt:3: y 'nan' is not a finite number: write a number such as 0.5 or 1e3");
  CHECK(message("nan 2 3\n4 5 6\n").starts_with("a.txt:1: x 'nan' is not a finite number"));
  CHECK(message("-inf,2,3\n4,5,6\n").starts_with("a.txt:1: x '-inf' is not a finite number"));
  CHECK(message("1 2 3 4 5\n1 2 3 4 5\n1 2 3 4 nan\n") ==
        "a.txt:3: c5 'nan' is not a finite number: write a number, or add a header line with the "
        "names of the columns");
  CHECK(message("1 2 3\n4 5 6\n7 8\n") ==
        "a.txt:3: 2 values, but the first row has 3: use the same number");
  CHECK(message("1 2 3\n4 5 6\nC 7 8\n").starts_with("a.txt:3: x 'C' is not a finite number"));
  CHECK(message("1 2 3\n4 5 1e16\n").starts_with("a.txt:2: coordinate 1e+16 is out of range"));
  CHECK(message("3\n1 2 3.5\n4 5 6\n") ==
        "a.txt:3: the file ends after 2 of 3 particles: check that the file is complete");
  CHECK(message("1\n1 2 3.5\n4 5 6\n") ==
        "a.txt:3: text follows the last particle: check the number of particles in the first line");
}

TEST_CASE("XYZ with a comment of numbers stays XYZ, and tables of other things are no tables") {
  const ParticleFiles files;
  for (const char* text :
       {"2\n\n8 0 0 0\n1 1 0 0\n", "2\n1 2 3 4\n8 0 0 0\n1 1 0 0\n", "2\n0.5\n8 0 0 0\n1 1 0 0\n",
        "1\n1 2 3\nC 0 0 0\n", "2\n1 2 3\n8 0 0 0\n1 1 0 0\n"}) {
    CAPTURE(text);
    CHECK(files.read("a", text).facts.format == "XYZ");
    CHECK(files.read("a.csv", text).facts.format == "XYZ");
  }
  CHECK(files.read("a.xyz", "2\n8 0 0 1\n1 1 0 1\n").facts.format ==
        "CSV");  // two rows, no comment
  for (const char* text :
       {"1 2\n3 4\n", "%%MatrixMarket matrix coordinate real general\n3 3 1\n1 1 5\n",
        "one two three\nfour five six\n", "C 0 0 0\nO one 0 0\n"}) {
    CAPTURE(text);
    CHECK(files.message("a.txt", text).find("neither a scene nor a particle file") !=
          std::string::npos);
  }
}

}  // namespace parray

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_trajectories.h"

namespace parray {
namespace {

using test::message_of;
using test::ParticleFiles;

const std::string water_psf = test::psf();
const std::string water_prmtop = test::prmtop();
const std::string water_data =
    "water\n\n3 atoms\n2 atom types\n0 9 xlo xhi\n0 9 ylo yhi\n0 9 zlo zhi\n\nMasses\n\n"
    "1 1.008\n2 15.9994\n\nAtoms # full\n\n30 1 1 0.4 5 0 0\n10 1 2 -0.8 6 0 0\n20 1 1 0.4 7 0 0\n";

/// A dump of atoms at x = 1, 2, 3 with these ids.
std::string dump_of(const std::vector<std::string>& ids) {
  std::string text =
      "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n3\nITEM: BOX BOUNDS pp pp pp\n0 8\n0 8\n0 8\n"
      "ITEM: ATOMS id x y z\n";
  for (std::size_t i = 0; i < ids.size(); ++i) {
    text += ids[i] + " " + std::to_string(i + 1) + " 0 0\n";
  }
  return text;
}

/// That dump with the topology of water, O H H, without numbers.
Particles water_dump(const ParticleFiles& files, const std::vector<std::string>& ids) {
  ParticleRequest request;
  request.topology = files.write("a.psf", water_psf);
  return read_particles(files.write("a.dump", dump_of(ids)), request);
}

std::size_t unsorted_notes(const Particles& particles) {
  return static_cast<std::size_t>(
      std::ranges::count(particles.facts.notes, "unsorted_atoms", &ParticleNote::key));
}

std::string three_atoms() { return test::dcd_file({{{1, 0, 0}, {2, 0, 0}, {3, 0, 0}}}); }

/// The trajectory with that topology.
Particles with(const ParticleFiles& files, const std::string& name, const std::string& topology) {
  ParticleRequest request{.numbers = {"charge"}};
  request.topology = files.write(name, topology);
  return read_particles(files.write("a.dcd", three_atoms()), request);
}

}  // namespace

TEST_CASE("a trajectory takes elements, names and charges from PSF and PRMTOP") {
  const ParticleFiles files;
  for (const auto& row : {std::pair("a.psf", water_psf), {"a.prmtop", water_prmtop}}) {
    const auto& [name, text] = row;  // which Clang 14 does not capture
    CAPTURE(row.first);
    const Particles water = with(files, name, text);
    CHECK(water.positions[2].x == 3);
    CHECK(water.elements == std::vector<std::uint8_t>{8, 1, 1});
    CHECK(water.atom_names.of(1) == "H1");
    CHECK(water.residue_names.names.size() == 1);
    CHECK(water.residue_numbers.size() == 3);
    REQUIRE(water.numbers.size() == 1);
    CHECK(std::abs(water.numbers[0].values[0] + 0.834) < 1e-6);
    for (const ParticleNote& note : water.facts.notes) CHECK(note.key != "nameless");
  }
}

TEST_CASE("a trajectory without a topology says that its particles are nameless") {
  const ParticleFiles files;
  const Particles bare = read_particles(files.write("a.dcd", three_atoms()), {});
  REQUIRE(bare.facts.notes.size() == 1);
  CHECK(bare.facts.notes[0].key == "nameless");
  CHECK(bare.facts.notes[0].count == 3);
}

TEST_CASE("atoms of a numbered topology are used in the order of their numbers") {
  const ParticleFiles files;
  const Particles water = with(files, "a.data", water_data);
  CHECK(water.elements == std::vector<std::uint8_t>{8, 1, 1});
  CHECK(water.types.of(0) == "2");
  CHECK(water.numbers.at(0).values == std::vector<double>{-0.8, 0.4, 0.4});
  CHECK(water.numbers.size() == 1);
}

TEST_CASE("numbered particles take the atom with the same number") {
  const ParticleFiles files;
  ParticleRequest request;
  request.topology = files.write("a.data", water_data);
  const Particles water =
      read_particles(files.write("a.dump", dump_of({"20", "30", "10"})), request);
  CHECK(water.elements == std::vector<std::uint8_t>{1, 1, 8});
  CHECK(water.positions[2].x == 3);
  CHECK(water.numbers.empty());
  CHECK(unsorted_notes(water) == 0);
}

TEST_CASE("atoms of a topology without numbers go to an unsorted dump in the order of its ids") {
  const ParticleFiles files;
  for (const std::vector<std::string>& ids :
       {std::vector<std::string>{"2", "3", "1"}, std::vector<std::string>{"20", "30", "7"}}) {
    const Particles water = water_dump(files, ids);
    CHECK(water.elements == std::vector<std::uint8_t>{1, 1, 8});
    CHECK(water.atom_names.of(0) == "H1");
    CHECK(water.atom_names.of(1) == "H2");
    CHECK(water.positions[2].x == 3);
    CHECK(water.numbers.empty());
    CHECK(unsorted_notes(water) == 1);
  }
}

TEST_CASE("a sorted dump takes the names of its topology without a note") {
  const ParticleFiles files;
  const Particles water = water_dump(files, {"1", "2", "3"});
  CHECK(water.elements == std::vector<std::uint8_t>{8, 1, 1});
  CHECK(unsorted_notes(water) == 0);
}

TEST_CASE("an unsorted dump in which an id occurs twice takes no names") {
  const ParticleFiles files;
  const std::string message = message_of<InputError>([&] { water_dump(files, {"2", "1", "2"}); });
  CHECK(message.ends_with(
      "a.dump: the atoms are unsorted, and several have the id 2, so the names of the topology "
      "cannot be matched: sort the file by atoms, such as with dump_modify sort id"));
}

TEST_CASE("a topology with a different number of atoms is refused with both numbers") {
  const ParticleFiles files;
  const std::string message =
      message_of<InputError>([&] { with(files, "a.xyz", "2\n\nC 0 0 0\nO 1 0 0\n"); });
  CHECK(message.find("a.xyz: 2 atoms, but ") != std::string::npos);
  CHECK(message.ends_with("a.dcd has 3: name the topology of the same atoms"));
}

TEST_CASE("a file with only names is refused as particles, with a remedy") {
  const ParticleFiles files;
  CHECK(
      files.message("a.psf", water_psf) ==
      "a.psf: a PSF file has no positions: name a trajectory, and give this file as its topology");
}

TEST_CASE(
    "PSF: rows without a segment are read; names give the elements of atoms with unknown mass") {
  const ParticleFiles files;
  const Particles drude = with(files, "a.psf",
                               "PSF\n\n 3 !NATOM\n 1 1 ALA CA CD31C 0.1 11.6110 0\n"
                               " 2 1 ALA DCA DRUD -1 0.4 0\n 3 1 ALA HA HDA1A 0.1 1.008 0\n");
  CHECK(drude.elements == std::vector<std::uint8_t>{6, 0, 1});
  CHECK(drude.residue_names.of(0) == "ALA");
  CHECK(drude.chains.empty());
}

}  // namespace parray

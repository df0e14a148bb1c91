#include "cli/input/particles/guess_element.h"

#include <doctest/doctest.h>

#include <string>
#include <string_view>

#include "cli/input/particles/elements.h"
#include "cli/input/particles/residues.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

std::string guess(std::string_view residue, std::string_view name, bool two_letters = false) {
  const std::uint8_t number = guess_element({residue, name, two_letters, true});
  return number == 0 ? "?" : std::string(element(number).symbol);
}

std::string label(std::string_view name) {
  const std::uint8_t number = guess_element({"", name, false, false});
  return number == 0 ? "?" : std::string(element(number).symbol);
}

}  // namespace

TEST_CASE("elements: in amino acids, nucleotides and water the first letter counts, not a metal") {
  for (const bool two_letters : {false, true}) {
    CAPTURE(two_letters);
    CHECK(guess("ALA", "CA", two_letters) == "C");
    CHECK(guess("SER", "HG", two_letters) == "H");
    CHECK(guess("LYS", "CE", two_letters) == "C");
    CHECK(guess("LYS", "NZ", two_letters) == "N");
    CHECK(guess("ARG", "CD", two_letters) == "C");
    CHECK(guess("ARG", "NE", two_letters) == "N");
    CHECK(guess("CYS", "SG", two_letters) == "S");
    CHECK(guess("TYR", "HE2", two_letters) == "H");
    CHECK(guess("TYR", "HO", two_letters) == "H");
    CHECK(guess("NALA", "1HB", two_letters) == "H");
    CHECK(guess("DA5", "O5'", two_letters) == "O");
    CHECK(guess("GUA", "P", two_letters) == "P");
    CHECK(guess("TIP3", "OH2", two_letters) == "O");
    CHECK(guess("SOL", "HW1", two_letters) == "H");
    CHECK(guess("DOD", "D1", two_letters) == "H");
  }
  CHECK(guess("MSE", "SE") == "Se");
  CHECK(guess("SEC", "SEG") == "Se");
}

TEST_CASE("elements: the residue identifies an ion, with the names of all force fields") {
  CHECK(guess("CA", "CA") == "Ca");
  CHECK(guess("CAL", "CAL") == "Ca");
  CHECK(guess("SOD", "SOD") == "Na");
  CHECK(guess("CLA", "CLA") == "Cl");
  CHECK(guess("POT", "POT") == "K");
  CHECK(guess("Na+", "Na+") == "Na");
  CHECK(guess("Cl-", "Cl-") == "Cl");
  CHECK(guess("CIO", "IP") == "Na");
  CHECK(guess("ION", "MG") == "Mg");
  CHECK(guess("ZN2", "ZN") == "Zn");
  CHECK(guess("HG", "HG") == "Hg");
  // Chlorophyll is called CLA, too.
  CHECK(guess("CLA", "CHA") == "C");
  CHECK(guess("CLA", "MG") == "Mg");
  CHECK(is_ion("CLA", "CLA"));
  CHECK(!is_ion("CLA", "MG"));
  CHECK(!is_ion("ALA", "CA"));
}

TEST_CASE("elements: in other residues, halogens and metals count if no other name starts so") {
  CHECK(guess("LIG", "CA") == "C");
  CHECK(guess("LIG", "CA", true) == "Ca");
  CHECK(guess("LIG", "CL1") == "Cl");
  CHECK(guess("LIG", "BRAA") == "Br");
  CHECK(guess("HEM", "FE") == "Fe");
  CHECK(guess("HEM", "NA") == "N");
  CHECK(guess("LIG", "HG1", true) == "H");
  CHECK(guess("LIG", "Ca1") == "C");  // an alpha carbon in any case
  CHECK(guess("LIG", "FAB") == "F");
  CHECK(guess("LIG", "I1") == "I");
  CHECK(guess("LIG", "K") == "K");
  CHECK(guess("NAD", "AC2", true) == "C");
  CHECK(guess("NAD", "NO1", true) == "O");
  CHECK(guess("NAD", "NP") == "P");
  CHECK(guess("LIG", "2H5'") == "H");
}

TEST_CASE("elements: beads of coarse models and names without letters have no element") {
  CHECK(guess("ALA", "BB") == "?");
  CHECK(guess("PHE", "SC2") == "?");
  CHECK(guess("W", "W") == "?");
  CHECK(guess("LIG", "1") == "?");
  CHECK(guess("LIG", "") == "?");
}

TEST_CASE("elements: labels of crystals start with the symbol") {
  CHECK(label("Ca1") == "Ca");
  CHECK(label("CA1") == "Ca");
  CHECK(label("C12A") == "C");
  CHECK(label("CN1") == "C");
  CHECK(label("HO1") == "H");
  CHECK(label("O1W") == "O");
  CHECK(label("Si1") == "Si");
}

TEST_CASE("columns: names that start in PDB's column 13 without reason show files that ignore it") {
  CHECK(shows_flush_left("ALA", "CA"));
  CHECK(shows_flush_left("LIG", "C1"));
  CHECK(shows_flush_left("WAT", "O"));
  CHECK(!shows_flush_left("CA", "CA"));
  CHECK(!shows_flush_left("MSE", "SE"));
  CHECK(!shows_flush_left("LIG", "CL1"));
  CHECK(!shows_flush_left("VAL", "HG11"));  // four characters have no other place
  CHECK(!shows_flush_left("ALA", "1HB"));
}

TEST_CASE("virtual sites: those of water models, rigid groups and lone pairs, by their names") {
  CHECK(is_virtual_site("SOL", "MW", 0));
  CHECK(is_virtual_site("WAT", "EPW", 0));
  CHECK(is_virtual_site("TIP4", "OM", 8));  // some writers give it an element
  CHECK(is_virtual_site("TIP5P", "LP1", 0));
  CHECK(is_virtual_site("ALA", "MCB1", 0));
  CHECK(is_virtual_site("LYS", "MNZ2", 0));
  CHECK(is_virtual_site("LIG", "LP1A", 0));
  CHECK(is_virtual_site("DUM", "N", 7));
  CHECK(is_virtual_site("", "Du", 0));
  CHECK(!is_virtual_site("SOL", "OW", 8));
  CHECK(!is_virtual_site("DOD", "D1", 1));
  CHECK(!is_virtual_site("CLA", "MG", 12));
  CHECK(!is_virtual_site("MN", "MN", 25));
  CHECK(!is_virtual_site("LIG", "X1", 17));
}

TEST_CASE("residues: words for water, amino acids and nucleotides know the force fields' names") {
  for (const char* name : {"HOH", "WAT", "SOL", "tip3", "TIP4P", "SPCE", "DOD"}) {
    CHECK(is_water(name));
  }
  for (const char* name : {"ALA", "HSD", "HIE", "CYX", "NALA", "CARG", "MSE", "ace"}) {
    CHECK(is_amino_acid(name));
  }
  for (const char* name : {"A", "DG", "DC5", "RU3", "GUA", "PSU", "A5"}) CHECK(is_nucleotide(name));
  for (const char* name : {"", "LIG", "POPC", "HEM", "NAG", "ANYTHINGLONGER"}) {
    CAPTURE(name);
    CHECK(!is_water(name));
    CHECK(!is_amino_acid(name));
    CHECK(!is_nucleotide(name));
    CHECK(ion_element(name) == 0);
  }
}

}  // namespace parray

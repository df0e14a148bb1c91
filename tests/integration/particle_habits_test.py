#!/usr/bin/env python3
"""Small files (tests/corpus/small) that each have a peculiarity of a program of the field. Checks the output of `parray
validate`: elements, frames, and notes of what was guessed or left out."""

import bz2
import json
import lzma
import pathlib
import unittest

from cli_usage_test import CliTest
from farm import run

SMALL = pathlib.Path(__file__).resolve().parents[1] / "corpus" / "small"


class Habits(CliTest):
    def said(self, path, *options):
        result = run("validate", path, "--json", *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout)["particle_files"][0]

    def holds(self, name, particles, elements=None, notes=None, frames=None):
        """`notes`: those that must be there, with their counts."""
        said = self.said(SMALL / name)
        self.assertEqual((said["particles"], said.get("elements")), (particles, elements))
        counts = {note["key"]: note["count"] for note in said["notes"]}
        self.assertEqual({key: counts.get(key) for key in notes or {}}, notes or {})
        if frames:
            self.assertEqual(said["frames"], frames)

    def test_names_that_begin_a_column_early_are_no_metals(self):
        self.holds("flush_left.pdb", 14, {"H": 2, "C": 3, "N": 2, "O": 2, "Na": 1, "Cl": 1, "K": 1, "Ca": 1, "unknown": 1},
                   {"guessed_elements": 13})

    def test_a_residue_that_begins_in_the_column_of_alternatives_loses_no_atom(self):
        self.holds("residue_in_column_17.pdb", 5, {"H": 2, "C": 3})

    def test_alternatives_left_out_are_counted(self):
        self.holds("alternatives.pdb", 3, {"C": 1, "N": 1, "O": 1}, {"alternatives": 2})

    def test_all_alternatives_are_counted_where_all_are_asked_for(self):
        said = self.said(SMALL / "alternatives.pdb", "--alternatives", "all")
        self.assertEqual((said["particles"], said["notes"]), (5, []))

    def test_blanks_and_tabs_between_the_columns_of_pdb_are_read(self):
        self.holds("tabs.pdb", 1, {"C": 1}, {"guessed_elements": 1})

    def test_numbers_of_types_are_no_elements_and_atomic_numbers_are(self):
        self.holds("types.xyz", 3, None, {"numbers_as_types": 3})
        self.holds("numbers.xyz", 3, {"H": 2, "O": 1})

    def test_a_virtual_site_is_no_element_and_nanometres_become_angstrom(self):
        self.holds("virtual_site.gro", 4, {"H": 2, "O": 1, "unknown": 1}, frames=2)
        self.assertEqual(self.said(SMALL / "virtual_site.gro")["cell"]["lengths"], [10, 10, 10])

    def test_types_of_autodock_are_elements(self):
        self.holds("autodock_types.pdbqt", 7, {"H": 1, "C": 2, "N": 1, "O": 1, "S": 1, "Cl": 1})

    def test_pqr_may_lack_the_chain(self):
        self.holds("no_chain.pqr", 3, {"H": 2, "O": 1}, {"guessed_elements": 3})

    def test_every_molecule_is_a_frame_and_a_query_no_element(self):
        self.holds("two_molecules.sdf", 3, {"H": 1, "C": 1, "unknown": 1}, {"unknown_elements": 1}, frames=2)

    def test_the_cell_of_a_crystal_is_filled_by_its_symmetry(self):
        self.holds("second_block.cif", 8, {"Na": 4, "Cl": 4})
        self.holds("shared_site.cif", 3, {"O": 2, "Cu": 1}, {"alternatives": 1})

    def test_atoms_without_a_place_are_counted(self):
        self.holds("component.cif", 2, {"C": 1, "O": 1}, {"unplaced": 1})

    def test_a_dump_without_an_ending_may_begin_with_an_empty_frame(self):
        self.holds("dump.empty_first", 2, notes={"empty_frames": 1})

    def test_ply_may_end_its_lines_in_cr_and_itself_in_a_line_more(self):
        self.holds("lone_cr.ply", 3)
        self.holds("one_byte_more.ply", 2)

    def test_a_packed_file_says_what_the_file_says(self):
        plain = self.said(SMALL / "flush_left.pdb")
        for name, pack in (("a.pdb.bz2", bz2.compress), ("a", bz2.compress), ("a.pdb.xz", lzma.compress)):
            self.path(name).write_bytes(pack((SMALL / "flush_left.pdb").read_bytes()))
            packed = self.said(self.path(name))
            self.assertTrue(packed.pop("packing"))
            self.assertEqual({**packed, "file": plain["file"]}, {key: value for key, value in plain.items() if key != "packing"})


if __name__ == "__main__":
    unittest.main()

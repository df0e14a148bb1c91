#!/usr/bin/env python3
"""Only the kernels that are chosen at run time contain instructions that an old processor lacks."""

import os
import pathlib
import re
import shutil
import subprocess
import unittest

BIN = pathlib.Path(os.environ["PARRAY_BIN_DIR"])
BUILD = BIN.parent
ISAS = ("avx2", "avx512")
# AVX of any width has mnemonics with a v; mask registers are AVX-512's.
NEW_INSTRUCTION = re.compile(r"\tv\S+\s.*%[xyz]mm|%[yz]mm|%k[0-7]\b")
SYMBOL = re.compile(r"^[0-9a-f]+ <(.*)>:$")
OF_KERNELS = re.compile(r"(?<!\d)(4avx2|6avx512)")  # a mangled name that contains such a namespace


def output(*command):
    return subprocess.run(list(map(str, command)), check=True, capture_output=True, text=True).stdout


def kernel_object(isa):
    found = list(BUILD.rglob(f"parray_kernels_{isa}.dir/**/*.o"))  # one, whatever a unity build calls it
    return found[0] if len(found) == 1 else None


def belongs_to(isa, symbol):
    return re.search(rf"parray::\w+::{isa}::", symbol) is not None


@unittest.skipUnless(shutil.which("nm") and shutil.which("objdump"), "binutils are not installed")
@unittest.skipUnless(kernel_object("avx2"), "no kernels of several instruction sets in this build")
class IsaSymbols(unittest.TestCase):
    def test_the_linker_has_no_choice_among_copies_of_different_instruction_sets(self):
        for isa in ISAS:
            lines = output("nm", "-C", "--defined-only", kernel_object(isa)).splitlines()
            symbols = [line.split(maxsplit=2) for line in lines]
            self.assertTrue(any(f"parray::trace::{isa}::kernels<" in s[2] for s in symbols if s[1] in "TW"))
            shared = [s[2] for s in symbols
                      # What the compiler emits for exceptions is a pointer, not instructions.
                      if s[1] in "WVu" and not belongs_to(isa, s[2])
                      and not s[2].startswith("DW.ref.")]
            self.assertEqual(shared, [], f"{isa}: weak, so any file's copy may be the one kept")

    def test_kernels_of_one_instruction_set_are_used_by_no_other(self):
        for isa, other in (ISAS, reversed(ISAS)):
            for line in output("nm", "-C", kernel_object(isa)).splitlines():
                self.assertFalse(belongs_to(other, line), line)

    def test_the_program_has_new_instructions_in_kernels_alone(self):
        symbol, outside, inside = "", set(), 0
        # The other programs have the same libraries.
        for line in output("objdump", "-d", "--no-show-raw-insn", BIN / "parray").splitlines():
            if line.endswith(">:"):
                symbol = SYMBOL.match(line)[1]
            elif ("%k" in line or "mm" in line) and NEW_INSTRUCTION.search(line):
                if OF_KERNELS.search(symbol):
                    inside += 1
                else:
                    outside.add(symbol)
        self.assertEqual(outside, set())
        self.assertGreater(inside, 1000)  # the search itself finds them


if __name__ == "__main__":
    unittest.main()

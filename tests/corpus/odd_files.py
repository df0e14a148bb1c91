"""Makes files that hide what they are: files of the corpus behind a long header, and small molecules without elements, or with
the types of a force field in their place."""

HEADER_BYTES = 100_000
MDA = "mdanalysistests-2.11.0/MDAnalysisTests/data/"
# Path in the corpus, a line of the header, and the number of lines before it.
BEHIND_HEADERS = (
    (MDA + "1A2C.pqr", "REMARK   5 WARNING: PDB2PQR was unable to assign charges\n", 0),
    (MDA + "5a7u.pdb", "REMARK 465     MET A     1\n", 0),
    (MDA + "4x8u.pdbx", "# a comment\n", 0),
)
# Molecules as (element, x, y, z).
PLATINUM = (("C", 0, 0, 0), ("Pt", 2.1, 0, 0), ("F", 0, 1.4, 0), ("Cl", 4.4, 0, 0))
AMIDE = (("C", 1.808, 1.393, 0), ("H", 2.134, 0.36, 0.01), ("H", 2.185, 1.889, -0.884), ("H", 2.185, 1.879, 0.894),
         ("C", 0.288, 1.393, 0), ("O", -0.33, 2.451, 0), ("N", -0.3, 0.188, 0), ("H", 0.293, -0.631, 0),
         ("C", -1.737, 0.005, 0), ("H", -2.21, 0.981, 0.01), ("H", -2.04, -0.54, 0.89), ("H", -2.04, -0.55, -0.88))
WATER = (("O", 0, 0, 0), ("H", 0.957, 0, 0), ("H", -0.24, 0.927, 0))
BOX = (18.643, 18.643, 18.643, 90.0, 90.0, 90.0)


def babel_pdb(atoms):
    """Returns PDB without a column of elements, as Babel 1.6 writes it."""
    return "".join(f"ATOM  {i:5} {e:>2}   UNK     1    {x:8.3f}{y:8.3f}{z:8.3f}  1.00  0.00\n"
                   for i, (e, x, y, z) in enumerate(atoms, 1))


def opls_mol2(atoms):
    """Returns MOL2 with types of OPLS, which do not show the element."""
    rows = "".join(f"{i} {e}{i} {x} {y} {z} opls_{134 + i} 1 NMA 0.0\n" for i, (e, x, y, z) in enumerate(atoms, 1))
    return f"@<TRIPOS>MOLECULE\nNMA\n{len(atoms)} 0 1\nSMALL\nNO_CHARGES\n\n@<TRIPOS>ATOM\n{rows}"


def boxed_tinker(atoms):
    rows = "".join(f"{i:6}  {e:<3}{x:12.6f}{y:12.6f}{z:12.6f}{i:6}\n" for i, (e, x, y, z) in enumerate(atoms, 1))
    return f"{len(atoms):6}\n" + "".join(f"{value:12.6f}" for value in BOX) + "\n" + rows


# Name: the text, the atoms, the cell.
MOLECULES = {"babel.pdb": (babel_pdb(PLATINUM), PLATINUM, None), "opls.mol2": (opls_mol2(AMIDE), AMIDE, None),
             "boxed.txyz": (boxed_tinker(WATER), WATER, BOX)}


def facts_of(path):
    """Returns the facts about a molecule of this source. Returns none for other files."""
    if path.parent.name != "made" or path.name not in MOLECULES:
        return []
    import field  # here, because making the files needs no other program

    _, atoms, cell = MOLECULES[path.name]
    return [field.known("odd_files.py", [atom[1:] for atom in atoms], [atom[0] for atom in atoms], cell)]


def make(base):
    """Makes the files in base/made."""
    where = base / "made"
    where.mkdir(parents=True, exist_ok=True)
    for name, (text, _, _) in MOLECULES.items():
        (where / name).write_text(text)
    for path, line, first in BEHIND_HEADERS:
        source = base / path
        lines = source.read_text(errors="surrogateescape").splitlines(keepends=True)
        header = line * (HEADER_BYTES // len(line) + 1)
        (where / f"header_{source.name}").write_text(
            "".join([*lines[:first], header, *lines[first:]]), errors="surrogateescape")

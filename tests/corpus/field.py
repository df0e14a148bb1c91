"""Reads a file with the programs of the field: gemmi, ASE, MDAnalysis, RDKit, plyfile. Each program and format has a
function. It takes an unpacked file and returns Facts, or passes on the exception of the program."""

import collections
import dataclasses
import math
import re
import warnings

import ase.io
import gemmi
import MDAnalysis
import numpy
import plyfile
from MDAnalysis.coordinates import DCD, GSD, INPCRD, TRJ, TRR, XTC
from MDAnalysis.guesser.default_guesser import DefaultGuesser
from rdkit import Chem, RDLogger

from atoms import atoms_of

RDLogger.DisableLog("rdApp.*")
warnings.simplefilter("ignore")
SYMBOLS = {symbol.upper(): symbol for symbol in (gemmi.Element(z).name for z in range(1, 119))}


@dataclasses.dataclass
class Facts:
    """Facts about the first frame with atoms. Lengths are in angstrom if the format has a unit. None: not known."""
    program: str
    particles: int
    box: list          # [lowest x, y, z], [highest x, y, z]
    elements: dict = None  # count by symbol; "": unknown
    frames: int = None
    cell: list = None  # a, b, c, alpha, beta, gamma
    last_box: list = None  # of the last frame
    last_particles: int = None
    span_only: bool = False  # the program moves the origin: compare only the size of the box
    atoms: tuple = None      # positions and symbols, as from atoms_of()
    bonds: int = None        # that the file states


def box_of(positions):
    positions = numpy.asarray(positions, dtype=float).reshape(-1, 3)
    if not len(positions):
        raise ValueError("no atoms")
    if not numpy.isfinite(positions).all():
        raise ValueError("positions that are not finite")
    return [positions.min(axis=0).tolist(), positions.max(axis=0).tolist()]


def counted(symbols):
    """Returns counts by symbol in its usual spelling. Deuterium counts as hydrogen, other texts as unknown."""
    spelled = ("H" if s.upper() in ("D", "T") else SYMBOLS.get(s.upper(), "") for s in map(str.strip, symbols))
    return dict(collections.Counter(spelled))


def cell_of(values):
    """Returns the cell. Returns None for placeholders: edges of 0 or 1."""
    values = [float(v) for v in values] if values is not None else []
    edges = values[:3]
    if len(values) != 6 or not all(map(math.isfinite, values)) or min(edges) <= 0 or edges == [1, 1, 1]:
        return None
    return values


def of_model(program, structure, **more):
    """Returns the facts about a gemmi structure."""
    models = [[(a.atom.pos.tolist(), a.atom.element.name) for a in model.all()] for model in structure]
    models = [model for model in models if model]
    if not models:
        raise ValueError("no atoms")
    positions, names = zip(*models[0])
    return Facts(program, len(positions), box_of(positions), counted("" if n == "X" else n for n in names), len(models),
                 cell_of(structure.cell.parameters), box_of([p for p, _ in models[-1]]), len(models[-1]),
                 atoms=atoms_of(positions, names), **more)


def gemmi_pdb(path):
    """Reads PDB. If the columns of elements are blank, gemmi uses the columns of the name, as the standard says."""
    facts = of_model("gemmi", gemmi.read_pdb(str(path)))
    with open(path, "rb") as file:
        if any(line[:6] in (b"ATOM  ", b"HETATM") and not line[76:78].strip().isalpha() for line in file):
            facts.elements = None
    return facts


def gemmi_pdbqt(path):
    """Reads a file with the columns of PDB except those of elements."""
    facts = of_model("gemmi", gemmi.read_pdb(str(path)))
    facts.elements = None
    return facts


def mdanalysis_pdbqt(path):
    """Reads a file. The program joins all models."""
    if re.search(r"^MODEL .*^MODEL ", path.read_text(errors="replace"), re.MULTILINE | re.DOTALL):
        raise ValueError("several models")
    return mdanalysis(path, "PDBQT")


def ase_pdb(path):
    """Reads a file whose frames may end with only END."""
    facts = ase_file(path, "proteindatabank")
    facts.elements = None
    return facts


def gemmi_mmcif(path):
    return of_model("gemmi", gemmi.read_structure(str(path), format=gemmi.CoorFormat.Mmcif))


def gemmi_chem_comp(path):
    """Reads one of the two sets of coordinates of a component."""
    facts = []
    for block in gemmi.cif.read(str(path)):
        if not block.find_values("_chem_comp_atom.atom_id"):
            continue
        for kind in (gemmi.ChemCompModel.Xyz, gemmi.ChemCompModel.Example, gemmi.ChemCompModel.Ideal):
            try:
                facts.append(of_model(f"gemmi ({kind.name})", gemmi.make_structure_from_chemcomp_block(block, int(kind.value))))
                facts[-1].frames = facts[-1].cell = None
            except (ValueError, RuntimeError):
                pass
        break
    if not facts:
        raise ValueError("no component with coordinates")
    return facts


def gemmi_small(path):
    """Reads the whole cell, and the listed sites, of the first block with sites."""
    structures = (gemmi.make_small_structure_from_block(block) for block in gemmi.cif.read(str(path)))
    small = next((structure for structure in structures if structure.sites), None)
    if small is None:
        raise ValueError("no sites")
    facts = []
    whole = small.get_all_unit_cell_sites()
    for program, sites, placed in (("gemmi (cell)", whole, lambda fract: fract),
                                   ("gemmi (cell, wrapped)", whole, lambda fract: fract.wrap_to_unit()),
                                   ("gemmi (sites)", small.sites, lambda fract: fract)):
        positions = [small.cell.orthogonalize(placed(site.fract)).tolist() for site in sites]
        names = ["" if site.element.name == "X" else site.element.name for site in sites]
        facts.append(Facts(program, len(sites), box_of(positions), counted(names), None, cell_of(small.cell.parameters),
                           atoms=atoms_of(positions, names)))
    return facts


def of_atoms(program, frames, elements=True, **more):
    """Returns the facts about the frames of ASE."""
    frames = [frame for frame in frames if len(frame)]
    if not frames:
        raise ValueError("no atoms")
    first = frames[0]
    cell = cell_of(first.cell.cellpar()) if first.cell.rank == 3 else None
    names = ["" if s == "X" else s for s in first.get_chemical_symbols()] if elements else None
    return Facts(program, len(first), box_of(first.positions), counted(names) if names else None, len(frames), cell,
                 box_of(frames[-1].positions), atoms=atoms_of(first.positions, names), **more)


def ase_file(path, kind, **more):
    return of_atoms("ASE", ase.io.read(str(path), index=":", format=kind, **more))


def ase_xyz(path):
    return ase_file(path, "extxyz" if "Properties=" in head(path) else "xyz")


def ase_cif(path):
    facts = ase_file(path, "cif")
    facts.frames = facts.last_box = None
    return facts


def ase_poscar(path):
    kind = "vasp-xdatcar" if "configuration=" in head(path) else "vasp"
    return of_atoms("ASE", ase.io.read(str(path), index=":", format=kind))


def ase_dump(path):
    """Reads with ASE, which treats type numbers as elements if the file has no names."""
    text = head(path, 100_000)
    named = re.search(r"^ITEM: ATOMS .*\belement\b", text, re.MULTILINE)
    return of_atoms("ASE", ase.io.read(str(path), index=":", format="lammps-dump-text"), elements=bool(named))


def ase_data(path):
    """Returns the positions in the file, without image flags."""
    atoms = ase.io.read(str(path), format="lammps-data", atom_style=style_of(path), read_image_flags=False)
    return of_atoms("ASE", [atoms], elements=False)


def style_of(path):
    """Returns the atom style. Data files of LAMMPS may name it beside the section's title. Five columns fit only one style.
    "full" is the default of ASE."""
    found = re.search(r"^\s*Atoms[ \t]*(?:#\s*(\w+)[^\n]*)?\n\s*\n([^\n]*)", path.read_text(errors="replace"), re.MULTILINE)
    if found and found[1]:
        return found[1]
    return "atomic" if found and len(found[2].partition("#")[0].split()) == 5 else "full"


def mdanalysis(path, kind, elements=True):
    universe = MDAnalysis.Universe(str(path), format=kind, topology_format=kind, to_guess=())
    frames = universe.trajectory
    first = box_of(universe.atoms.positions)
    cell = cell_of(frames.ts.dimensions)
    count = len(universe.atoms)
    symbols = symbols_of(universe) if elements else None
    atoms = atoms_of(universe.atoms.positions, symbols)
    frames[-1]
    return Facts("MDAnalysis", count, first, symbols and counted(symbols), frames.n_frames, cell,
                 box_of(universe.atoms.positions), atoms=atoms, bonds=len(getattr(universe, "bonds", ())))


def symbols_of(universe):
    """Returns the elements of the file. Without them, returns the guess of MDAnalysis from names or types."""
    guesser = DefaultGuesser(universe)
    atoms = universe.atoms
    names = atoms.names if hasattr(atoms, "names") else atoms.types
    given = list(getattr(atoms, "elements", [""] * len(atoms)))
    return [given[i] or guesser.guess_atom_element(names[i]) for i in range(len(atoms))]


def mdanalysis_xyz(path):
    facts = mdanalysis(path, "XYZ")
    facts.last_box = None  # it assumes that all frames have as many atoms as the first
    return facts


def mdanalysis_gro(path):
    facts = mdanalysis(path, "GRO")
    facts.frames = facts.last_box = None  # it reads only the first frame
    return facts


def mdanalysis_tinker(path):
    facts = mdanalysis(path, "TXYZ")
    facts.cell = None  # it ignores the box
    return facts


def mdanalysis_dump(path):
    facts = mdanalysis(path, "LAMMPSDUMP", elements=False)
    facts.span_only = True
    return facts


def mdanalysis_data(path):
    return mdanalysis(path, "DATA", elements=False)


def of_trajectory(reader, path, **more):
    with reader(str(path), **more) as frames:
        first, cell, count = box_of(frames.ts.positions), cell_of(frames.ts.dimensions), frames.n_frames
        atoms = atoms_of(frames.ts.positions)
        frames[count - 1]
        return Facts("MDAnalysis", int(frames.n_atoms), first, None, count, cell, box_of(frames.ts.positions), atoms=atoms)


def rdkit_sdf(path):
    with open(path, "rb") as file:
        molecules = list(Chem.ForwardSDMolSupplier(file, sanitize=False, removeHs=False, strictParsing=False))
    return of_molecules(molecules)


def rdkit_mol(path):
    return of_molecules([Chem.MolFromMolFile(str(path), sanitize=False, removeHs=False, strictParsing=False)])


def rdkit_mol2(path):
    facts = of_molecules([Chem.MolFromMol2File(str(path), sanitize=False, removeHs=False, cleanupSubstructures=False)])
    facts.frames = facts.last_box = None
    return facts


def of_molecules(molecules):
    with_atoms = [m for m in molecules if m is not None and m.GetNumAtoms() and m.GetNumConformers()]
    if not with_atoms or molecules[0] is None:
        raise ValueError("no molecule")
    first, last = with_atoms[0], with_atoms[-1]
    names = [atom.GetSymbol() for atom in first.GetAtoms()]
    positions = first.GetConformer().GetPositions()
    return Facts("RDKit", first.GetNumAtoms(), box_of(positions), counted(names),
                 len(molecules) if None not in molecules else None, None, box_of(last.GetConformer().GetPositions()),
                 atoms=atoms_of(positions, names), bonds=first.GetNumBonds())


def plyfile_ply(path):
    vertex = plyfile.PlyData.read(str(path))["vertex"]
    positions = numpy.stack([numpy.asarray(vertex[axis], dtype=float) for axis in "xyz"], axis=1)
    return Facts("plyfile", len(positions), box_of(positions), atoms=atoms_of(positions))


def known(program, positions, names, cell):
    """Returns facts that need no program."""
    return Facts(program, len(names), box_of(positions), counted(names), 1, cell_of(cell), box_of(positions),
                 atoms=atoms_of(positions, names))


def head(path, size=4096):
    with open(path, "rb") as file:
        return file.read(size).decode("latin-1")


# The programs to ask, by kind of file.
READERS = {
    "pdb": (gemmi_pdb, lambda p: mdanalysis(p, "PDB"), ase_pdb),
    "mmcif": (gemmi_mmcif,),
    "chem_comp": (gemmi_chem_comp,),
    "cif": (gemmi_small, ase_cif),
    "gro": (mdanalysis_gro,),
    "pqr": (lambda p: mdanalysis(p, "PQR"),),
    "pdbqt": (gemmi_pdbqt, mdanalysis_pdbqt),
    "mol2": (rdkit_mol2, lambda p: mdanalysis(p, "MOL2")),
    "sdf": (rdkit_sdf,),
    "mol": (rdkit_mol,),
    "xyz": (ase_xyz, mdanalysis_xyz),
    "dump": (ase_dump, mdanalysis_dump),
    "data": (ase_data, mdanalysis_data),
    "ply": (plyfile_ply,),
    "tinker": (mdanalysis_tinker,),
    "dcd": (lambda p: of_trajectory(DCD.DCDReader, p),),
    "xtc": (lambda p: of_trajectory(XTC.XTCReader, p),),
    "trr": (lambda p: of_trajectory(TRR.TRRReader, p),),
    "rst7": (lambda p: of_trajectory(INPCRD.INPReader, p),),
    "netcdf": (lambda p: of_trajectory(TRJ.NCDFReader, p),),
    "gsd": (lambda p: of_trajectory(GSD.GSDReader, p),),
    "poscar": (ase_poscar,),
}


def read(kind, path):
    """Returns (facts of each program that reads the file, messages of the others)."""
    facts, errors = [], []
    for reader in READERS.get(kind, ()):
        try:
            got = reader(path)
            facts += got if isinstance(got, list) else [got]
        except Exception as error:  # any exception of a program counts as a refusal
            errors.append(f"{type(error).__name__}: {str(error).splitlines()[0][:200] if str(error) else ''}")
    return facts, errors

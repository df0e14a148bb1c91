"""Finds the kind of a file in the corpus from its name and, if the name is not enough, from its first lines."""

import bz2
import gzip
import pathlib
import re

BY_ENDING = {
    "pdb": "pdb", "pdb1": "pdb", "ent": "pdb", "gro": "gro", "pqr": "pqr", "pdbqt": "pdbqt", "mol2": "mol2",
    "sdf": "sdf", "sd": "sdf", "mol": "mol", "xyz": "xyz", "extxyz": "xyz", "lammpstrj": "dump", "dump": "dump",
    "data": "data", "data2": "data", "ply": "ply", "dcd": "dcd", "xtc": "xtc", "trr": "trr", "nc": "netcdf", "rst7": "rst7", "ncdf": "netcdf",
    "cif": "cif", "pdbx": "cif", "vasp": "poscar", "poscar": "poscar"}
UNPACKERS = {b"\x1f\x8b": gzip.decompress, b"BZh": bz2.decompress}  # by the first bytes of a file
ENDINGS = (".gz", ".bz2")


def unpacked(path):
    """Returns the unpacked bytes of the file. Returns the bytes of the file if they cannot be unpacked."""
    data = path.read_bytes()
    for start, unpack in UNPACKERS.items():
        if data.startswith(start):
            try:
                return unpack(data)
            except (OSError, EOFError):
                break
    return data


def bare_name(path):
    """Returns the name without the extension of a compressed file."""
    return pathlib.Path(path.stem if path.suffix.lower() in ENDINGS else path.name)


def kind_of(path, text):
    """Returns a kind of field.READERS, or the extension for other files. `text` is the start of the file."""
    name = bare_name(path)
    ending = name.suffix[1:].lower()
    if name.name.startswith("dump."):
        ending = "dump"
    elif name.name.startswith("data."):
        ending = "data"
    elif name.name.upper().startswith(("POSCAR", "CONTCAR", "XDATCAR")):
        ending = "poscar"
    kind = BY_ENDING.get(ending, ending)
    if kind in ("data", "dump") and text.startswith("ITEM:"):
        return "local" if "\nITEM: ENTRIES" in text[:4096] else "dump"
    return kind_of_cif(text) if kind == "cif" else kind


def kind_of_cif(text):
    if re.search(r"_atom_site\.Cartn_x", text, re.IGNORECASE):
        return "mmcif"
    if re.search(r"_chem_comp_atom\.", text, re.IGNORECASE):
        return "chem_comp"
    return "cif"

"""Writes particles as files that `parray` reads: PLY, extended XYZ, and PSF for the names of atoms."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from .particles import Particles

Columns = Sequence[tuple[str, npt.NDArray[Any]]]

RESERVED = frozenset(
    "x y z fx fy fz radius index resid type species element chain atom residue pos positions color".split()
)
"""Names of columns that have a meaning of their own for the program: it does not take them for further numbers."""
PLY_WORDS = frozenset("r g b red green blue diameter".split())
"""Names that are colours or radii in PLY, but not in extended XYZ."""
_ROWS = 1 << 16  # rows of a text file that are written together


def column_name(name: Any) -> str:
    """Returns a name as one word in lower case, without a unit in brackets: "structure_type", "speed" for "Speed [m/s]"."""
    text = str(name).strip()
    for opening, closing in ("[]", "()"):
        start = text.rfind(opening)
        if start > 0 and text.endswith(closing) and not text[start + 1 : -1].isdecimal():
            text = text[:start].strip()
    return re.sub(r'[:"\s]+', "_", text.lower()) or "value"


def write_ply(path: Path, count: int, columns: Columns) -> Path:
    """Writes binary PLY."""
    rows = np.empty(count, [(name, values.dtype.newbyteorder("<")) for name, values in columns])
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {count}"]
    for name, values in columns:
        rows[name] = values
        header.append(f"property {'uchar' if values.dtype == np.uint8 else 'double'} {name}")
    with path.open("wb") as file:
        file.write("\n".join([*header, "end_header", ""]).encode())
        file.write(rows.data.cast("B"))
    return path


def write_xyz(path: Path, particles: Particles, columns: Columns, numbers: Mapping[str, npt.NDArray[Any]]) -> Path:
    """Writes extended XYZ: elements, types, `columns` of the particles, `numbers`, cell and time."""
    texts: list[tuple[str, npt.NDArray[Any]]] = []
    for name, values in (("species", particles.elements), ("type", particles.texts.get("type"))):
        if values is not None:
            texts.append((name, values))
    properties = [f"{name}:S:1" for name, _ in texts] + ["pos:R:3"]
    if particles.radii is not None:
        properties.append("radius:R:1")
    if particles.colors is not None:
        properties.append(f"color:{'I' if particles.colors.dtype == np.uint8 else 'R'}:3")
    properties += [f"{name}:R:1" for name in numbers]
    comment = f"Properties={':'.join(properties)}"
    if particles.cell is not None:
        comment += f' Lattice="{_words(particles.cell)}" Origin="{_words(particles.origin)}"'
    if particles.time is not None:
        comment += f" Time={particles.time!r}"
    return _write_rows(path, [str(len(particles)), comment], [*texts, *columns, *numbers.items()])


def write_names(path: Path, particles: Particles) -> Path:
    """Writes PSF: segment, residue number, residue name, name of the atom, type, charge and mass.

    The program guesses elements from the masses of this file, then from the names, but not if all masses are 0. So the
    masses are 0 if the particles have elements. Otherwise they are larger than that of any element, so names decide."""
    count = len(particles)
    unknown = np.full(count, "?")
    texts = particles.texts
    name = texts.get("name", unknown)
    element = particles.elements
    kind = texts.get("type", name if element is None else element)
    numbers = particles.numbers.get("resid", np.zeros(count))
    columns = [
        ("number", np.arange(1, count + 1).astype(np.str_)),
        ("chain", np.where(texts.get("chain", unknown) == "?", "", texts.get("chain", unknown))),
        ("resid", np.nan_to_num(numbers).astype(np.int64).astype(np.str_)),
        ("resname", texts.get("resname", unknown)),
        ("name", name),
        ("type", kind),
    ]
    mass = "0" if element is not None else "1000000"
    columns += [("charge", np.full(count, "0")), ("mass", np.full(count, mass))]
    return _write_rows(path, ["PSF", "", f"{count} !NATOM"], columns)


def _words(numbers: npt.NDArray[np.float64]) -> str:
    return " ".join(map(repr, numbers.ravel().tolist()))


def _write_rows(path: Path, header: Sequence[str], columns: Columns) -> Path:
    kinds = {"U": "%s", "u": "%d"}
    line = " ".join(kinds.get(values.dtype.kind, "%.17g") for _, values in columns) + "\n"
    with path.open("w", encoding="utf-8", newline="\n") as file:
        file.write("\n".join([*header, ""]))
        for first in range(0, len(columns[0][1]), _ROWS):
            file.write("".join(line % row for row in _rows(columns, first)))
    return path


def _rows(columns: Columns, first: int) -> Iterator[tuple[Any, ...]]:
    return zip(*(values[first : first + _ROWS].tolist() for _, values in columns))

"""Particles as columns, from arrays or from the objects of other packages, and as files for `parray`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any, BinaryIO, Optional, Union

import numpy as np
import numpy.typing as npt

from .errors import InputError
from .srgb import srgb_to_linear

_LARGEST = 1e15  # of any length, the program's
_SMALLEST = 1e-15


class Particles:
    """Spheres by columns; what is not given, the program decides as for a file of particles that lacks it.

    positions  (N, 3), any unit
    radii      (N,), or one number for all; the unit of positions
    colors     (N, 3) or (3,) for all: linear RGB from 0 to 1, or, of type uint8, sRGB (see `srgb_to_linear`)
    elements   (N,): symbols or atomic numbers; what is none gets the colour and radius of an unknown one
    """

    def __init__(
        self,
        positions: npt.ArrayLike,
        radii: Optional[npt.ArrayLike] = None,
        colors: Optional[npt.ArrayLike] = None,
        elements: Union[npt.ArrayLike, Sequence[str], None] = None,
    ) -> None:
        self.positions = _numbers("positions", positions, np.float64)
        if self.positions.ndim != 2 or self.positions.shape[1:] != (3,) or len(self.positions) == 0:
            raise InputError(f"positions: an array of shape {self.positions.shape}: give (N, 3), N > 0")
        _check("positions", np.abs(self.positions) <= _LARGEST, self.positions, f"finite and at most {_LARGEST:g}")
        self.radii = None if radii is None else self._radii(radii)
        self.colors = None if colors is None else self._colors(colors)
        self.elements = None if elements is None else self._elements(elements)

    def __len__(self) -> int:
        return len(self.positions)

    def _radii(self, radii: npt.ArrayLike) -> npt.NDArray[np.float64]:
        values = self._one_each("radii", _numbers("radii", radii, np.float64), ())
        _check("radii", (values >= _SMALLEST) & (values <= _LARGEST), values, f"from {_SMALLEST:g} to {_LARGEST:g}")
        return values

    def _colors(self, colors: npt.ArrayLike) -> npt.NDArray[Any]:
        given = np.asarray(colors)
        values = given if given.dtype == np.uint8 else _numbers("colors", colors, np.float64)
        values = self._one_each("colors", values, (3,))
        _check("colors", (values >= 0) & ((values <= 1) | (given.dtype == np.uint8)), values,
               "linear RGB from 0 to 1, or of type uint8")  # fmt: skip
        return values

    def _elements(self, elements: Union[npt.ArrayLike, Sequence[str]]) -> npt.NDArray[np.str_]:
        texts = self._one_each("elements", np.asarray(elements).astype(np.str_), ())
        # A blank name would be none of the line's words.
        names, which = np.unique(texts, return_inverse=True)
        clean = np.array(["_".join(name.split()) or "?" for name in names.tolist()])
        return clean[which]

    def _one_each(self, name: str, values: npt.NDArray[Any], tail: tuple[int, ...]) -> npt.NDArray[Any]:
        wanted = (len(self), *tail)
        if values.shape not in (wanted, tail):
            raise InputError(f"{name}: an array of shape {values.shape}: give {wanted}, or {tail or 'one value'} for all")
        return np.broadcast_to(values, wanted)

    def write(self, folder: Path) -> Path:
        """Writes them as a file that loses nothing: binary PLY, or, with elements, extended XYZ."""
        path = folder / ("particles.ply" if self.elements is None else "particles.xyz")
        with path.open("wb") as file:
            if self.elements is None:
                self._write_ply(file)
            else:
                self._write_xyz(file, self.elements)
        return path

    def _columns(self) -> list[tuple[str, npt.NDArray[Any]]]:
        columns = list(zip("xyz", self.positions.T))
        if self.radii is not None:
            columns.append(("radius", self.radii))
        if self.colors is not None:
            columns += zip(("red", "green", "blue"), self.colors.T)
        return columns

    def _write_ply(self, file: BinaryIO) -> None:
        columns = self._columns()
        rows = np.empty(len(self), [(name, values.dtype.newbyteorder("<")) for name, values in columns])
        header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(self)}"]
        for name, values in columns:
            rows[name] = values
            header.append(f"property {'uchar' if values.dtype == np.uint8 else 'double'} {name}")
        file.write("\n".join([*header, "end_header", ""]).encode())
        file.write(rows.data.cast("B"))

    def _write_xyz(self, file: BinaryIO, elements: npt.NDArray[np.str_]) -> None:
        columns = self._columns()
        formats = ["%s"] + ["%d" if values.dtype == np.uint8 else "%.17g" for _, values in columns]
        properties = "species:S:1:pos:R:3" + (":radius:R:1" if self.radii is not None else "")
        if self.colors is not None:
            properties += f":color:{'I' if self.colors.dtype == np.uint8 else 'R'}:3"
        file.write(f"{len(self)}\nProperties={properties}\n".encode())
        line = " ".join(formats) + "\n"
        at_once = 1 << 16
        for first in range(0, len(self), at_once):
            some = [elements[first : first + at_once].tolist()]
            some += [values[first : first + at_once].tolist() for _, values in columns]
            file.write("".join([line % row for row in zip(*some)]).encode())


def _numbers(name: str, values: Any, kind: Any) -> npt.NDArray[Any]:
    try:
        return np.asarray(values, kind)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: not an array of numbers: {error}") from error


def _check(name: str, good: npt.NDArray[np.bool_], values: npt.NDArray[Any], wanted: str) -> None:
    if good.all():
        return
    place = tuple(int(i) for i in np.argwhere(~good)[0])
    raise InputError(f"{name}[{', '.join(map(str, place))}] is {values[place]}: give what is {wanted}")


def particles_of(source: Any, frame: Union[int, str, None] = None) -> Optional[Particles]:
    """The particles of an array of positions, ASE Atoms, an MDAnalysis Universe or AtomGroup, an OVITO Pipeline or
    DataCollection; None: it is none of them. `frame` of those that have several."""
    if isinstance(source, Particles):
        found = source
    elif isinstance(source, (str, os.PathLike, dict)):
        return None
    elif isinstance(frame, str):
        raise InputError(f"frame: {frame!r} is for files: give a number")
    elif hasattr(source, "get_atomic_numbers") and hasattr(source, "get_positions"):  # ASE
        found = Particles(source.get_positions(), elements=source.get_atomic_numbers())
    elif hasattr(source, "trajectory") and hasattr(source, "atoms"):  # MDAnalysis, a universe
        return _of_atom_group(source.atoms, frame)
    elif hasattr(source, "atoms") and hasattr(source, "universe"):
        return _of_atom_group(source.atoms, frame)
    elif hasattr(source, "compute") and hasattr(source, "modifiers"):  # OVITO, a pipeline
        return _of_ovito(source.compute(frame) if frame is not None else source.compute())
    elif hasattr(source, "particles") and hasattr(source, "attributes"):
        found = _of_ovito(source)
    else:
        found = Particles(source)
    if frame is not None:
        raise InputError(f"frame: {type(source).__name__} has one frame only: leave it out")
    return found


def _of_atom_group(atoms: Any, frame: Optional[int]) -> Particles:
    """Of MDAnalysis. Without elements the types, which it guesses from names where a file has none."""
    if frame is not None:
        atoms.universe.trajectory[frame]
    names = getattr(atoms, "elements", None)
    if names is None:
        names = getattr(atoms, "types", None)
    return Particles(atoms.positions, elements=names)


def _of_ovito(data: Any) -> Particles:
    """Of OVITO: colours and radii as it shows them; its colours are sRGB."""
    particles = data.particles
    if particles is None or particles.count == 0:
        raise InputError("the OVITO data has no particles")
    radii = np.zeros(particles.count)
    colors: Optional[npt.NDArray[Any]] = None
    types = particles.particle_types
    if types is not None:
        ids = np.asarray(types)
        colors = np.ones((particles.count, 3))
        for kind in types.types:
            colors[ids == kind.id] = kind.color
            radii[ids == kind.id] = kind.radius
    if particles.colors is not None:
        colors = np.asarray(particles.colors)
    if "Radius" in particles:
        given = np.asarray(particles["Radius"])
        radii = np.where(given > 0, given, radii)
    radii = np.where(radii > 0, radii, particles.vis.radius) * particles.vis.scaling
    linear = None if colors is None else srgb_to_linear(np.clip(colors, 0, 1))
    return Particles(np.asarray(particles.positions), radii, linear)

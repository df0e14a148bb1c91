"""Particles in columns, made from arrays or from objects of other packages, and written as files for `parray`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any, BinaryIO, Optional, Union

import numpy as np
import numpy.typing as npt

from .errors import InputError
from .srgb import srgb_to_linear

_LARGEST = 1e15  # limits of lengths, those of the program
_SMALLEST = 1e-15


class Particles:
    """Spheres in columns. For missing columns, the program chooses values as for a particle file without them.

    positions  (N, 3), any unit
    radii      (N,), or one number for all; the unit of positions
    colors     (N, 3) or (3,) for all: linear RGB from 0 to 1, or, of type uint8, sRGB (see `srgb_to_linear`)
    elements   (N,): symbols or atomic numbers; other texts get the colour and radius of an unknown element
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
            raise InputError(f"positions: the array has shape {self.positions.shape}: give (N, 3), N > 0")
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
        # An empty name would not be a word of the line.
        names, which = np.unique(texts, return_inverse=True)
        clean = np.array(["_".join(name.split()) or "?" for name in names.tolist()])
        return clean[which]

    def _one_each(self, name: str, values: npt.NDArray[Any], tail: tuple[int, ...]) -> npt.NDArray[Any]:
        wanted = (len(self), *tail)
        if values.shape not in (wanted, tail):
            raise InputError(f"{name}: the array has shape {values.shape}: give {wanted}, or {tail or 'one value'} for all")
        return np.broadcast_to(values, wanted)

    def write(self, folder: Path) -> Path:
        """Writes the particles without loss: as binary PLY or, with elements, as extended XYZ. Returns the file."""
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
        raise InputError(f"{name}: the values are not an array of numbers: {error}") from error


def _check(name: str, good: npt.NDArray[np.bool_], values: npt.NDArray[Any], wanted: str) -> None:
    if good.all():
        return
    place = tuple(int(i) for i in np.argwhere(~good)[0])
    raise InputError(f"{name}[{', '.join(map(str, place))}] is {values[place]}: give values {wanted}")


def particles_of(source: Any, frame: Union[int, str, None] = None) -> Optional[Particles]:
    """Returns the particles of an array of positions, ASE Atoms, an MDAnalysis Universe or AtomGroup, or an OVITO
    Pipeline or DataCollection. Returns None for paths and scenes. `frame` chooses one of several frames."""
    if isinstance(source, Particles):
        found = source
    elif isinstance(source, (str, os.PathLike, dict)):
        return None
    elif isinstance(frame, str):
        raise InputError(f"frame: {frame!r} works only for files: give a number")
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
        raise InputError(f"frame: {type(source).__name__} has only one frame: leave frame out")
    return found


def _of_atom_group(atoms: Any, frame: Optional[int]) -> Particles:
    """Returns the particles of MDAnalysis. Without elements, uses the types, which MDAnalysis may guess from names."""
    if frame is not None:
        atoms.universe.trajectory[frame]
    names = getattr(atoms, "elements", None)
    if names is None:
        names = getattr(atoms, "types", None)
    return Particles(atoms.positions, elements=names)


def _of_ovito(data: Any) -> Particles:
    """Returns the particles of OVITO with the colours and radii of its display. Its colours are sRGB."""
    particles = data.particles
    if particles is None or particles.count == 0:
        raise InputError("the OVITO data have no particles: check the pipeline")
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

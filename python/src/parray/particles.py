"""Particles in columns, checked, and written as files for `parray`."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from .colors import linear_of_names
from .errors import InputError
from .particle_files import PLY_WORDS, RESERVED, column_name, write_names, write_ply, write_xyz

_LARGEST = 1e15  # limits of lengths, those of the program
_SMALLEST = 1e-15
_NAMES = ("name", "resname", "chain")  # texts that identify atoms
_SYMBOLS = (
    "X H He Li Be B C N O F Ne Na Mg Al Si P S Cl Ar K Ca Sc Ti V Cr Mn Fe Co Ni Cu Zn Ga Ge As Se Br Kr Rb Sr Y Zr Nb Mo "
    "Tc Ru Rh Pd Ag Cd In Sn Sb Te I Xe Cs Ba La Ce Pr Nd Pm Sm Eu Gd Tb Dy Ho Er Tm Yb Lu Hf Ta W Re Os Ir Pt Au Hg Tl Pb "
    "Bi Po At Rn Fr Ra Ac Th Pa U Np Pu Am Cm Bk Cf Es Fm Md No Lr Rf Db Sg Bh Hs Mt Ds Rg Cn Nh Fl Mc Lv Ts Og"
).split()
SYMBOLS = frozenset(_SYMBOLS[1:])


class Particles:
    """Spheres in columns. For missing columns, the program chooses values as for a particle file without them.

    positions  (N, 3), any unit
    radii      (N,), or one number for all; the unit of positions
    colors     (N, 3) or (3,) for all: linear RGB from 0 to 1, or, of type uint8, sRGB (see `srgb_to_linear`); or names of
               colours
    elements   (N,): symbols or atomic numbers; other texts get the colour and radius of an unknown element
    numbers    further numbers by name, each (N,) or (N, K); "resid" is the number of the residue. A vector "f" of three
               becomes "f_x", "f_y", "f_z" and its length "f"; other vectors become "f_0", "f_1" and so on
    texts      further texts by name, each (N,): "type", "name" (of the atom), "resname", "chain", or any category
    cell       (3, 3): the edges a, b and c of the box; `origin`: its corner
    time       time of the frame
    unit       unit of lengths in labels; without it, angstrom for particles with elements
    """

    def __init__(
        self,
        positions: npt.ArrayLike,
        radii: Optional[npt.ArrayLike] = None,
        colors: Optional[npt.ArrayLike] = None,
        elements: Union[npt.ArrayLike, Sequence[str], None] = None,
        *,
        numbers: Optional[Mapping[str, npt.ArrayLike]] = None,
        texts: Optional[Mapping[str, npt.ArrayLike]] = None,
        cell: Optional[npt.ArrayLike] = None,
        origin: npt.ArrayLike = (0, 0, 0),
        time: Optional[float] = None,
        unit: Optional[str] = None,
    ) -> None:
        self.positions = _numbers("positions", positions, np.float64)
        if self.positions.ndim != 2 or self.positions.shape[1:] != (3,) or len(self.positions) == 0:
            raise InputError(f"positions: the array has shape {self.positions.shape}: give (N, 3), N > 0")
        _check("positions", np.abs(self.positions) <= _LARGEST, self.positions, f"finite and at most {_LARGEST:g}")
        self.radii = None if radii is None else self._radii(radii)
        self.colors = None if colors is None else self._colors(colors)
        self.elements = None if elements is None else self._elements(elements)
        self.numbers: dict[str, npt.NDArray[np.float64]] = {}
        self.texts: dict[str, npt.NDArray[np.str_]] = {}
        self.cell = None if cell is None else _cell(cell)
        self.origin = _numbers("origin", origin, np.float64)
        self.time = time
        self.unit = unit
        self._decide_unit()
        for columns in (numbers or {}, texts or {}):
            for name, values in columns.items():
                self.add(name, values)

    def __len__(self) -> int:
        return len(self.positions)

    def add(self, name: str, values: npt.ArrayLike) -> None:
        """Adds a column. Texts and categories go to `texts`, numbers and truth values to `numbers`. Ignores names that the
        program has for something else, such as "x"."""
        name = column_name(name)
        array = np.asarray(values)
        if array.dtype.kind not in "biufOSTU":
            raise InputError(f"{name}: values of type {array.dtype} are not numbers or texts: give numbers")
        if array.dtype.kind in "OSTU":
            array = _decided(array)
        if array.dtype.kind in "SU":
            self.texts[name] = self._texts(name, array)
        elif name == "resid" or name not in RESERVED:
            array = _numbers(name, array, np.float64)
            if len(self) not in array.shape[:1] or array.ndim not in (1, 2):
                wanted = f"give one value for each of {len(self)} particles"
                raise InputError(f"{name}: the array has shape {array.shape}: {wanted}")
            self._add_numbers(name, array)

    def _add_numbers(self, name: str, array: npt.NDArray[np.float64]) -> None:
        if array.ndim == 1:
            self.numbers[name] = array
            return
        three = array.shape[1] == 3
        if three:
            self.numbers[name] = np.sqrt((array**2).sum(axis=1))
        for place, values in enumerate(array.T):
            self.numbers[f"{name}_{'xyz'[place] if three else place}"] = values

    def changed(self, **columns: Any) -> Particles:
        """Returns a copy with other radii, colors or elements."""
        other = copy.copy(self)
        other.numbers, other.texts = dict(self.numbers), dict(self.texts)
        for name, check in (("radii", self._radii), ("colors", self._colors), ("elements", self._elements)):
            if columns.get(name) is not None:
                setattr(other, name, check(columns[name]))
        other._decide_unit()
        return other

    def _decide_unit(self) -> None:
        """Without a unit, particles with elements are in angstrom."""
        self.unit = self.unit or (None if self.elements is None else "angstrom")

    def with_more(self, others: Sequence[tuple[Particles, npt.NDArray[np.intp]]]) -> Particles:
        """Returns a copy that also contains the chosen particles of others. These need the same columns."""
        more = self.changed()
        parts = [(self, np.arange(len(self))), *others]
        for name in ("positions", "radii", "colors", "elements"):
            if getattr(self, name) is not None:
                setattr(more, name, np.concatenate([_column(p, name, getattr(p, name))[i] for p, i in parts]))
        for kind in ("numbers", "texts"):
            for name in getattr(self, kind):
                columns = [_column(p, name, getattr(p, kind).get(name))[i] for p, i in parts]
                getattr(more, kind)[name] = np.concatenate(columns)
        return more

    def _radii(self, radii: npt.ArrayLike) -> npt.NDArray[np.float64]:
        values = self._one_each("radii", _numbers("radii", radii, np.float64), ())
        _check("radii", (values >= _SMALLEST) & (values <= _LARGEST), values, f"from {_SMALLEST:g} to {_LARGEST:g}")
        return values

    def _colors(self, colors: npt.ArrayLike) -> npt.NDArray[Any]:
        given = np.asarray(colors)
        if given.dtype.kind in "OU" and given.size and isinstance(given.flat[0], str):
            given = linear_of_names(given)
        values = given if given.dtype == np.uint8 else _numbers("colors", given, np.float64)
        values = self._one_each("colors", values, (3,))
        _check("colors", (values >= 0) & ((values <= 1) | (given.dtype == np.uint8)), values,
               "linear RGB from 0 to 1, or of type uint8")  # fmt: skip
        return values

    def _elements(self, elements: Union[npt.ArrayLike, Sequence[str]]) -> npt.NDArray[np.str_]:
        return self._texts("elements", np.asarray(elements), _symbol)

    def _texts(self, name: str, values: npt.NDArray[Any], change: Any = str) -> npt.NDArray[np.str_]:
        texts = self._one_each(name, values.astype(np.str_), ())
        # An empty name would not be a word of the line.
        names, which = np.unique(texts, return_inverse=True)
        clean = np.array(["_".join(change(name).split()) or "?" for name in names.tolist()])
        return clean[which.reshape(texts.shape)]

    def _one_each(self, name: str, values: npt.NDArray[Any], tail: tuple[int, ...]) -> npt.NDArray[Any]:
        wanted = (len(self), *tail)
        if values.shape not in (wanted, tail):
            hint = "; or give the numbers as color_by" if name == "colors" and values.shape == (len(self),) else ""
            raise InputError(
                f"{name}: the array has shape {values.shape}: give {wanted}, or {tail or 'one value'} for all{hint}"
            )
        return np.broadcast_to(values, wanted)

    @property
    def has_names(self) -> bool:
        """Whether the particles have names that write_names() writes."""
        return "resid" in self.numbers or any(name in self.texts for name in _NAMES)

    def write(self, folder: Path, mentioned: Optional[str] = None) -> Path:
        """Writes the particles without loss: as binary PLY or, with elements, types or a cell, as extended XYZ. Returns the
        file. Residues and names of atoms are in the file of write_names(). Of many numbers, writes only the columns whose
        names occur in the text `mentioned`."""
        numbers = {name: values for name, values in self.numbers.items() if name != "resid"}
        if mentioned is not None and len(numbers) * len(self) > 1_000_000:
            numbers = {name: values for name, values in numbers.items() if name in mentioned.lower()}
        plain = self.elements is None and "type" not in self.texts and self.cell is None and self.time is None
        columns = self._columns()
        if plain and PLY_WORDS.isdisjoint(numbers):
            return write_ply(folder / "particles.ply", len(self), columns + list(numbers.items()))
        return write_xyz(folder / "particles.xyz", self, columns, numbers)

    def unit_in(self, file: Path) -> Optional[str]:
        """Returns the unit for labels of a file of write(). Returns None if the file needs none. The program takes
        lengths of XYZ for angstrom, so a blank stands for a unit that is not known."""
        return self.unit or (" " if file.suffix == ".xyz" else None)

    def write_names(self, folder: Path) -> Optional[Path]:
        """Writes residues, chains and names of atoms as PSF, which the program reads as a topology. Returns the file, or
        None if the particles have no names."""
        return write_names(folder / "names.psf", self) if self.has_names else None

    def _columns(self) -> list[tuple[str, npt.NDArray[Any]]]:
        columns = list(zip("xyz", self.positions.T))
        if self.radii is not None:
            columns.append(("radius", self.radii))
        if self.colors is not None:
            columns += zip(("red", "green", "blue"), self.colors.T)
        return columns


def _symbol(element: str) -> str:
    """Returns the symbol for an atomic number. Returns other texts unchanged. The program would read numbers as types."""
    return _SYMBOLS[int(element)] if element.isdecimal() and int(element) < len(_SYMBOLS) else element


def _decided(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Returns an array of objects or texts as numbers if all of them are numbers, otherwise as texts."""
    if array.dtype.kind == "O":
        try:
            if not any(isinstance(value, (str, bytes)) for value in array.flat):
                return array.astype(np.float64)
        except (TypeError, ValueError):
            pass
    if array.dtype.kind == "S" or any(isinstance(value, bytes) for value in array.flat[:1]):
        return np.array([value.decode("utf-8", "replace") for value in array.tolist()])
    texts: npt.NDArray[Any] = np.array([str(value) for value in array.ravel().tolist()]).reshape(array.shape)
    return texts


def _column(particles: Particles, name: str, values: Any) -> npt.NDArray[Any]:
    if values is None:
        raise InputError(f"frames: a frame of {len(particles)} particles has no {name}, unlike the first frame")
    return np.asarray(values)


def _cell(cell: npt.ArrayLike) -> Optional[npt.NDArray[np.float64]]:
    """Returns the edges. Returns None for a cell that is flat or not finite."""
    edges = _numbers("cell", cell, np.float64)
    if edges.shape != (3, 3):
        raise InputError(f"cell: the array has shape {edges.shape}: give the edges a, b and c as (3, 3)")
    return edges if np.isfinite(edges).all() and np.linalg.det(edges) != 0 else None


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

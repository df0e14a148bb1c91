"""Reads files that only other packages read: one function for each package, in the table at the end."""

from __future__ import annotations

import importlib.util
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple, Optional, Union

import numpy as np

from .errors import InputError, ProgramNotFound

Frame = Union[int, str, None]


class Read(NamedTuple):
    """What a package has read: an object that particles_of() takes, and the frame of it that is wanted."""

    content: Any
    frame: Frame = None


class Way(NamedTuple):
    """A function that reads a file and the packages that it needs, by the names of their modules."""

    modules: tuple[str, ...]
    read: Callable[[Path, Frame], Read]


class Kind(NamedTuple):
    """A kind of files: its name, first bytes, extensions, beginnings of file names, and the ways to read it."""

    name: str
    magic: tuple[bytes, ...]
    extensions: tuple[str, ...]
    names: tuple[str, ...]
    ways: tuple[Way, ...]
    needs_topology: bool = False
    """Whether the file has only positions."""

    def has(self, path: Path, start: bytes) -> bool:
        named = path.suffix.lower() in self.extensions or (self.names and path.name.upper().startswith(self.names))
        return start.startswith(self.magic) if self.magic and not named else bool(named)


def read_other_file(path: Path, frame: Frame = None, topology: Optional[Path] = None) -> Optional[Read]:
    """Returns what a package reads from a file. `topology` is the file of names for a trajectory of positions. Returns None
    for files that `parray` reads itself. Raises InputError if no package for the file is installed, or if it cannot read
    the file."""
    kind = kind_of(path)
    if kind is None or _program_reads(path):
        return None
    if kind.needs_topology and topology is None:
        raise InputError(f"{path}: {kind.name} has only positions: give the file of the atoms' names as topology")
    for way in kind.ways:
        if all(importlib.util.find_spec(module) is not None for module in way.modules):
            try:
                return _with_topology(path, frame, topology) if kind.needs_topology else way.read(path, frame)
            except InputError:
                raise
            except Exception as error:  # of any package
                said = (str(error).strip() or type(error).__name__).splitlines()[0]
                raise InputError(f"{path}: {way.modules[0]} cannot read this file as {kind.name}: {said}") from error
    packages = " or ".join(" ".join(way.modules) for way in kind.ways)
    raise InputError(f"{path}: Python reads {kind.name} with {packages}, which is not installed: pip install {packages}")


def takes_topology(path: Path) -> bool:
    """Returns whether the package that reads the file also reads its topology."""
    kind = kind_of(path)
    return kind is not None and kind.needs_topology


def kind_of(path: Path) -> Optional[Kind]:
    """Returns the kind of a file. Returns None for files that no package reads, and for files that do not exist."""
    try:
        with path.open("rb") as file:
            start = file.read(64)
    except OSError:
        return None
    return next((kind for kind in _KINDS if kind.has(path, start)), None)


def _program_reads(path: Path) -> bool:
    from .program import find_program

    try:
        command = [find_program(), "validate", str(path)]
    except ProgramNotFound:
        return False
    return subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, check=False).returncode == 0


def _number_of(frame: Frame) -> int:
    return -1 if frame == "last" else int(frame or 0)


def _chosen(frame: Frame, count: int, path: Path) -> int:
    number = _number_of(frame)
    if not -1 <= number < count:
        raise InputError(f"{path}: the file has no frame {number}: it has {count}, from 0")
    return number % count


def _by_ase(path: Path, frame: Frame) -> Read:
    import ase.io

    try:
        return Read(ase.io.read(path, index=_number_of(frame)))
    except (StopIteration, IndexError) as error:
        raise InputError(f"{path}: the file has no frame {frame}") from error


def _by_mdanalysis(path: Path, frame: Frame) -> Read:
    return _with_topology(path, frame, None)


def _with_topology(path: Path, frame: Frame, topology: Optional[Path]) -> Read:
    import MDAnalysis

    universe = MDAnalysis.Universe(*(str(file) for file in (topology, path) if file is not None))
    return Read(universe, _chosen(frame, len(universe.trajectory), path))


def _by_ovito(path: Path, frame: Frame) -> Read:
    from ovito.io import import_file

    pipeline = import_file(str(path))
    return Read(pipeline, _chosen(frame, pipeline.num_frames, path))


def _by_gsd(path: Path, frame: Frame) -> Read:
    import gsd.hoomd

    from .particles import Particles

    with gsd.hoomd.open(str(path)) as file:
        snapshot = file[_chosen(frame, len(file), path)]
    at = snapshot.particles
    width, depth, height, xy, xz, yz = map(float, snapshot.configuration.box)
    cell = np.array([[width, 0, 0], [xy * depth, depth, 0], [xz * height, yz * height, height]])
    found = Particles(at.position, at.diameter / 2, cell=cell, origin=-cell.sum(axis=0) / 2,
                      texts={"type": np.array(at.types)[at.typeid]})  # fmt: skip
    for name in ("mass", "charge", "velocity", "orientation", "body"):
        found.add(name, getattr(at, name))
    return Read(found)


def _by_h5py(path: Path, frame: Frame) -> Read:
    import h5py

    with h5py.File(path) as file:
        kinds = sorted(name for name in file if name.startswith("PartType") and "Coordinates" in file[name])
        if kinds:
            return Read(_snapshot(file, kinds), frame)
        for group in dict(file.get("particles", {})).values():
            if "position" in group:
                return Read(_h5md(group, frame, path))
    raise InputError(f"{path}: the HDF5 file has neither PartType*/Coordinates (Gadget) nor particles/*/position (H5MD)")


_KINDS_OF_GADGET = {"PartType0": "gas", "PartType1": "dark_matter", "PartType4": "stars", "PartType5": "black_holes"}


def _snapshot(file: Any, kinds: list[str]) -> Any:
    """Returns the particles of a snapshot of Gadget, Arepo or SWIFT. Numbers that a kind lacks are NaN."""
    from .particles import Particles

    counts = [len(file[kind]["Coordinates"]) for kind in kinds]
    names = np.repeat([_KINDS_OF_GADGET.get(kind, kind) for kind in kinds], counts)
    box = np.ravel(file["Header"].attrs.get("BoxSize", 0)) if "Header" in file else np.zeros(1)
    found = Particles(np.concatenate([file[kind]["Coordinates"][:] for kind in kinds]), texts={"type": names},
                      cell=np.diag(np.broadcast_to(box, 3)))  # fmt: skip
    columns = {name: data.shape[1:] for kind in kinds for name, data in file[kind].items() if hasattr(data, "shape")}
    for name, tail in columns.items():
        if name == "Coordinates" or len(tail) > 1:
            continue
        parts = [file[kind][name][:] if name in file[kind] else np.full((count, *tail), np.nan)
                 for kind, count in zip(kinds, counts)]  # fmt: skip
        if all(part.shape[1:] == tail for part in parts):
            found.add(name, np.concatenate(parts))
    return found


def _h5md(group: Any, frame: Frame, path: Path) -> Any:
    """Returns the particles of a frame. Format: https://www.nongnu.org/h5md/h5md.html"""
    from .particles import Particles

    def value(name: str) -> Any:
        """Returns an element of the group at the frame, or one that does not depend on time."""
        element = group[name]
        return element["value"][number] if hasattr(element, "keys") else element[:]

    moving = hasattr(group["position"], "keys")
    number = _chosen(frame, len(group["position"]["value"]) if moving else 1, path)
    edges: Any = None
    if "box" in group and "edges" in group["box"]:
        edges = value("box/edges")
        edges = np.diag(edges) if np.ndim(edges) == 1 else edges
    found = Particles(value("position"), cell=edges if np.shape(edges) == (3, 3) else None)
    for name in group:
        if name not in ("position", "box") and np.shape(value(name))[:1] == (len(found),):
            values = value(name)
            found.add("type" if name == "species" else name, values.astype(str) if name == "species" else values)
    return found


def _by_astropy(path: Path, frame: Frame) -> Read:
    import warnings

    from astropy.table import Table

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of units and versions
        kind = "fits" if path.open("rb").read(6) == b"SIMPLE" else "votable"
        return Read(Table.read(path, format=kind), frame)


def _by_laspy(path: Path, frame: Frame) -> Read:
    import laspy

    from .tables import particles_of_columns

    points = laspy.read(path)
    columns = {"x": np.asarray(points.x), "y": np.asarray(points.y), "z": np.asarray(points.z)}
    for name in points.point_format.dimension_names:
        columns.setdefault(name.lower(), np.asarray(points[name]))
    return Read(particles_of_columns({name: values for name, values in columns.items() if values.ndim == 1}), frame)


def _by_pyarrow(path: Path, frame: Frame) -> Read:
    import pyarrow.feather
    import pyarrow.parquet

    parquet = path.open("rb").read(4) == b"PAR1"
    read = pyarrow.parquet.read_table if parquet else pyarrow.feather.read_table
    return Read(read(str(path)), frame)


def _by_pandas(path: Path, frame: Frame) -> Read:
    import pandas

    return Read(pandas.read_excel(path), frame)


def _by_numpy(path: Path, frame: Frame) -> Read:
    """Reads an array, or arrays by name: positions, or x, y and z, and further columns."""
    from .particle_files import column_name
    from .tables import particles_of_columns

    loaded = np.load(path, allow_pickle=False)
    if isinstance(loaded, np.ndarray):
        return Read(loaded, frame)
    with loaded:
        columns = {column_name(name): loaded[name] for name in loaded.files}
    if len(columns) == 1:
        return Read(next(iter(columns.values())), frame)
    return Read(particles_of_columns(columns), frame)


_ASE = Way(("ase",), _by_ase)
_MDANALYSIS = Way(("MDAnalysis",), _by_mdanalysis)
_OVITO = Way(("ovito",), _by_ovito)
_KINDS = (
    Kind("HDF5", (b"\x89HDF\r\n\x1a\n",), (), (), (Way(("h5py",), _by_h5py),)),
    Kind("FITS", (b"SIMPLE  =",), (), (), (Way(("astropy",), _by_astropy),)),
    Kind("VOTable", (), (".vot", ".votable"), (), (Way(("astropy",), _by_astropy),)),
    Kind("LAZ", (), (".laz",), (), (Way(("laspy", "lazrs"), _by_laspy),)),
    Kind("LAS", (b"LASF",), (), (), (Way(("laspy",), _by_laspy),)),
    Kind("Parquet", (b"PAR1",), (), (), (Way(("pyarrow",), _by_pyarrow),)),
    Kind("Feather", (b"ARROW1", b"FEA1"), (), (), (Way(("pyarrow",), _by_pyarrow),)),
    Kind("Excel", (), (".xlsx",), (), (Way(("pandas", "openpyxl"), _by_pandas),)),
    Kind("numpy arrays", (b"\x93NUMPY",), (".npz",), (), (Way(("numpy",), _by_numpy),)),
    Kind("GSD", (), (".gsd",), (), (Way(("gsd",), _by_gsd), _OVITO)),
    Kind("VASP files", (), (".vasp", ".poscar"), ("POSCAR", "CONTCAR", "XDATCAR", "OUTCAR"), (_ASE,)),
    Kind("an ASE trajectory", (), (".traj",), (), (_ASE,)),
    Kind("an ASE database", (), (".db",), (), (_ASE,)),
    Kind("XSF", (), (".xsf", ".axsf"), (), (_ASE, _OVITO)),
    Kind("Gaussian cubes", (), (".cube", ".cub"), (), (_ASE,)),
    Kind("crystal files", (), (".res", ".shelx", ".cell", ".cssr", ".gen", ".cfg", ".xtl", ".castep"), (), (_ASE,)),
    Kind("CHARMM coordinates", (), (".crd", ".cor"), (), (_MDANALYSIS,)),
    Kind("an AMBER trajectory", (), (".mdcrd", ".crdbox"), (), (_MDANALYSIS,), True),
    Kind("NAMD coordinates", (), (".coor", ".namdbin"), (), (_MDANALYSIS,), True),
    Kind("a TRZ trajectory", (), (".trz",), (), (_MDANALYSIS,), True),
    Kind("IMD", (), (".imd",), (), (_OVITO,)),
)

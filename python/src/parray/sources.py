"""Particles of the objects of other packages, with all that these objects hold. One function for each package."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from .errors import InputError
from .other_files import read_other_file
from .particles import SYMBOLS, Particles
from .srgb import srgb_to_linear
from .tables import is_table, particles_of_table

Frame = Union[int, str, None]


def particles_of(source: Any, frame: Frame = None, topology: Any = None) -> Optional[Particles]:
    """Returns the particles of an array of positions, a table, ASE Atoms, an MDAnalysis Universe or AtomGroup, an OVITO
    Pipeline or DataCollection, or a file that only another package reads. Returns None for other files and for scenes.
    `frame` chooses one of several frames; `topology` is a file of names for a file of positions."""
    if isinstance(source, dict):
        return None
    if isinstance(source, (str, os.PathLike)):
        read = read_other_file(Path(source), frame, None if topology is None else Path(topology))
        return None if read is None else particles_of(read.content, read.frame)
    for is_it, find in _WITH_FRAMES:
        if is_it(source):
            return find(source, None if frame is None else _number_of(frame, count_of_frames(source) or 0))
    if frame is not None:
        raise InputError(f"frame: {type(source).__name__} has only one frame: leave frame out")
    for is_it, make in _OTHERS:
        if is_it(source):
            return make(source)
    return Particles(source)


def _number_of(frame: Union[int, str], count: int) -> int:
    """Returns the number of a frame from 0. "last" and negative numbers count from the end."""
    number = -1 if frame == "last" else frame
    if not isinstance(number, (int, np.integer)) or not -count <= number < count:
        raise InputError(f"frame: there is no frame {frame}: give a number from 0 to {count - 1}, or 'last'")
    return int(number) % count


def count_of_frames(source: Any) -> Optional[int]:
    """Returns the number of frames of an MDAnalysis Universe or AtomGroup, or an OVITO Pipeline. None: not known."""
    if _is_atom_group(source):
        return len(source.universe.trajectory)
    if _is_pipeline(source):
        return int(source.num_frames if hasattr(source, "num_frames") else source.source.num_frames)
    return None


def is_particle_object(source: Any) -> bool:
    """Returns whether the source is a path, a scene or an object with particles, not an array of numbers."""
    if isinstance(source, (str, os.PathLike, dict)):
        return True
    return any(is_it(source) for is_it, _ in (*_WITH_FRAMES, *_OTHERS))


def _is_ase(source: Any) -> bool:
    return hasattr(source, "get_atomic_numbers") and hasattr(source, "get_positions")


# Names of ASE, some of them of its reader of PDB files, and the names that they have in files.
_ASE_NAMES = {
    "residuenames": "resname",
    "residuenumbers": "resid",
    "atomtypes": "name",
    "chainids": "chain",
    "bfactor": "b_factor",
}


def _of_ase(atoms: Any) -> Particles:
    columns = {**atoms.arrays}
    if atoms.calc is not None:
        columns.update(getattr(atoms.calc, "results", {}))
    found = Particles(
        atoms.get_positions(),
        elements=atoms.get_chemical_symbols(),
        numbers={"mass": atoms.get_masses()},
        cell=np.asarray(atoms.cell),
        unit="angstrom",
    )
    for name, values in columns.items():
        if name not in ("numbers", "positions") and np.shape(values)[:1] == (len(atoms),) and np.ndim(values) < 3:
            found.add(_ASE_NAMES.get(name, name), values)
    charges = columns.get("charges", columns.get("initial_charges"))
    if charges is not None:
        found.add("charge", charges)
    return found


def _is_atom_group(source: Any) -> bool:
    """Returns whether it is an AtomGroup or a Universe."""
    return hasattr(source, "atoms") and (hasattr(source, "trajectory") or hasattr(source, "universe"))


_MDANALYSIS_NAMES = {
    "tempfactors": "b_factor",
    "occupancies": "occupancy",
    "charges": "charge",
    "masses": "mass",
    "formalcharges": "formal_charge",
}
_MDANALYSIS_TEXTS = {"names": "name", "resnames": "resname", "types": "type"}


def _of_atom_group(source: Any, frame: Any) -> Particles:
    """Returns the particles of MDAnalysis. Without elements and residues, uses the types, which MDAnalysis may guess."""
    atoms = source.atoms
    if frame is not None:
        atoms.universe.trajectory[frame]
    texts = {name: _named(atoms, group) for group, name in _MDANALYSIS_TEXTS.items()}
    chains = _named(atoms, "chainIDs")
    segments = _named(atoms, "segids")
    if segments is not None and (segments == "SYSTEM").all():
        segments = None  # MDAnalysis' name for the segment of a file without segments
    texts["chain"] = chains if chains is not None else segments
    elements = _named(atoms, "elements")
    has_residues = texts["resname"] is not None or np.unique(getattr(atoms, "resids", 0)).size > 1
    if not has_residues:
        texts["name"] = texts["chain"] = None  # names that stand for elements, and one residue for all
    numbers = _numbers_of_atom_group(atoms, has_residues)
    types = texts["type"]
    if elements is None and texts["name"] is None and types is not None and not all(map(str.isdecimal, types)):
        elements, texts["type"] = types, None
    ts = atoms.universe.trajectory.ts
    found = Particles(
        atoms.positions,
        elements=elements,
        numbers=numbers,
        texts={name: values for name, values in texts.items() if values is not None},
        cell=_box_of(ts),
        time=float(ts.time) if len(atoms.universe.trajectory) > 1 else None,
        unit="angstrom",
    )
    for name in ("velocities", "forces"):
        if getattr(ts, f"has_{name}", False):
            vectors = getattr(atoms, name)
            found.add(name, vectors)
            if name == "velocities":
                for axis, values in zip(("vx", "vy", "vz"), vectors.T):
                    found.add(axis, values)
    radii = getattr(atoms, "radii", None)
    return found.changed(radii=radii) if radii is not None and np.all(np.asarray(radii) > 0) else found


def _named(atoms: Any, name: str) -> Optional[npt.NDArray[np.str_]]:
    """Returns the names of atoms. Returns None if all of them are empty."""
    values = getattr(atoms, name, None)
    texts = None if values is None else np.asarray(values).astype(np.str_)
    return texts if texts is not None and (texts != "").any() else None


def _numbers_of_atom_group(atoms: Any, has_residues: bool) -> dict[str, npt.NDArray[Any]]:
    """Returns all numbers of the topology, those of users included."""
    numbers = {}
    topology = getattr(atoms.universe, "_topology", None)
    names = {attribute.attrname for attribute in getattr(topology, "attrs", ())} | set(_MDANALYSIS_NAMES)
    for name in sorted(names - {"indices", "resindices", "segindices", "radii", "resids"}):
        values = getattr(atoms, name, None)
        if values is not None and np.shape(values) == (len(atoms),) and np.asarray(values).dtype.kind in "biuf":
            numbers[_MDANALYSIS_NAMES.get(name, name)] = np.asarray(values)
    if has_residues and hasattr(atoms, "resids"):
        numbers["resid"] = atoms.resids
    return numbers


def _box_of(ts: Any) -> Optional[npt.NDArray[Any]]:
    if ts.dimensions is None or not (np.asarray(ts.dimensions) > 0).all():
        return None
    return np.asarray(ts.triclinic_dimensions)


def _is_pipeline(source: Any) -> bool:
    return hasattr(source, "compute") and hasattr(source, "modifiers")


def _of_pipeline(pipeline: Any, frame: Any) -> Particles:
    return _of_ovito(pipeline.compute(frame) if frame is not None else pipeline.compute())


def _of_ovito(data: Any) -> Particles:
    """Returns the particles of OVITO with the colours and radii of its display, all properties and the cell. Its colours
    are sRGB."""
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
    names = None if types is None else _names_of_types(types)
    elements = names if names is not None and SYMBOLS.issuperset(names.tolist()) else None
    cell = None if data.cell is None else np.asarray(data.cell[...])
    found = Particles(
        np.array(particles.positions),
        radii,
        linear,
        elements,
        texts={} if names is None else {"type": names},
        cell=None if cell is None else cell[:, :3].T,
        origin=(0, 0, 0) if cell is None else cell[:, 3],
        time=data.attributes.get("Time"),
    )
    _add_properties(particles, found)
    _add_residues(data, found)
    return found


_OVITO_NAMES = {"Residue Type": "resname", "Residue Identifier": "resid", "Atom Name": "name", "Chain Identifier": "chain"}


def _add_properties(particles: Any, found: Particles) -> None:
    for name in particles.keys():
        if name in ("Position", "Particle Type", "Color", "Radius"):
            continue
        values = particles[name]
        if len(values.types) > 0 and values.ndim == 1:
            found.add(_OVITO_NAMES.get(name, name), _names_of_types(values))
        if len(values.types) == 0 or name == "Structure Type":
            found.add(_OVITO_NAMES.get(name, name), np.array(values[:]))


def _add_residues(data: Any, found: Particles) -> None:
    """Adds the chains in OVITO's table of residues and, if the particles lack residue numbers, places in it, from 1."""
    residues = getattr(data, "residues", None)
    if residues is None or "residue_index" not in found.numbers:
        return
    place = found.numbers["residue_index"].astype(int)
    if "resid" not in found.numbers:
        found.add("resid", place + 1)
    if "Chain" in residues and residues.count > 0:
        known = (place >= 0) & (place < residues.count)
        names = _names_of_types(residues["Chain"])[np.where(known, place, 0)]
        found.add("chain", np.where(known, names, "?"))


def _names_of_types(values: Any) -> npt.NDArray[np.str_]:
    """Returns the name of each value, or its number if the type has no name."""
    names = {kind.id: kind.name for kind in values.types}
    ids, which = np.unique(np.asarray(values), return_inverse=True)
    return np.array([names.get(int(i)) or str(i) for i in ids])[which]


def _is_ovito_data(source: Any) -> bool:
    return hasattr(source, "particles") and hasattr(source, "attributes")


_WITH_FRAMES: Iterable[tuple[Callable[[Any], bool], Callable[[Any, Any], Particles]]] = (
    (_is_atom_group, _of_atom_group),
    (_is_pipeline, _of_pipeline),
)
_OTHERS: Iterable[tuple[Callable[[Any], bool], Callable[[Any], Particles]]] = (
    (lambda source: isinstance(source, Particles), lambda source: source),
    (_is_ase, _of_ase),
    (_is_ovito_data, _of_ovito),
    (is_table, particles_of_table),
)

"""Turns colours by an array, or by a column of texts, into what the program colours by."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from .errors import InputError
from .particle_files import RESERVED, column_name
from .particles import Particles

_CATEGORIES = {"name": "atom", "resname": "residue", "chain": "chain", "type": "type"}
"""The columns of texts that the program knows, and its words for them."""


def colored(particles: Particles, options: dict[str, Any]) -> Particles:
    """Returns the particles with the column that `color_by` in `options` needs. Changes `color_by` to its name. The column
    of an array is called "value", that of a Series has the name of the Series."""
    by = options.get("color_by")
    if by is None:
        return particles
    particles = particles.changed()
    if not isinstance(by, str):
        name = column_name(getattr(by, "name", None) or "value")
        by = "value" if name in RESERVED or name in _CATEGORIES else name
        values = np.asarray(by_values(options["color_by"]))
        if values.shape != (len(particles),):
            raise InputError(
                f"color_by: the array has shape {values.shape}: give a number or text for each of {len(particles)} particles"
            )
        if values.dtype.kind == "b":
            values = np.where(values, "true", "false")
        particles.numbers.pop(by, None)
        particles.texts.pop(by, None)
        particles.add(by, values)
    options["color_by"] = _word_for(particles, by)
    return particles


def title_of(by: Any, word: Any) -> Optional[str]:
    """Returns the title of a legend for colours by `by`, the user's `color_by`; `word` is the program's name for it. Returns
    None if the program's own title is right."""
    name = by if isinstance(by, str) else getattr(by, "name", None)
    return str(name) if name is not None and column_name(name) != word and word not in (None, "atom", "residue") else None


def by_values(by: Any) -> npt.NDArray[Any]:
    """Returns the numbers or texts of an array, list, Series or Categorical."""
    return np.asarray(by.to_numpy() if hasattr(by, "to_numpy") else by)


def _word_for(particles: Particles, by: str) -> str:
    """Returns the program's word for a column. Texts that are not names of atoms become the types."""
    name = column_name(by)
    if name in particles.texts and name not in _CATEGORIES:
        particles.texts["type"] = particles.texts[name]
        return "type"
    if name in ("name", "resname"):
        return _CATEGORIES[name]
    stem, dot, axis = name.rpartition(".")
    component = f"{stem}_{axis}"
    if dot and name not in particles.numbers and component in particles.numbers:
        return component
    return name if name in particles.numbers else by


def needs_range(options: Mapping[str, Any]) -> bool:
    """Returns whether `color_by` is a number, and `range` has no numbers for it. Raises InputError for percentages, and for
    numbers that are categories."""
    by, given = options.get("color_by"), options.get("range")
    if not isinstance(by, str) or column_name(by) in ("element", "type", "chain", "atom", "residue"):
        return False
    if options.get("color_scale") == "categories":
        raise InputError(
            "color_scale: numbers as categories would have other colours in each frame: give an array of texts, or make a "
            "film of the file with `parray film`"
        )
    if given is None:
        return True
    ends_given = given.split(":") if isinstance(given, str) else given
    if "%" in str(given) or any(str(end).strip() == "" for end in ends_given):
        raise InputError(f"range: {given!r} would be another range in each frame: give two numbers")
    return False


def range_over(frames: Sequence[Particles], options: Mapping[str, Any]) -> tuple[float, float]:
    """Returns the smallest and the largest number of all frames. For a single frame the program chooses the same two."""
    by = column_name(options["color_by"])
    return ends([_extent(frame, by) for frame in frames], options.get("colormap"))


def ends(extents: Sequence[tuple[float, float]], colormap: Optional[str]) -> tuple[float, float]:
    """Returns the two ends, which differ, of a range that contains all `extents`. For "blue-red", 0 is in the middle if the
    numbers have both signs."""
    low, high = min(low for low, _ in extents), max(high for _, high in extents)
    if colormap == "blue-red" and low < 0 < high:
        high = max(high, -low)
        low = -high
    room = 0 if low < high else max(abs(low) / 2, 0.5)
    return low - room, high + room


def _extent(particles: Particles, name: str) -> tuple[float, float]:
    known = {**particles.numbers, **dict(zip("xyz", particles.positions.T))}
    if particles.radii is not None:
        known["radius"] = particles.radii
    known["index"] = np.arange(len(particles), dtype=np.float64)
    if name not in known:
        raise InputError(f"color_by: a frame has no {name}: it has {', '.join(known)}")
    finite = known[name][np.isfinite(known[name])]
    if finite.size == 0:
        raise InputError(f"color_by: a frame has no finite {name}: choose another column")
    return float(finite.min()), float(finite.max())

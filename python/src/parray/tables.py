"""Particles of tables: pandas, astropy, pyarrow, and structured arrays of numpy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from .errors import InputError
from .particle_files import column_name
from .particles import Particles

Columns = dict[str, npt.NDArray[Any]]

_AXES = ("x", "y", "z")
_COLORS = (("red", "green", "blue"), ("r", "g", "b"))
_ELEMENTS = ("element", "elements", "species", "symbol")
_WAYS = ("{}", "pos_{}", "position_{}", "coord_{}", "{}_coord", "center_{}", "centroid_{}", "coordinates_{}")
_DISTANCES = ("distance", "dist", "r_est")


def is_table(source: Any) -> bool:
    return _names_of(source) is not None


def _names_of(source: Any) -> Optional[list[Any]]:
    """Returns the names of a table's columns. Returns None for anything else."""
    fields = getattr(getattr(source, "dtype", None), "names", None)  # numpy, a structured array
    if fields is not None:
        return list(fields)
    if hasattr(source, "colnames"):  # astropy
        return list(source.colnames)
    if hasattr(source, "column_names"):  # pyarrow
        return list(source.column_names)
    if hasattr(source, "columns") and hasattr(source, "__getitem__"):  # pandas, polars
        return list(source.columns)
    return None


def particles_of_table(source: Any) -> Particles:
    """Returns the particles of a table with columns x, y and z. Other columns keep their names. Without x, y and z, takes a
    table of three columns for positions, and ra, dec and a distance or a parallax for places on the sky."""
    columns: Columns = {}
    for name in _names_of(source) or []:
        columns.setdefault(column_name(name), _values(source[name]))
    return particles_of_columns(columns)


def particles_of_columns(columns: Mapping[str, npt.NDArray[Any]]) -> Particles:
    rest = dict(columns)
    positions = _positions(rest)
    colors = None
    for three in _COLORS:
        if colors is None and all(name in rest for name in three):
            colors = _colors(np.stack([rest.pop(name) for name in three], axis=-1))
    radii = rest.pop("radius", None)
    if radii is None and "diameter" in rest:
        radii = np.asarray(rest.pop("diameter"), np.float64) / 2
    elements = next((rest.pop(name) for name in _ELEMENTS if name in rest), None)
    found = Particles(positions, radii, colors, elements)
    for name, values in rest.items():
        if np.shape(values)[:1] != (len(found),) or np.ndim(values) > 2 or np.asarray(values).dtype.kind in "cmMV":
            continue
        if name == "type":
            found.texts["type"] = found._texts("type", np.asarray(values))
        else:
            found.add(name, values)
    return found


def _values(column: Any) -> npt.NDArray[Any]:
    """Returns the values of a column. Values that are missing become NaN."""
    if hasattr(getattr(column, "dtype", None), "na_value") and column.dtype.kind in "iuf":  # pandas, with missing values
        return np.asarray(column.to_numpy(np.float64, na_value=np.nan))
    if hasattr(column, "to_numpy"):
        return np.asarray(column.to_numpy())
    if isinstance(column, np.ma.MaskedArray) and column.dtype.kind in "iuf":
        return np.where(np.ma.getmaskarray(column), np.nan, np.ma.getdata(column))
    return np.asarray(column)


def _positions(rest: Columns) -> npt.NDArray[Any]:
    """Returns the positions and removes their columns from `rest`."""
    for way in _WAYS:
        names = [way.format(axis) for axis in _AXES]
        if all(name in rest for name in names):
            return np.stack([rest.pop(name) for name in names], axis=-1)
    for name in ("positions", "position", "pos", "coordinates", "points", "xyz"):
        if name in rest and rest[name].ndim == 2 and rest[name].shape[1] == 3:
            return rest.pop(name)
    if "ra" in rest and "dec" in rest and {"parallax", *_DISTANCES} & rest.keys():
        return _on_sky(rest)
    if len(rest) == 3:
        return np.stack([rest.pop(name) for name in list(rest)], axis=-1)
    raise InputError(f"the table has no columns x, y and z: it has {', '.join(rest)}: rename three of them")


def _on_sky(rest: Columns) -> npt.NDArray[Any]:
    """Returns the places of stars, with x towards ra = dec = 0 and z towards the pole. Angles are in degrees. A parallax in
    milliarcseconds gives a distance in parsec. Drops stars without a distance."""
    named = next((name for name in _DISTANCES if name in rest), None)
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = np.asarray(rest[named] if named else 1000 / np.asarray(rest["parallax"], np.float64), np.float64)
    known = np.isfinite(distance) & (distance > 0)
    for name, values in rest.items():
        rest[name] = values[known]
    ra, dec = (np.radians(np.asarray(rest[name], np.float64)) for name in ("ra", "dec"))
    towards = np.stack([np.cos(dec) * np.cos(ra), np.cos(dec) * np.sin(ra), np.sin(dec)], axis=-1)
    places: npt.NDArray[Any] = distance[known][:, np.newaxis] * towards
    return places


def _colors(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Returns colours as bytes if they are whole numbers and one is above 1, otherwise as they are."""
    if values.dtype.kind in "iu" and values.max(initial=0) > 1 and values.min(initial=0) >= 0:
        return (values // 257 if values.max() > 255 else values).astype(np.uint8)
    return values

"""Several pictures of one call: frames, which share camera, light and colours, or views."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Optional

import numpy as np
import numpy.typing as npt

from .coloring import by_values, colored, ends, needs_range, range_over
from .errors import InputError
from .options import RenderOptions, split
from .particles import Particles
from .scene import Convert, Scene, is_scene, prepare
from .sources import count_of_frames, is_particle_object, particles_of

Validate = Callable[[Path, Sequence[str]], dict[str, Any]]
"""Runs `parray validate --json` for a particle file."""


class Call(NamedTuple):
    """The arguments of render() for one picture."""

    source: Any
    radii: Any
    colors: Any
    options: dict[str, Any]


class _Frame(NamedTuple):
    """A source and the frame of it."""

    source: Any
    number: Optional[int]


def calls_of(
    source: Any, radii: Any, colors: Any, given: Mapping[str, Any], convert: Convert, validate: Validate
) -> Optional[Iterator[Call]]:
    """Returns the calls for the pictures of several frames or views. Returns None for a single picture."""
    options = {name: value for name, value in given.items() if value is not None}
    views, frames = options.pop("views", None), _frames_of(source, options.pop("frames", None), validate)
    if views is not None:
        if frames is not None or "view" in options:
            raise InputError("views: give either views or one view, and one frame: or call render() for each frame")
        names = views.split(",") if isinstance(views, str) else views
        return iter([Call(source, radii, colors, {**options, "view": name.strip()}) for name in names])
    if frames is None:
        return None
    if "frame" in options:
        raise InputError("frame, frames: give one of them")
    if any(is_scene(frame.source) for frame in frames):
        return iter([Call(frame.source, radii, colors, options) for frame in frames])
    return iter(_of_frames(frames, radii, colors, options, convert, validate))


def _frames_of(source: Any, chosen: Any, validate: Validate) -> Optional[list[_Frame]]:
    """Returns the frames of a call. Returns None for a single one."""
    series = _series(source)
    if chosen is None:
        return None if series is None else [_Frame(item, None) for item in series]
    everything = isinstance(chosen, str) and chosen == "all"
    if not everything and (isinstance(chosen, str) or not hasattr(chosen, "__iter__")):
        raise InputError(f"frames: {chosen!r} is not a list of numbers: give frames=range(10), frames=[0, 5] or frames='all'")
    if everything:
        chosen = range(len(series) if series is not None else _count_of(source, validate))
    numbers = [int(number) for number in chosen]
    if not numbers:
        raise InputError("frames: there are no frames: give at least one, such as frames=range(10)")
    if series is None:
        return [_Frame(source, number) for number in numbers]
    if not all(-len(series) <= number < len(series) for number in numbers):
        raise InputError(f"frames: the source has {len(series)} frames, from 0: give numbers of these")
    return [_Frame(series[number], None) for number in numbers]


def _count_of(source: Any, validate: Validate) -> int:
    """Returns the number of frames of a file or an object."""
    count = count_of_frames(source)
    if count is None and isinstance(source, (str, os.PathLike)) and not is_scene(source):
        count = validate(Path(source), []).get("frames")
    if count is None:
        raise InputError("frames: the number of frames is not known: give frames=range(N)")
    return count


def _series(source: Any) -> Any:
    """Returns the frames in a list, an iterator, a trajectory of ASE, or an array of (F, N, 3). Returns None for others."""
    if is_particle_object(source):
        return None
    if isinstance(source, np.ndarray):
        return source if source.ndim == 3 else None
    if hasattr(source, "__next__"):
        source = list(source)
    if not hasattr(source, "__getitem__") or not hasattr(source, "__len__") or len(source) == 0:
        return None
    first = source[0]
    if is_particle_object(first):
        return source
    return source if np.ndim(first) == 2 and np.shape(first)[1:] == (3,) else None


def _of_frames(
    frames: list[_Frame], radii: Any, colors: Any, options: dict[str, Any], convert: Convert, validate: Validate
) -> list[Call]:
    """Returns a scene for each frame. All have the camera and the light of one automatic scene."""
    scene_options, settings = split(options, RenderOptions)
    elements = scene_options.pop("elements", None)
    by = scene_options.get("color_by")

    def particles_at(place: int) -> Optional[Particles]:
        found = particles_of(*frames[place])
        if found is None:
            return None
        own = {"color_by": _part(by, place, len(frames))}
        found = colored(found.changed(radii=radii, colors=colors, elements=elements), own)
        if by is not None:
            scene_options["color_by"] = own["color_by"]
        return found

    with tempfile.TemporaryDirectory(prefix="parray-") as name:
        folder = Path(name)
        first = particles_at(0)
        if first is None:
            return _of_files(frames, radii, colors, {**scene_options, "elements": elements}, settings, folder, convert, validate)
        all_particles = [first, *(_certain(particles_at(place)) for place in range(1, len(frames)))]
        limits = range_over(all_particles, scene_options)
        if limits is not None:
            scene_options["range"] = limits
        if first.radii is None and first.elements is None:
            radius = _radius_of(first, settings, folder, convert)
            all_particles = [particles.changed(radii=radius) for particles in all_particles]
        whole = all_particles[0].with_more([(other, _outermost(other)) for other in all_particles[1:]])
        scene = _scene(whole, scene_options, settings, folder / "all", convert)
    item = {key: value for key, value in scene["particles"][0].items() if key != "topology"}
    return [_call(scene, {**item, "file": particles}, settings) for particles in all_particles]


def _of_files(
    frames: list[_Frame],
    radii: Any,
    colors: Any,
    scene_options: dict[str, Any],
    settings: dict[str, Any],
    folder: Path,
    convert: Convert,
    validate: Validate,
) -> list[Call]:
    """Returns the scenes of files that the program reads. The camera is that of the first frame."""
    if not all(isinstance(frame.source, (str, os.PathLike)) for frame in frames):
        raise InputError("frames: files and other sources are mixed: give frames of one kind")
    words = [["--frame", str(frame.number)] if frame.number is not None else [] for frame in frames]
    if needs_range(scene_options):
        topology = ["--topology", os.fspath(scene_options["topology"])] if "topology" in scene_options else []
        facts = [validate(Path(frame.source), word + topology) for frame, word in zip(frames, words)]
        limits = [limit for limit in (_limits_of(fact, scene_options["color_by"].lower()) for fact in facts) if limit]
        if limits:
            scene_options["range"] = ends(limits, scene_options.get("colormap"))
    if frames[0].number is not None:
        scene_options["frame"] = frames[0].number
    scene = _scene(frames[0].source, scene_options, settings, folder / "first", convert, radii, colors)
    calls = []
    for frame in frames:
        item = {**scene["particles"][0], "file": str(Path(frame.source).absolute())}
        if frame.number is not None:
            item["frame"] = frame.number
        calls.append(_call(scene, item, settings))
    return calls


def _limits_of(facts: Mapping[str, Any], by: str) -> Optional[tuple[float, float]]:
    """Returns the smallest and the largest number of a file. Returns None if it has no such column."""
    if by in ("x", "y", "z") and "box" in facts:
        return facts["box"]["low"]["xyz".index(by)], facts["box"]["high"]["xyz".index(by)]
    found = facts.get("properties", {}).get(by)
    return None if found is None else (found["low"], found["high"])


def _scene(
    source: Any,
    options: Mapping[str, Any],
    settings: Mapping[str, Any],
    folder: Path,
    convert: Convert,
    radii: Any = None,
    colors: Any = None,
) -> Scene:
    folder.mkdir()
    work = prepare(source, radii, colors, options, settings, folder, convert, as_scene=True)
    assert not isinstance(work.source, Path)
    return work.source


def _call(scene: Scene, item: Mapping[str, Any], settings: Mapping[str, Any]) -> Call:
    return Call({**scene, "particles": [item]}, None, None, dict(settings))


def _radius_of(first: Particles, settings: Mapping[str, Any], folder: Path, convert: Convert) -> Any:
    """Returns the radius that the program chooses for the first frame."""
    return _scene(first, {}, settings, folder / "radius", convert)["particles"][0].get("radius")


def _certain(particles: Optional[Particles]) -> Particles:
    if particles is None:
        raise InputError("frames: files and other sources are mixed: give frames of one kind")
    return particles


def _part(by: Any, place: int, count: int) -> Any:
    """Returns the part of `color_by` for a frame: one of several arrays, or the same for all."""
    if by is None or isinstance(by, str):
        return by
    several = isinstance(by, (list, tuple)) and len(by) == count and np.ndim(by[0]) == 1
    return by[place] if several or by_values(by).ndim == 2 else by


def _outermost(particles: Particles, directions: int = 64) -> npt.NDArray[np.intp]:
    """Returns the particles that are farthest in directions that are spread evenly over the sphere (Fibonacci)."""
    turn = np.arange(directions) * np.pi * (3 - 5**0.5)
    height = 1 - (2 * np.arange(directions) + 1) / directions
    across = np.sqrt(1 - height**2)
    towards = np.stack([across * np.cos(turn), across * np.sin(turn), height])
    reach = particles.positions @ towards
    if particles.radii is not None:
        reach += particles.radii[:, np.newaxis]
    return np.unique(reach.argmax(axis=0))


def facts_of(program: str, file: Path, words: Sequence[str]) -> dict[str, Any]:
    """Returns what `parray validate` says about a particle file; nothing if it refuses the file or the options."""
    done = subprocess.run(
        [program, "validate", str(file), "--json", *words], stdin=subprocess.DEVNULL, capture_output=True, check=False
    )
    if done.returncode != 0:
        return {}
    files = json.loads(done.stdout).get("particle_files", [])
    return dict(files[0]) if files else {}

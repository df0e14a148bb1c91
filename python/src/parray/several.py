"""Several pictures of one call: frames, which share camera, light and colours, or views."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Optional

import numpy as np
import numpy.typing as npt

from .coloring import by_values, colored, ends, needs_range, range_over, title_of
from .errors import InputError
from .options import RenderOptions, split
from .other_files import takes_topology
from .particles import Particles
from .scene import Convert, Scene, Work, is_scene, prepare, with_labels_of
from .sources import count_of_frames, is_particle_object, particles_of


class Tools(NamedTuple):
    """Functions that run `parray`, which calls_of() needs."""

    convert: Convert
    validate: Callable[[Path, Sequence[str]], dict[str, Any]]
    """Runs `parray validate --json` for a particle file."""
    legends: Callable[[Path], list[dict[str, Any]]]
    """Returns the legends for a file. Renders a picture of few pixels to find them."""
    has_option: Callable[[str], bool]
    """Returns whether `parray render` has an option."""


class Call(NamedTuple):
    """The arguments of render() for one picture."""

    source: Any
    radii: Any
    colors: Any
    options: dict[str, Any]


_FRACTIONS = ("fx", "fy", "fz")
_COLORING = ("color_by", "colormap", "range", "color_scale")
_MIXED = "frames: files and other sources are mixed: give frames of one kind"


class _Frame(NamedTuple):
    """One frame: a source and, if the source has several frames, the number of the frame in it."""

    source: Any
    number: Optional[int]


def calls_of(source: Any, radii: Any, colors: Any, given: Mapping[str, Any], tools: Tools) -> Optional[Iterator[Call]]:
    """Returns the calls for the pictures of several frames or views. Returns None for a single picture."""
    options = {name: value for name, value in given.items() if value is not None}
    views, frames = options.pop("views", None), _frames_of(source, options.pop("frames", None), tools)
    if views is not None:
        if frames is not None or "view" in options:
            raise InputError("views: cannot be combined with view or frames: leave these out, or call render() for each frame")
        names = views.split(",") if isinstance(views, str) else views
        return iter([Call(source, radii, colors, {**options, "view": name.strip()}) for name in names])
    if frames is None:
        return None
    if "frame" in options:
        raise InputError("frame, frames: give one of them")
    if any(is_scene(frame.source) for frame in frames):
        return iter([Call(frame.source, radii, colors, options) for frame in frames])
    return iter(_of_frames(frames, radii, colors, options, tools))


def _frames_of(source: Any, chosen: Any, tools: Tools) -> Optional[list[_Frame]]:
    """Returns the frames of a call: those of `chosen`, the keyword `frames`, or all of a series. Returns None for a single
    picture."""
    series = _series(source)
    if chosen is None:
        return None if series is None else [_Frame(item, None) for item in series]
    everything = isinstance(chosen, str) and chosen == "all"
    if not everything and (isinstance(chosen, str) or not hasattr(chosen, "__iter__")):
        raise InputError(f"frames: {chosen!r} is not a list of numbers: give range(10), [0, 5] or 'all'")
    if everything:
        chosen = range(len(series) if series is not None else _count_of(source, tools))
    numbers = [int(number) for number in chosen]
    if not numbers:
        raise InputError("frames: there are no frames: give at least one, such as frames=range(10)")
    if series is None:
        return [_Frame(source, number) for number in numbers]
    if not all(-len(series) <= number < len(series) for number in numbers):
        raise InputError(f"frames: the source has {len(series)} frames, from 0: give numbers of these")
    return [_Frame(series[number], None) for number in numbers]


def _count_of(source: Any, tools: Tools) -> int:
    """Returns the number of frames of a file or an object."""
    count = count_of_frames(source)
    if count is None and isinstance(source, (str, os.PathLike)) and not is_scene(source):
        count = tools.validate(Path(source), []).get("frames")
    if count is None:
        raise InputError("frames: the number of frames is not known: give frames=range(N)")
    return count


def is_series(source: Any) -> bool:
    """Returns whether the source itself is a series of frames, such as a list of sources. Then `frames` is not needed."""
    return _series(source) is not None


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


def _of_frames(frames: list[_Frame], radii: Any, colors: Any, options: dict[str, Any], tools: Tools) -> list[Call]:
    """Returns a scene for each frame. All have the camera and the light of one automatic scene."""
    scene_options, settings = split(options, RenderOptions)
    with tempfile.TemporaryDirectory(prefix="parray-") as name:
        folder = Path(name)
        topology = scene_options.get("topology")
        first = particles_of(*frames[0], topology)
        if first is None:
            return _of_files(frames, radii, colors, scene_options, settings, folder, tools)
        if isinstance(frames[0].source, (str, os.PathLike)) and takes_topology(Path(frames[0].source)):
            del scene_options["topology"]
        by, words = scene_options.get("color_by"), {}
        columns = {"radii": radii, "colors": colors, "elements": scene_options.pop("elements", None)}
        particles = []
        for place, frame in enumerate(frames):
            found = first if place == 0 else particles_of(*frame, topology)
            if found is None:
                raise InputError(_MIXED)
            words = {"color_by": _part(by, place, len(frames))}
            particles.append(colored(found.changed(**columns), words))
        if by is not None:
            scene_options["color_by"] = words["color_by"]
        if needs_range(scene_options):
            probe = _hides(scene_options) or scene_options["color_by"] in _FRACTIONS or _is_log(scene_options)
            limits = _limits_of_shown([(some, {}) for some in particles], scene_options, folder, tools) if probe else None
            scene_options["range"] = limits or range_over(particles, scene_options)
        _fix_shows([(some, {}) for some in particles], scene_options, folder, tools)
        if particles[0].radii is None and particles[0].elements is None:
            radius = _scene(particles[0], {}, settings, folder / "radius", tools)["particles"][0].get("radius")
            particles = [some.changed(radii=radius) for some in particles]
        whole = particles[0].with_more([(other, _outermost(other)) for other in particles[1:]])
        scene = _scene(whole, scene_options, settings, folder / "all", tools)
        labels = Work(scene, whole.unit_in(Path(scene["particles"][0]["file"])), title_of(_part(by, 0, len(frames)), words["color_by"]))
        settings = with_labels_of(labels, settings, tools.has_option)
    item = {key: value for key, value in scene["particles"][0].items() if key != "topology"}
    items = _with_all_names(particles, scene_options.get("color_by"), item)
    return [_call(scene, item, settings) for item in items]


def _with_all_names(particles: Sequence[Particles], by: Any, item: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Returns the items of the scenes. The program colours the names of a file by their order among all its names. So that a
    name has one colour in all frames, each frame gets a hidden particle for every name that only other frames have."""
    column = {"type": "type", "chain": "chain", "atom": "name"}.get(by, "") if isinstance(by, str) else ""
    names = {name for some in particles for name in some.texts.get(column, ())}
    items = []
    for some in particles:
        missing = sorted(names - set(some.texts.get(column, ())))
        own = {**item, "file": some}
        if missing:
            more = some.with_more([(some, np.zeros(len(missing), np.intp))])
            more.texts[column] = np.concatenate([some.texts[column], np.array(missing)])
            shown = f"index < {len(some)}"
            own = {**item, "file": more, "select": f"({item['select']}) and {shown}" if "select" in item else shown}
        items.append(own)
    return items


def _of_files(
    frames: list[_Frame],
    radii: Any,
    colors: Any,
    scene_options: dict[str, Any],
    settings: dict[str, Any],
    folder: Path,
    tools: Tools,
) -> list[Call]:
    """Returns the scenes of files that the program reads. The camera is that of the first frame."""
    if not all(isinstance(frame.source, (str, os.PathLike)) for frame in frames):
        raise InputError(_MIXED)
    numbers = [{} if frame.number is None else {"frame": frame.number} for frame in frames]
    sources = list(zip([frame.source for frame in frames], numbers))
    if needs_range(scene_options):
        probe = _hides(scene_options) or _is_log(scene_options)
        limits = None if probe else _limits_of_files(frames, scene_options, tools)
        scene_options["range"] = limits or _limits_of_shown(sources, scene_options, folder, tools)
    _fix_shows(sources, scene_options, folder, tools)
    scene = _scene(frames[0].source, {**scene_options, **numbers[0]}, settings, folder / "first", tools, radii, colors)
    item = scene["particles"][0]
    return [
        _call(scene, {**item, "file": str(Path(frame.source).absolute()), **number}, settings)
        for frame, number in zip(frames, numbers)
    ]


def _hides(options: Mapping[str, Any]) -> bool:
    """Returns whether options may hide particles."""
    return any(name in options for name in ("select", "slice", "hide"))


def _is_log(options: Mapping[str, Any]) -> bool:
    """Returns whether the colours have a logarithmic scale, which only numbers above 0 determine."""
    return options.get("color_scale") == "log"


def _fix_shows(
    sources: Sequence[tuple[Any, Mapping[str, Any]]], options: dict[str, Any], folder: Path, tools: Tools
) -> None:
    """Sets the range of each part in `show` that has its own `color_by` with numbers: the range of its selection in all
    frames."""
    fixed: list[Any] = []
    for part in options.get("show", []):
        if not isinstance(part, str) and "color_by" in part and "select" in part and needs_range(part):
            whole = {name: value for name, value in options.items() if name not in ("show", "material", *_COLORING)}
            look = {name: value for name, value in part.items() if name in _COLORING}
            select = f"({options['select']}) and ({part['select']})" if "select" in options else part["select"]
            limits = _limits_of_shown(sources, {**whole, **look, "select": select}, folder, tools)
            part = {**part, "range": limits}
        fixed.append(part)
    if fixed:
        options["show"] = fixed


def _limits_of_shown(
    sources: Sequence[tuple[Any, Mapping[str, Any]]], options: Mapping[str, Any], folder: Path, tools: Tools
) -> tuple[float, float]:
    """Returns the smallest and the largest number of the particles that are shown, according to the program. `sources`:
    files or particles, each with further options."""
    limits = []
    for source, more in sources:
        with tempfile.TemporaryDirectory(dir=folder, prefix="parray-") as name:
            work = prepare(source, None, None, {**options, **more}, {}, Path(name), tools.convert)
            legend = tools.legends(work.local_file(Path(name)))[0]
        limits.append((legend["low"], legend["high"]))
    return ends(limits, options.get("colormap"))


def _limits_of_files(frames: list[_Frame], options: Mapping[str, Any], tools: Tools) -> Optional[tuple[float, float]]:
    """Returns the smallest and the largest number of files. Returns None if `parray validate` does not say them."""
    topology = ["--topology", os.fspath(options["topology"])] if "topology" in options else []
    limits = []
    for frame in frames:
        words = ["--frame", str(frame.number)] if frame.number is not None else []
        found = _limits_of(tools.validate(Path(frame.source), words + topology), options["color_by"].lower())
        if found is None:
            return None
        limits.append(found)
    return ends(limits, options.get("colormap"))


def _limits_of(facts: Mapping[str, Any], by: str) -> Optional[tuple[float, float]]:
    """Returns the smallest and the largest number of a file. Returns None if it has no such column, or if the program
    has a number of its own with this name."""
    if by in (*_FRACTIONS, "index"):
        return None
    if by in ("x", "y", "z") and "box" in facts:
        return facts["box"]["low"]["xyz".index(by)], facts["box"]["high"]["xyz".index(by)]
    found = facts.get("properties", {}).get(by)
    return None if found is None else (found["low"], found["high"])


def _scene(
    source: Any,
    options: Mapping[str, Any],
    settings: Mapping[str, Any],
    folder: Path,
    tools: Tools,
    radii: Any = None,
    colors: Any = None,
) -> Scene:
    folder.mkdir()
    work = prepare(source, radii, colors, options, settings, folder, tools.convert, as_scene=True)
    assert not isinstance(work.source, Path)
    return work.source


def _call(scene: Scene, item: Mapping[str, Any], settings: Mapping[str, Any]) -> Call:
    return Call({**scene, "particles": [item]}, None, None, dict(settings))


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
    radii = 0 if particles.radii is None else particles.radii
    towards = np.stack([across * np.cos(turn), across * np.sin(turn), height], axis=-1)
    return np.unique([np.argmax(particles.positions @ direction + radii) for direction in towards])

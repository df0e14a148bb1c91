"""Prepares the input of a render as files: an existing file, a file of particles, or a scene that refers to files."""

from __future__ import annotations

import copy
import json
import math
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Callable, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from .coloring import colored, title_of
from .errors import InputError
from .options import OF_PARTICLES, as_arguments
from .other_files import takes_topology
from .particles import Particles
from .sources import particles_of
from .srgb import srgb_to_linear

Scene = dict[str, Any]
Convert = Callable[[Path, Path, list[str]], None]
"""Runs `parray convert` with options: converts a particle file to a scene file."""


class Work(NamedTuple):
    """The input: a file of the user or of prepare(), or a scene whose files have absolute paths."""

    source: Union[Path, Scene]
    unit: Optional[str] = None
    """The unit of lengths in labels. None: that of the file's format."""
    title: Optional[str] = None
    """The title of the legend. None: that of the program."""
    options: tuple[str, ...] = ()
    """Options of `parray render` that belong to the file."""
    asked: Mapping[str, Any] = {}
    """The same options by their names."""

    def local_file(self, folder: Path) -> Path:
        """Returns a file for the program."""
        if isinstance(self.source, Path):
            return self.source
        path = folder / "scene.json"
        path.write_bytes(scene_bytes(self.source))
        return path

    def parts(self) -> tuple[Optional[bytes], dict[str, Path]]:
        """Returns the parts of a form: the scene, if any, and the files by the names in the scene."""
        if isinstance(self.source, Path) and not _is_scene(self.source):
            return None, {safe_name(self.source.name): self.source}
        if isinstance(self.source, Path):
            text = _text(self.source)
            try:
                scene = _parsed(text, self.source)
            except ValueError:
                return text, {}  # ParRay will report the error
            if not _particle_items(scene):
                return text, {}  # the format may be one that only ParRay knows
        else:
            scene = copy.deepcopy(self.source)
        files: dict[str, Path] = {}
        for item in _particle_items(scene):
            for key in _files_of(item):
                path = Path(item[key])
                item[key] = f"{len(files)}-{safe_name(path.name)}"
                files[item[key]] = path
        return scene_bytes(scene), files


def safe_name(name: str) -> str:
    """Returns the end of a name, with its extension, in characters that a server accepts."""
    return re.sub(r"[^A-Za-z0-9._-]", "_", name)[-100:].lstrip(".-")


def scene_bytes(scene: Scene) -> bytes:
    try:
        return json.dumps(scene, default=_plain, allow_nan=False).encode()
    except (TypeError, ValueError) as error:
        raise InputError(f"the scene is not valid JSON: {error}") from error


def _plain(value: Any) -> Any:
    """Converts numpy's numbers and arrays, and paths, to JSON values."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"{type(value).__name__} is neither a number nor text")


def prepare(
    source: Any,
    radii: Optional[npt.ArrayLike],
    colors: Optional[npt.ArrayLike],
    options: Mapping[str, Any],
    settings: Mapping[str, Any],
    folder: Path,
    convert: Convert,
    *,
    as_scene: bool = False,
    as_file: bool = False,
) -> Work:
    """Returns the input of a render. `options` make the scene, `settings` are all other options. Writes to `folder`, which
    must exist as long as the result is used. With `as_scene`, the result is always a scene. With `as_file`, it is a particle
    file and its options if possible: the program then makes room for labels and chooses the error. Raises InputError."""
    columns = {"radii": radii, "colors": colors, "elements": options.get("elements")}
    columns = {name: value for name, value in columns.items() if value is not None}
    changes = {name: options[name] for name in ("camera", "sky") if name in options}
    asked = {name: options[name] for name in OF_PARTICLES if name in options}
    if is_scene(source):
        refused = [*columns, *(name for name in ("material", *OF_PARTICLES) if name in options)]
        if refused:
            raise InputError(f"{', '.join(refused)}: these options are for particles: write them into the scene")
        if isinstance(source, Mapping):
            return Work(_changed(_with_files(source, folder), changes))
        path = Path(source)
        return Work(_changed(_read(path), changes)) if changes or as_scene else Work(path)
    particles = particles_of(source, asked.get("frame"), asked.get("topology"))
    rules: list[str] = []
    unit = title = None
    material = options.get("material")
    if particles is None:
        path = Path(source)
        rules, material = _rules_of_file(columns, asked, material)
    else:
        by = asked.get("color_by")
        particles = colored(particles.changed(**columns), asked)
        title = title_of(by, asked.get("color_by"))
        path = particles.write(folder, _mentioned(asked))
        unit = particles.unit_in(path)
        asked.pop("frame", None)
        if isinstance(source, (str, os.PathLike)) and takes_topology(Path(source)):
            asked.pop("topology", None)
        rules = _rule_of_names(particles, folder, asked)
    if "projection" not in asked and (projection := _projection_of(changes.get("camera", {}))):
        asked["projection"] = projection
    rules += as_arguments(asked)
    if not (changes or rules or material is not None or as_scene):
        return Work(path, unit, title)
    if as_file and not changes and material is None:
        return Work(path, unit, title, tuple(rules), _asked_of(rules, asked))
    return Work(_automatic_scene(path, folder, rules, material, changes, settings, convert), unit, title)


def _asked_of(rules: list[str], asked: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the options that belong to a file by their names: those of the user, and the others of `rules`."""
    named = dict(asked)
    for option in ("radius", "topology"):
        if "--" + option in rules:
            named[option] = rules[rules.index("--" + option) + 1]
    return named


def with_labels_of(work: Work, settings: Mapping[str, Any], has_option: Callable[[str], bool]) -> dict[str, Any]:
    """Returns the settings with the unit and the title of the input, where labels need them and the user states none."""
    changed = dict(settings)
    if work.unit is not None and (changed.get("scale_bar") or changed.get("legend")):
        changed.setdefault("unit", work.unit)
    if work.title is not None and changed.get("legend") and "legend_title" not in changed and has_option("--legend-title"):
        changed["legend_title"] = work.title
    return changed


def is_scene(source: Any) -> bool:
    return isinstance(source, Mapping) or (isinstance(source, (str, os.PathLike)) and _is_scene(Path(source)))


def _mentioned(asked: Mapping[str, Any]) -> str:
    names = ("color_by", "select", "slice", "radius_by", "center", "show")
    return " ".join(as_arguments({name: asked[name] for name in names if name in asked}))


def _rule_of_names(particles: Particles, folder: Path, asked: dict[str, Any]) -> list[str]:
    """Writes the file of names, if the particles have any, and returns the option that names it."""
    names = particles.write_names(folder)
    if names is None:
        return []
    if "topology" in asked:
        raise InputError("topology: the particles have names of their own: leave topology out")
    for word in ("charge", "mass"):  # the file of names has zeros in their place
        if word not in particles.numbers and re.search(rf"\b{word}\b", _mentioned(asked), re.IGNORECASE):
            raise InputError(f"{word}: the particles have no {word}: they have {', '.join(sorted(particles.numbers))}")
    return ["--topology", str(names)]


def _projection_of(camera: Mapping[str, Any]) -> Optional[str]:
    """Returns the projection that a member of the camera needs. Returns None if the camera states it or needs none."""
    if "projection" in camera or ("vfov" in camera) == ("view_height" in camera):
        return None
    return "perspective" if "vfov" in camera else "orthographic"


def _automatic_scene(
    path: Path,
    folder: Path,
    rules: list[str],
    material: Union[str, Mapping[str, Any], None],
    changes: Mapping[str, Any],
    settings: Mapping[str, Any],
    convert: Convert,
) -> Scene:
    """Returns the automatic scene that `parray` makes from a particle file, with changes."""
    if isinstance(material, str):
        rules = [*rules, "--material", material]
    elif material is not None:
        rules = [*rules, "--material", "plain"]
    for side in ("width", "height"):
        if side in settings:
            rules = [*rules, "--" + side, str(settings[side])]
    file = folder / "automatic.json"
    convert(path, file, rules)
    scene = _read(file)
    item = scene["particles"][0]
    if material is not None and not isinstance(material, str):
        item["material"] = "particles"
        scene["materials"]["particles"] = material
    return _changed(_at_distance(scene, changes.get("camera", {})), changes)


def _at_distance(scene: Scene, camera: Mapping[str, Any]) -> Scene:
    """Moves the camera so that the particles fill the picture as before with another angle of view. Keeps its place if the
    user states that."""
    own = scene["camera"]
    if "vfov" not in camera or "vfov" not in own or "look_from" in camera or "look_at" in camera:
        return scene
    try:
        farther = math.tan(math.radians(own["vfov"]) / 2) / math.tan(math.radians(float(camera["vfov"])) / 2)
    except (TypeError, ValueError, ZeroDivisionError):
        return scene  # ParRay will report the error
    if not 0 < farther < 1e6:
        return scene
    look_from = [at + farther * (place - at) for place, at in zip(own["look_from"], own["look_at"])]
    moved = {"look_from": look_from, "focus_distance": farther * own.get("focus_distance", 1)}
    return {**scene, "camera": {**own, **moved}}


def _rules_of_file(
    columns: Mapping[str, Any], asked: Mapping[str, Any], material: Union[str, Mapping[str, Any], None]
) -> tuple[list[str], Union[str, Mapping[str, Any], None]]:
    """Returns the options for the columns that a file accepts, one radius and one colour for all, and the material."""
    colors = columns.get("colors")
    if colors is not None and np.ndim(colors) == (0 if isinstance(colors, str) else 1):
        if material is not None:
            raise InputError("colors, material: both decide the colour of all particles of a file: leave out one of them")
        color = np.asarray(Particles([[0, 0, 0]], 1, colors).colors)[0]
        linear = srgb_to_linear(color / 255) if color.dtype == np.uint8 else color
        material = {"type": "diffuse", "albedo": linear.tolist()}
        columns = {name: value for name, value in columns.items() if name != "colors"}
    refused = [
        name
        for name, value in columns.items()
        if name != "radii" or (hasattr(value, "__len__") and not isinstance(value, str))
    ]
    if refused:
        raise InputError(
            f"{', '.join(refused)}: a file has its own: give one radius or colour for all, or arrays instead of the file"
        )
    if not isinstance(asked.get("color_by", ""), str):
        raise InputError("color_by: numbers colour arrays and objects, not files: name a column of the file")
    return (["--radius", str(columns["radii"])] if columns else []), material


def _is_scene(path: Path) -> bool:
    return path.suffix.lower() == ".json"


def _particle_items(scene: Any) -> list[Any]:
    """Returns the items of `particles` that name a file. ParRay reports errors in other items."""
    items = scene.get("particles") if isinstance(scene, dict) else None
    named = items if isinstance(items, list) else []
    return [item for item in named if isinstance(item, dict) and isinstance(item.get("file"), str)]


def _files_of(item: Mapping[str, Any]) -> list[str]:
    """Returns the keys of such an item that name files."""
    return [key for key in ("file", "topology") if isinstance(item.get(key), str)]


def _text(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except FileNotFoundError as error:
        raise InputError(f"{path}: no such file: check the path") from error
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from error


def _read(path: Path) -> Scene:
    text = _text(path)
    try:
        return _parsed(text, path)
    except ValueError as error:
        raise InputError(f"{path}: the file is not valid JSON: {error}") from error


def _parsed(text: bytes, path: Path) -> Scene:
    """Parses a scene file and makes the paths of its particle files absolute. Raises ValueError for invalid JSON."""
    scene: Scene = json.loads(text)
    for item in _particle_items(scene):
        for key in _files_of(item):
            item[key] = str((path.parent / item[key]).absolute())
    return scene


def _with_files(scene: Mapping[str, Any], folder: Path) -> Scene:
    """Returns a copy in which particles of any kind that render() accepts have become files."""
    changed = dict(scene)
    items = []
    for number, item in enumerate(scene.get("particles", [])):
        source = item.get("file")
        chosen = {name: item[name] for name in ("frame", "topology") if name in item}
        particles = particles_of(source, **chosen) if source is not None else None
        if particles is not None:
            item = {name: value for name, value in item.items() if name != "frame"}
            place = folder / str(number)
            place.mkdir()
            source = particles.write(place)
            names = particles.write_names(place)
            if names is not None:
                item = {**item, "topology": str(names.absolute())}
        items.append({**item, "file": str(Path(source).absolute())} if source is not None else item)
    if items:
        changed["particles"] = items
    return changed


def _changed(scene: Scene, changes: Mapping[str, Any]) -> Scene:
    """Replaces members of the scene's `camera` and `sky`. With a new projection, drops the member that it does not use."""
    for name, values in changes.items():
        kept = dict(scene.get(name, {}))
        if "projection" in values:
            kept.pop("view_height" if values["projection"] == "perspective" else "vfov", None)
        scene = {**scene, name: {**kept, **values}}
    return scene

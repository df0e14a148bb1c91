"""The keywords of `render` and `Farm.submit`: the options of the command line with underscores instead of hyphens."""

from __future__ import annotations

import difflib
import inspect
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Callable, Literal, TypedDict, TypeVar, Union

if TYPE_CHECKING:
    import numpy.typing as npt

Vector = Union[Sequence[float], "npt.NDArray[Any]"]


class Camera(TypedDict, total=False):
    """The section camera of a scene file; angles in degrees."""

    look_from: Vector
    look_at: Vector
    up: Vector
    projection: Literal["perspective", "orthographic"]
    vfov: float
    view_height: float
    aperture: float
    focus_distance: float


class Sky(TypedDict, total=False):
    """The section sky of a scene file: radiance as red, green, blue."""

    horizon: Vector
    zenith: Vector


class PictureOptions(TypedDict, total=False):
    # The scene.
    elements: Union[npt.ArrayLike, Sequence[str]]
    camera: Camera
    sky: Sky
    material: Union[str, Mapping[str, Any]]
    # Which particles of a file are shown, and how they look.
    frame: Union[int, Literal["last"]]
    topology: Union[str, os.PathLike[str]]
    alternatives: str
    crystal: bool
    replicate: str
    wrap: bool
    whole: bool
    center: str
    select: str
    slice: Union[str, Sequence[str]]
    hide: Union[str, Sequence[str]]
    color_by: Union[str, npt.ArrayLike]
    values: npt.ArrayLike
    colormap: Literal["viridis", "magma", "inferno", "plasma", "cividis", "blue-red", "grey", "violet-yellow"]
    range: Union[str, tuple[float, float]]
    color_scale: Literal["linear", "log", "categories"]
    radius_by: str
    show: Sequence[Union[str, Mapping[str, Any]]]
    view: Literal["auto", "front", "back", "left", "right", "top", "bottom", "iso", "+x", "-x", "+y", "-y", "+z", "-z"]
    style: Union[str, Sequence[str]]
    bonds: Literal["auto", "file", "off"]
    stick_radius: float
    arrows: str
    arrow_scale: float
    solid_cell: bool
    projection: Literal["perspective", "orthographic"]
    up: Union[str, Sequence[float]]
    azimuth: float
    elevation: float
    zoom: float
    # Settings, written by scenes/schema/renew.
    width: int
    height: int
    max_depth: int
    seed: int
    sampler: Literal["independent", "sobol"]
    precision: Literal["auto", "f32", "f64", "mixed"]
    spp: int
    target_error: float
    target_half_width: float
    time_limit: float
    adaptive: bool
    passes: Sequence[int]
    accelerator: Literal["auto", "linear", "bvh", "octree"]
    isa: Literal["auto", "scalar", "avx2", "avx512", "neon"]
    schedule: Literal["static", "guided", "factoring", "weighted"]
    row_order: Literal["auto", "sequential", "interleaved"]
    # End of the settings.
    denoise: bool
    quality: Literal["draft", "good", "print"]
    background: str
    # Labels and postprocessing of the PNG picture.
    outline: Union[bool, float, str]
    depth_cue: Union[bool, float, str]
    legend: bool
    legend_title: str
    scale_bar: bool
    unit: str
    time_stamp: bool
    cell: bool
    text: str
    font_size: float
    width_mm: float
    dpi: float
    labels: bool


class RenderOptions(PictureOptions, total=False):
    """The keywords of render(): those of PictureOptions, and the ones below."""

    # Several pictures.
    frames: Union[Sequence[int], Literal["all"]]
    views: Union[str, Sequence[str]]
    threads: int
    transparent: bool
    aov: Union[str, Sequence[str]]
    like: Union[str, os.PathLike[str]]


class SubmitOptions(PictureOptions, total=False):
    """The keywords of Farm.submit(): those of PictureOptions, and the ones below."""

    name: str
    priority: int
    max_failures: int
    webhook: str
    preview_of: int
    progressive: bool
    frames: Union[str, int, Sequence[int]]


# Options that make the scene. All others are passed on by their names.
OF_PARTICLES = ("frame", "topology", "alternatives", "crystal", "replicate", "wrap", "whole", "center", "select",
                "slice", "hide", "bonds", "arrows", "arrow_scale", "solid_cell", "stick_radius",
                "color_by", "colormap", "range", "color_scale", "radius_by", "show",
                "view", "style", "projection", "up", "azimuth", "elevation", "zoom")  # fmt: skip
OF_SCENE = ("elements", "camera", "sky", "material", *OF_PARTICLES)

_DRAWN = ("outline", "depth_cue", "legend", "legend_title", "scale_bar", "unit", "time_stamp", "cell", "text", "font_size",
          "width_mm", "dpi")  # fmt: skip
_FLAGS = ("denoise", "legend", "scale_bar", "time_stamp", "cell", "wrap", "whole", "solid_cell")
_RENAMED = {"opaque": "transparent=False", "no_labels": "labels=False"}
_OTHER_WORDS = {"cmap": "colormap", "c": "color_by", "color": "colors", "vmin": "range=(low, high)",
                "vmax": "range=(low, high)"}  # fmt: skip

_Function = TypeVar("_Function", bound=Callable[..., Any])


def shows_keywords(options: type) -> Callable[[_Function], _Function]:
    """Makes `help` and completion show the names of the options instead of **options."""
    named = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None) for name in names_of(options)]

    def decorate(function: _Function) -> _Function:
        own = inspect.signature(function)
        first = [p for p in own.parameters.values() if p.kind is not inspect.Parameter.VAR_KEYWORD]
        function.__signature__ = own.replace(parameters=[*first, *named])  # type: ignore[attr-defined]
        return function

    return decorate


def names_of(options: type) -> list[str]:
    return list(options.__annotations__)


def split(given: Mapping[str, Any], options: type) -> tuple[dict[str, Any], dict[str, Any]]:
    """Returns two dicts: the options that make the scene, and all others. Ignores options that are None. Raises TypeError
    for a name that `options`, a class of keywords, does not have."""
    known = names_of(options)
    for name in given:
        if name in _RENAMED:
            raise TypeError(f"{name} is now {_RENAMED[name]}")
        if name in _OTHER_WORDS:
            raise TypeError(f"unknown option {name!r}: did you mean {_OTHER_WORDS[name]}?")
        if name not in known:
            near = difflib.get_close_matches(name, known, 1)
            hint = f"did you mean {near[0]}?" if near else f"the options are {', '.join(known)}"
            raise TypeError(f"unknown option {name!r}: {hint}")
    asked = {name: value for name, value in given.items() if value is not None}
    if "values" in asked:
        if "color_by" in asked:
            raise TypeError("values, color_by: both say what the colours mean: give one of them")
        asked["color_by"] = asked.pop("values")
    scene = {name: asked.pop(name) for name in OF_SCENE if name in asked}
    return scene, asked


def drawn_by(options: Mapping[str, Any]) -> list[str]:
    """Returns the options that give the PNG picture labels, postprocessing or a background of its own."""
    return [name for name in (*_DRAWN, "background") if options.get(name, False) is not False]


def as_arguments(options: Mapping[str, Any]) -> list[str]:
    """Returns the options as arguments of the command line."""
    arguments: list[str] = []
    for name, value in sorted(options.items(), key=lambda item: item[0] == "show"):
        option = "--" + name.replace("_", "-")
        if name == "show":
            arguments += _of_representations(value)
        elif name in _FLAGS:
            arguments += [option] if value else []
        elif isinstance(value, bool):
            arguments += [option, "on" if value else "off"]
        elif isinstance(value, (str, os.PathLike)) or not hasattr(value, "__iter__"):
            arguments += [option, os.fspath(value) if isinstance(value, os.PathLike) else str(value)]
        else:
            arguments += [option, (":" if name == "range" else ",").join(map(str, value))]
    return arguments


def _of_representations(shows: Sequence[Union[str, Mapping[str, Any]]]) -> list[str]:
    """Returns the representations as arguments. Each is a selection, or a mapping with `select` and the options of its look."""
    arguments: list[str] = []
    for show in shows:
        look = {"select": show} if isinstance(show, str) else dict(show)
        if not isinstance(look.get("select"), str):
            raise TypeError(f"show: {show!r} has no selection: write {{'select': 'protein', 'color_by': 'chain'}}")
        arguments += ["--show", look.pop("select"), *as_arguments(look)]
    return arguments


def is_switch(word: str) -> bool:
    """Returns whether a word of the command line is an option without a value, such as --scale-bar."""
    return word.startswith("--") and word[2:].replace("-", "_") in _FLAGS

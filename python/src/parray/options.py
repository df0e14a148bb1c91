"""The keywords of `render` and `Farm.submit`: names and meaning of the command line's, underscores for hyphens."""

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
    """As in a scene file; angles in degrees."""

    look_from: Vector
    look_at: Vector
    up: Vector
    projection: Literal["perspective", "orthographic"]
    vfov: float
    view_height: float
    aperture: float
    focus_distance: float


class Sky(TypedDict, total=False):
    """Radiance, red, green, blue."""

    horizon: Vector
    zenith: Vector


class PictureOptions(TypedDict, total=False):
    # What is seen.
    elements: Union[npt.ArrayLike, Sequence[str]]
    camera: Camera
    sky: Sky
    material: Union[str, Mapping[str, Any]]
    # Which particles of a file are shown, and how.
    frame: Union[int, Literal["last"]]
    topology: Union[str, os.PathLike[str]]
    alternatives: str
    select: str
    slice: Union[str, Sequence[str]]
    hide: Union[str, Sequence[str]]
    color_by: str
    colormap: Literal["viridis", "magma", "inferno", "plasma", "cividis", "blue-red", "grey", "violet-yellow"]
    range: Union[str, tuple[float, float]]
    view: Literal["auto", "front", "back", "left", "right", "top", "bottom", "iso", "+x", "-x", "+y", "-y", "+z", "-z"]
    style: Literal["studio", "publication", "flat", "night"]
    projection: Literal["perspective", "orthographic"]
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


class RenderOptions(PictureOptions, total=False):
    """What is for this machine only."""

    threads: int
    denoise: bool
    transparent: bool
    aov: Union[str, Sequence[str]]
    like: Union[str, os.PathLike[str]]
    # Drawn on the PNG picture.
    outline: Union[bool, float, str]
    depth_cue: Union[bool, float, str]
    legend: bool
    scale_bar: bool
    unit: str
    time_stamp: bool
    cell: bool
    text: str
    font_size: float
    width_mm: float
    dpi: float
    labels: bool


class SubmitOptions(PictureOptions, total=False):
    """What is for a farm only."""

    name: str
    priority: int
    max_failures: int
    webhook: str
    progressive: bool


# Those that make the scene; all others are handed on by their names.
OF_PORTRAIT = ("frame", "topology", "alternatives", "select", "slice", "hide", "color_by", "colormap", "range", "view",
               "style", "projection")  # fmt: skip
OF_SCENE = ("elements", "camera", "sky", "material", *OF_PORTRAIT)

_DRAWN = ("outline", "depth_cue", "legend", "scale_bar", "unit", "time_stamp", "cell", "text", "font_size", "width_mm",
          "dpi")  # fmt: skip
_FLAGS = ("denoise", "legend", "scale_bar", "time_stamp", "cell")
_RENAMED = {"opaque": "transparent=False", "no_labels": "labels=False"}

_Function = TypeVar("_Function", bound=Callable[..., Any])


def shows_keywords(options: type) -> Callable[[_Function], _Function]:
    """`help` and completion of the function show these names where its signature says **options."""
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
    """What makes the scene, and the rest; None is as good as not given. TypeError for a name that is no option."""
    known = names_of(options)
    for name in given:
        if name in _RENAMED:
            raise TypeError(f"{name} is now {_RENAMED[name]}")
        if name not in known:
            near = difflib.get_close_matches(name, known, 1)
            hint = f"did you mean {near[0]}?" if near else f"known are {', '.join(known)}"
            raise TypeError(f"no option {name!r}: {hint}")
    asked = {name: value for name, value in given.items() if value is not None}
    scene = {name: asked.pop(name) for name in OF_SCENE if name in asked}
    return scene, asked


def is_drawn_on(options: Mapping[str, Any]) -> bool:
    """Whether the PNG picture shows more than was traced."""
    return any(options.get(name, False) is not False for name in _DRAWN)


def as_arguments(options: Mapping[str, Any]) -> list[str]:
    """For the command line."""
    arguments = []
    for name, value in options.items():
        option = "--" + name.replace("_", "-")
        if name in _FLAGS:
            arguments += [option] if value else []
        elif isinstance(value, bool):
            arguments += [option, "on" if value else "off"]
        elif isinstance(value, (str, os.PathLike)) or not hasattr(value, "__iter__"):
            arguments += [option, os.fspath(value) if isinstance(value, os.PathLike) else str(value)]
        else:
            arguments += [option, (":" if name == "range" else ",").join(map(str, value))]
    return arguments

"""Colours by name. Without matplotlib, only the basic names of CSS, orange and the tab colours work."""

from __future__ import annotations

import importlib.util
import re
from typing import Any

import numpy as np
import numpy.typing as npt

from .errors import InputError
from .srgb import srgb_to_linear

# The 16 basic colours and orange (https://www.w3.org/TR/css-color-4/#named-colors), and the tab colours of matplotlib.
_CODES = (
    "black 000000 silver c0c0c0 gray 808080 grey 808080 white ffffff maroon 800000 red ff0000 purple 800080 "
    "fuchsia ff00ff magenta ff00ff green 008000 lime 00ff00 olive 808000 yellow ffff00 navy 000080 blue 0000ff "
    "teal 008080 aqua 00ffff cyan 00ffff orange ffa500 tab:blue 1f77b4 tab:orange ff7f0e tab:green 2ca02c tab:red d62728 "
    "tab:purple 9467bd tab:brown 8c564b tab:pink e377c2 tab:gray 7f7f7f tab:grey 7f7f7f tab:olive bcbd22 tab:cyan 17becf"
).split()
_NAMES = dict(zip(_CODES[::2], _CODES[1::2]))


def linear_of_names(names: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
    """Returns linear RGB for names of colours. The array has the shape of `names` and one more axis: (3,) for one name."""
    distinct, which = np.unique(np.asarray(names).astype(np.str_), return_inverse=True)
    encoded = np.array([_srgb(name) for name in distinct.tolist()])
    return srgb_to_linear(encoded)[which.reshape(np.shape(names))]


def _srgb(name: str) -> tuple[float, float, float]:
    """Returns sRGB from 0 to 1. Raises InputError for a name that is not known."""
    code = _NAMES.get(name.strip().lower(), name.strip().lstrip("#"))
    if re.fullmatch(r"[0-9a-fA-F]{6}", code) and (name.startswith("#") or code != name):
        red, green, blue = (int(code[i : i + 2], 16) / 255 for i in (0, 2, 4))
        return red, green, blue
    if importlib.util.find_spec("matplotlib") is None:
        known = ", ".join(_NAMES)
        raise InputError(f"colors: unknown colour {name!r}: use '#rrggbb' or {known}; matplotlib knows more names")
    from matplotlib.colors import to_rgb

    try:
        red, green, blue = to_rgb(name)
    except ValueError as error:
        raise InputError(f"colors: unknown colour {name!r}: use a name of matplotlib, or '#rrggbb'") from error
    return red, green, blue

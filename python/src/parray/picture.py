"""A picture: a numpy array that knows its error and its report."""

from __future__ import annotations

import base64
import hashlib
import html
import os
from pathlib import Path
from typing import Any, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from .errors import InputError
from .exr import Attribute, read_exr
from .srgb import as_texts, png_bytes, srgb_bytes, transparent_bytes


class Error(NamedTuple):
    """How far a picture is from the one that endless samples would give: root mean square over pixels and channels,
    linear radiance; from `low` to `high` with a probability of 95 %."""

    rmse: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.rmse:.3g} ({self.low:.3g} to {self.high:.3g})"

    @classmethod
    def of(cls, figures: Any) -> Optional[Error]:
        """Of a report, or of a job; None: not known."""
        try:
            return cls(*(float(figures[name]) for name in cls._fields))
        except (TypeError, KeyError):
            return None


class Picture:
    """What is rendered, or as much of it as there is. numpy takes it for the array `pixels`."""

    pixels: npt.NDArray[np.float32]
    """Linear RGB, (height, width, 3), top row first; of a transparent picture premultiplied, and channel "A" its
    alpha."""
    channels: dict[str, npt.NDArray[Any]]
    """What was asked for with `aov`, and others beside R, G and B, by their names in an EXR file."""
    report: dict[str, Any]
    """What was done, how fast and with which bits: the members of `--report`; empty of an unfinished job."""
    recipe: dict[str, Attribute]
    """All that decides the bits, as the file has it (`parray:...`); `parray verify` looks at it."""

    def __init__(self, exr: bytes, report: dict[str, Any], png: Optional[bytes] = None) -> None:
        """`png`: the file to show and save, where more is drawn on it than the pixels have."""
        channels, attributes = read_exr(exr)
        self.pixels = np.stack([channels.pop(name) for name in "RGB"], axis=-1)
        self.channels = channels
        self.report = report
        self.recipe = {name: value for name, value in attributes.items() if name.startswith("parray:")}
        self._exr = exr
        self._png = png

    @property
    def error(self) -> Optional[Error]:
        """The error of these pixels, of a denoised picture what is left of it; None where it is not known: with fewer
        than two samples a pixel, or of an unfinished job."""
        return Error.of(self.report.get("denoised", self.report.get("error")))

    @property
    def shape(self) -> tuple[int, int, int]:
        height, width, _ = self.pixels.shape
        return height, width, 3

    def __array__(self, dtype: Optional[npt.DTypeLike] = None, copy: Optional[bool] = None) -> npt.NDArray[Any]:
        if copy is False and dtype is not None and np.dtype(dtype) != self.pixels.dtype:
            raise ValueError("another type needs a copy")
        return np.array(self.pixels, dtype) if copy else np.asarray(self.pixels, dtype)

    def srgb(self) -> npt.NDArray[np.uint8]:
        """As screens show it: 8-bit sRGB, (height, width, 3), of a transparent picture with alpha, (height, width, 4).
        For matplotlib's `imshow`, too. Without what is drawn on a PNG file."""
        if "A" in self.channels:
            return transparent_bytes(self.pixels, self.channels["A"])
        return srgb_bytes(self.pixels)

    def save(self, file: Union[str, os.PathLike[str]]) -> None:
        """Writes it as EXR (the very floats, all channels) or PNG (`srgb()`, and what is drawn on it, such as a legend),
        both with the recipe, or as NPY (`pixels`), by the extension."""
        path = Path(file)
        extension = path.suffix.lower()
        if extension == ".npy":
            np.save(path, self.pixels)
        elif extension in (".exr", ".png"):
            path.write_bytes(self._exr if extension == ".exr" else self._repr_png_())
        else:
            raise InputError(f"{path}: pictures are .exr, .png or .npy: change its extension")

    def _repr_png_(self) -> bytes:
        if self._png is not None:
            return self._png
        pixels = self.srgb()
        digest = hashlib.sha256(pixels.tobytes()).hexdigest()
        recipe = as_texts({**self.recipe, "parray:pixels_sha256": digest}) if self.recipe else {}
        return png_bytes(pixels, recipe)

    def _repr_html_(self) -> str:
        image = base64.b64encode(self._repr_png_()).decode()
        caption = html.escape(repr(self)[1:-1])
        return f'<figure><img src="data:image/png;base64,{image}" alt="{caption}"><figcaption>{caption}</figcaption></figure>'

    def __repr__(self) -> str:
        height, width, _ = self.shape
        error = f"error {self.error}" if self.error else "error not known"
        return f"<Picture {width} x {height}, {error}>"

"""A picture: a numpy array with its error and its report."""

from __future__ import annotations

import base64
import hashlib
import html
import os
import re
from pathlib import Path
from typing import Any, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from .errors import InputError
from .exr import Attribute, read_exr
from .picture_files import save_png_as
from .srgb import as_texts, png_bytes, srgb_bytes, transparent_bytes


class Error(NamedTuple):
    """The difference between a picture and the picture of infinitely many samples: root mean square over pixels and
    channels, in linear radiance. `low` and `high` are its 95 % confidence interval."""

    rmse: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.rmse:.3g} ({self.low:.3g} to {self.high:.3g})"

    @classmethod
    def of(cls, figures: Any) -> Optional[Error]:
        """Returns the error in a report or a job. Returns None if it is not known."""
        try:
            return cls(*(float(figures[name]) for name in cls._fields))
        except (TypeError, KeyError):
            return None


class Picture:
    """A finished or unfinished picture. numpy uses it as the array `pixels`."""

    pixels: npt.NDArray[np.float32]
    """Linear RGB, (height, width, 3), top row first. Transparent pictures are premultiplied, and channel "A" is alpha."""
    channels: dict[str, npt.NDArray[Any]]
    """The channels other than R, G and B, such as those of `aov`, by their names in an EXR file."""
    report: dict[str, Any]
    """The members of `--report`: settings, speed, hashes and more. For an unfinished job it has only `error`."""
    recipe: dict[str, Attribute]
    """All values that determine the bits, as in the file (`parray:...`). `parray verify` checks them."""

    def __init__(self, exr: bytes, report: dict[str, Any], png: Optional[bytes] = None) -> None:
        """`exr` and `png` are the bytes of files. `png`: the picture with labels or postprocessing, to show and save. None:
        it is made from the pixels."""
        channels, attributes = read_exr(exr)
        self.pixels = np.stack([channels.pop(name) for name in "RGB"], axis=-1)
        self.channels = channels
        self.report = report
        self.recipe = {name: value for name, value in attributes.items() if name.startswith("parray:")}
        self._exr = exr
        self._png = png

    @property
    def error(self) -> Optional[Error]:
        """The error of the pixels; that of a denoised picture is the error after denoising. None if it is not known, as with
        fewer than two samples per pixel. An unfinished job may have an error, too."""
        return Error.of(self.report.get("denoised", self.report.get("error")))

    @property
    def shape(self) -> tuple[int, int, int]:
        height, width, _ = self.pixels.shape
        return height, width, 3

    def __array__(self, dtype: Optional[npt.DTypeLike] = None, copy: Optional[bool] = None) -> npt.NDArray[Any]:
        if copy is False and dtype is not None and np.dtype(dtype) != self.pixels.dtype:
            raise ValueError("another type needs a copy: do not pass copy=False")
        return np.array(self.pixels, dtype) if copy else np.asarray(self.pixels, dtype)

    def srgb(self) -> npt.NDArray[np.uint8]:
        """Returns 8-bit sRGB, (height, width, 3), for screens and matplotlib's `imshow`. For a transparent picture, returns
        sRGB and alpha, (height, width, 4). Contains no labels and no postprocessing."""
        if "A" in self.channels:
            return transparent_bytes(self.pixels, self.channels["A"])
        return srgb_bytes(self.pixels)

    def save(self, file: Union[str, os.PathLike[str]]) -> None:
        """Writes the picture in the format of the extension: EXR (the exact floats, all channels), PNG (`srgb()` with
        labels and postprocessing), NPY (`pixels`), or PDF, JPEG, TIFF, WebP and others with the pixels of the PNG. JPEG,
        TIFF and others need Pillow. EXR and PNG contain the recipe."""
        path = Path(file)
        extension = path.suffix.lower()
        if extension == ".npy":
            np.save(path, self.pixels)
        elif extension in (".exr", ".png"):
            path.write_bytes(self._exr if extension == ".exr" else self._repr_png_())
        else:
            save_png_as(self._repr_png_(), path)

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


class Pictures(list[Picture]):
    """A list of pictures. A notebook shows them side by side."""

    def save(self, files: Union[str, os.PathLike[str]]) -> None:
        """Writes each picture as Picture.save() does. The name has a "#" for each digit of the picture's place: "a-####.png"."""
        path = Path(files)
        if "#" not in path.name:
            raise InputError(f"{path}: the name has no place for numbers: write for example {path.stem}-####{path.suffix}")
        for number, picture in enumerate(self):
            picture.save(path.with_name(re.sub("#+", lambda place: str(number).zfill(len(place[0])), path.name)))

    def _repr_html_(self) -> str:
        return f'<div style="display: flex; flex-wrap: wrap">{"".join(picture._repr_html_() for picture in self)}</div>'

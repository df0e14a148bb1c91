"""The sRGB transfer curve (IEC 61966-2-1), and PNG files, whose 8-bit values use it."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt


def srgb_to_linear(encoded: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Returns linear values for sRGB values, both from 0 to 1. Use it to pass colours of matplotlib or OVITO as `colors`."""
    values = np.asarray(encoded, np.float64)
    return np.where(values <= 0.04045, values / 12.92, ((np.maximum(values, 0.04045) + 0.055) / 1.055) ** 2.4)


def srgb_bytes(linear: npt.ArrayLike) -> npt.NDArray[np.uint8]:
    """Returns the 8-bit codes of linear values, clamped to [0, 1] and rounded to nearest; 0 for NaN. They equal the bytes
    in the PNG files of `parray`."""
    values = np.asarray(linear, np.float64)
    values = np.where(values > 0, np.minimum(values, 1), 0)
    encoded = np.where(values <= 0.0031308, 12.92 * values, 1.055 * values ** (1 / 2.4) - 0.055)
    return np.floor(255 * encoded + 0.5).astype(np.uint8)


def transparent_bytes(premultiplied: npt.ArrayLike, alpha: npt.ArrayLike) -> npt.NDArray[np.uint8]:
    """Does the same for a transparent picture: (height, width, 4) with colours that are not premultiplied, and alpha, as in
    PNG. Colours are 0 where the code of alpha is 0."""
    share = np.asarray(alpha, np.float64)[..., np.newaxis]
    code = np.floor(255 * np.clip(share, 0, 1) + 0.5).astype(np.uint8)
    colours = srgb_bytes(np.asarray(premultiplied, np.float64) / np.where(share > 0, share, 1))
    return np.concatenate([np.where(code > 0, colours, 0).astype(np.uint8), code], axis=-1)


def png_bytes(pixels: npt.NDArray[np.uint8], texts: Mapping[str, str]) -> bytes:
    """Returns a PNG file of 8-bit RGB values, (height, width, 3), or RGBA, (height, width, 4), with `texts` as metadata."""
    height, width, size = pixels.shape
    rows = np.zeros((height, 1 + size * width), np.uint8)  # each row begins with the number of its filter: 1, sub
    rows[:, 0] = 1
    rows[:, 1 : 1 + size] = pixels[:, 0]
    rows[:, 1 + size :] = (pixels[:, 1:] - pixels[:, :-1]).reshape(height, -1)
    return b"".join(
        [
            b"\x89PNG\r\n\x1a\n",
            _chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, {3: 2, 4: 6}[size], 0, 0, 0)),
            _chunk(b"sRGB", b"\0"),
            *(_chunk(b"iTXt", key.encode() + bytes(5) + text.encode()) for key, text in texts.items()),
            _chunk(b"IDAT", zlib.compress(rows.tobytes(), 1)),
            _chunk(b"IEND", b""),
        ]
    )


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def as_texts(values: Mapping[str, Any]) -> dict[str, str]:
    """Returns numbers as texts for PNG: whole numbers without a decimal point."""
    return {
        key: str(int(value)) if isinstance(value, float) and value.is_integer() else str(value)
        for key, value in values.items()
    }

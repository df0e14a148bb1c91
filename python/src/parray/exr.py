"""Reads the EXR files of ParRay: one part of scan lines with 32-bit channels, without compression or with zip.

Format: https://openexr.com/en/latest/OpenEXRFileLayout.html
"""

from __future__ import annotations

import struct
import zlib
from typing import Any, Union

import numpy as np
import numpy.typing as npt

Attribute = Union[str, int, float]
Channels = dict[str, npt.NDArray[Any]]

_MAGIC = b"\x76\x2f\x31\x01"
_NUMBERS = {b"int": "<i", b"float": "<f", b"double": "<d"}
_TYPES = {0: np.dtype("<u4"), 2: np.dtype("<f4")}  # UINT, FLOAT
_BLOCK_ROWS = {0: 1, 2: 1, 3: 16}  # none, ZIPS, ZIP


def read_exr(data: bytes) -> tuple[Channels, dict[str, Attribute]]:
    """Returns every channel as an array of (height, width), and the attributes that are a text or a single number.

    Raises ValueError for other files and other kinds of EXR files.
    """
    try:
        return _read(data)
    except (struct.error, zlib.error, IndexError, KeyError) as error:
        raise ValueError(f"the EXR file is damaged, or its kind is not supported ({error!r})") from error


def _read(data: bytes) -> tuple[Channels, dict[str, Attribute]]:
    if data[:4] != _MAGIC:
        raise ValueError("the data are not an EXR file")
    if data[5:8] != b"\0\0\0":
        raise ValueError("the EXR file has tiles, several parts, deep data or long names, which are not supported")
    header, at = _header(data, 8)
    left, top, right, bottom = struct.unpack("<4i", header["dataWindow"][1])
    width, height = right - left + 1, bottom - top + 1
    rows_of_block = _BLOCK_ROWS[header["compression"][1][0]]
    # Each row stores its channels one after the other.
    row = np.dtype([(name, kind, (width,)) for name, kind in _channel_list(header["channels"][1])])
    pixels = np.empty(height, row)
    for (offset,) in struct.iter_unpack("<Q", data[at : at + 8 * -(-height // rows_of_block)]):
        y, size = struct.unpack_from("<2i", data, offset)
        rows = pixels[y - top : y - top + rows_of_block]
        block = data[offset + 8 : offset + 8 + size]
        rows[:] = np.frombuffer(_unpacked(block, rows.nbytes), row)
    return {name: pixels[name] for name in row.names or ()}, _values(header)


def _header(data: bytes, at: int) -> tuple[dict[str, tuple[bytes, bytes]], int]:
    """Returns type and bytes of each attribute by name, and the end of the header."""
    found = {}
    while data[at]:
        name_end = data.index(b"\0", at)
        type_end = data.index(b"\0", name_end + 1)
        (size,) = struct.unpack_from("<i", data, type_end + 1)
        value = type_end + 5
        found[data[at:name_end].decode()] = data[name_end + 1 : type_end], data[value : value + size]
        at = value + size
    return found, at + 1


def _channel_list(data: bytes) -> list[tuple[str, np.dtype[Any]]]:
    found, at = [], 0
    while data[at]:
        end = data.index(b"\0", at)
        found.append((data[at:end].decode(), _TYPES[struct.unpack_from("<i", data, end + 1)[0]]))
        at = end + 17
    return found


def _values(header: dict[str, tuple[bytes, bytes]]) -> dict[str, Attribute]:
    values: dict[str, Attribute] = {}
    for name, (kind, value) in header.items():
        if kind in _NUMBERS:
            (values[name],) = struct.unpack(_NUMBERS[kind], value)
        elif kind == b"string":
            values[name] = value.decode("utf-8", "replace")
    return values


def _unpacked(block: bytes, size: int) -> bytes:
    """Zip stores differences of bytes, first those of all even bytes, then those of all odd bytes. A block that would
    not become smaller is not compressed."""
    if len(block) == size:
        return block
    differences = np.frombuffer(zlib.decompress(block), np.uint8).copy()
    differences[1:] -= 128  # modulo 256, as the sum
    summed = np.add.accumulate(differences, dtype=np.uint8)
    out = np.empty_like(summed)
    half = (summed.size + 1) // 2
    out[0::2], out[1::2] = summed[:half], summed[half:]
    return out.tobytes()

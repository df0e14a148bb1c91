"""A reader of the EXR files that parray writes (one part, scan lines, zip), for tests: written from
the file layout, so that what is read is not what the same library has written."""

import struct
import zlib

TYPES = {0: "I", 2: "f"}  # UINT, FLOAT: four bytes each
ZIP = 3
BLOCK_ROWS = 16


def _attributes(data, at):
    """Name -> bytes, and where the header ends."""
    found = {}
    while data[at]:
        name, type_name = data[at:].split(b"\0", 2)[:2]
        at += len(name) + len(type_name) + 2
        size, = struct.unpack_from("<i", data, at)
        found[name.decode()] = data[at + 4:at + 4 + size]
        at += 4 + size
    return found, at + 1


def _channels(data):
    """Names with struct's letter for the type, in the file's order."""
    found = []
    while data[0]:
        name, data = data.split(b"\0", 1)
        found.append((name.decode(), TYPES[struct.unpack_from("<i", data)[0]]))
        data = data[16:]
    return found


def _unpacked(data, size):
    """A zip block: bytes as differences, first all even ones, then all odd ones."""
    if len(data) == size:
        return data
    data = bytearray(zlib.decompress(data))
    for i in range(1, len(data)):
        data[i] = (data[i - 1] + data[i] - 128) & 255
    out = bytearray(len(data))
    half = (len(data) + 1) // 2
    out[0::2], out[1::2] = data[:half], data[half:]
    return bytes(out)


def read_exr(path):
    """Name of a channel -> its values, pixel by pixel, top row first; and its type's letter."""
    data = path.read_bytes()
    assert data[:8] == bytes([0x76, 0x2F, 0x31, 0x01, 2, 0, 0, 0]), "not a plain EXR file"
    header, at = _attributes(data, 8)
    left, top, right, bottom = struct.unpack("<4i", header["dataWindow"])
    assert (left, top) == (0, 0) and header["compression"][0] == ZIP
    width, height = right + 1, bottom + 1
    channels = _channels(header["channels"])
    values = {name: [] for name, _ in channels}
    for offset in struct.unpack_from(f"<{-(-height // BLOCK_ROWS)}Q", data, at):
        y, size = struct.unpack_from("<2i", data, offset)
        rows = min(BLOCK_ROWS, height - y)
        block = _unpacked(data[offset + 8:offset + 8 + size], rows * width * 4 * len(channels))
        place = 0
        for _ in range(rows):
            for name, letter in channels:
                values[name] += struct.unpack_from(f"<{width}{letter}", block, place)
                place += 4 * width
    return values, dict(channels)

"""A reader of the EXR files that parray writes (one part, scan lines, zip), and a forger, for tests:
written from the file layout, so that what is read is not what the same library has written."""

import struct
import zlib

TYPES = {0: "I", 2: "f"}  # UINT, FLOAT: four bytes each
ZIP = 3
BLOCK_ROWS = 16


MAGIC = bytes([0x76, 0x2F, 0x31, 0x01, 2, 0, 0, 0])
NUMBERS = {b"int": "<i", b"float": "<f", b"double": "<d"}


def _attributes(data, at):
    """Name -> type and bytes, and where the header ends."""
    found = {}
    while data[at]:
        name, type_name = data[at:].split(b"\0", 2)[:2]
        at += len(name) + len(type_name) + 2
        size, = struct.unpack_from("<i", data, at)
        found[name.decode()] = type_name, data[at + 4:at + 4 + size]
        at += 4 + size
    return found, at + 1


def read_attributes(path):
    """Name -> value, of single numbers and text."""
    found, _ = _attributes(path.read_bytes(), len(MAGIC))
    values = {}
    for name, (kind, value) in found.items():
        if kind in NUMBERS:
            values[name], = struct.unpack(NUMBERS[kind], value)
        elif kind == b"string":
            values[name] = value.decode()
    return values


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


def _layout(data):
    """Size in pixels, the channels, and where the table of blocks begins."""
    assert data[:8] == MAGIC, "not a plain EXR file"
    header, at = _attributes(data, len(MAGIC))
    left, top, right, bottom = struct.unpack("<4i", header["dataWindow"][1])
    assert (left, top) == (0, 0) and header["compression"][1][0] == ZIP
    return right + 1, bottom + 1, _channels(header["channels"][1]), at


def read_exr(path):
    """Name of a channel -> its values, pixel by pixel, top row first; and its type's letter."""
    data = path.read_bytes()
    width, height, channels, at = _layout(data)
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


def forge_exr(path, forged, change, texts=lambda values: {}):
    """Writes a copy whose channels' values `change` has had in its hands, and then the attributes,
    text of the same length, that `texts` names for them."""
    data = bytearray(path.read_bytes())
    width, height, channels, at = _layout(data)
    values, _ = read_exr(path)
    change(values)
    attributes, _ = _attributes(data, len(MAGIC))
    for name, value in texts(values).items():
        before = attributes[name][1]
        assert data.count(before) == 1 and len(value) == len(before)
        place = data.find(before)
        data[place:place + len(before)] = value.encode()
    tops = range(0, height, BLOCK_ROWS)
    offsets, blocks = [], b""
    for top in tops:
        block = b"".join(struct.pack(f"<{width}{letter}", *values[name][y * width:(y + 1) * width])
                         for y in range(top, min(top + BLOCK_ROWS, height))
                         for name, letter in channels)
        offsets.append(at + 8 * len(tops) + len(blocks))
        blocks += struct.pack("<2i", top, len(block)) + block  # as large as unpacked: not packed
    forged.write_bytes(data[:at] + struct.pack(f"<{len(offsets)}Q", *offsets) + blocks)


def rgb_bytes(values):
    """What image_sha256 is the hash of."""
    pixels = zip(values["R"], values["G"], values["B"])
    return b"".join(struct.pack("<3f", *pixel) for pixel in pixels)

"""A reader and writer of the PNG files that parray writes (8-bit RGB or RGBA), for tests: written from the
file layout, so that what is read is not what the same library has written."""

import struct
import zlib

SIGNATURE = b"\x89PNG\r\n\x1a\n"


def read_chunks(path):
    """[type, contents] of every chunk."""
    data = path.read_bytes()
    assert data[:8] == SIGNATURE
    chunks = []
    at = 8
    while at < len(data):
        size, = struct.unpack_from(">I", data, at)
        body = data[at + 4:at + 8 + size]
        assert struct.unpack_from(">I", data, at + 8 + size) == (zlib.crc32(body),)
        chunks.append([body[:4], body[4:]])
        at += 12 + size
    return chunks


def read_text(path):
    """Name -> value of the text chunks."""
    texts = [contents.split(b"\0", 1) for kind, contents in read_chunks(path) if kind == b"tEXt"]
    return {name.decode(): value.decode("latin-1") for name, value in texts}


def _predicted(kind, left, up, corner):
    if kind < 4:
        return [0, left, up, (left + up) // 2][kind]
    estimate = left + up - corner
    return min((left, up, corner), key=lambda value: abs(estimate - value))


def _unfiltered(data, stride, size=3):
    """Rows one after the other, without their filters; a pixel has `size` bytes."""
    above = bytearray(stride)
    rows = bytearray()
    for at in range(0, len(data), stride + 1):
        row = bytearray(data[at + 1:at + 1 + stride])
        for i in range(stride):
            left, corner = (row[i - size], above[i - size]) if i >= size else (0, 0)
            row[i] = (row[i] + _predicted(data[at], left, above[i], corner)) & 255
        rows += row
        above = row
    return rows


def read_rgba(path):
    """The bytes of every pixel of a picture with alpha, top row first."""
    chunks = read_chunks(path)
    width, height, depth, colour = struct.unpack_from(">2I2B", chunks[0][1])
    assert (depth, colour) == (8, 6), "not 8-bit RGBA"
    packed = b"".join(contents for kind, contents in chunks if kind == b"IDAT")
    pixels = _unfiltered(zlib.decompress(packed), 4 * width, 4)
    assert len(pixels) == 4 * width * height
    return [tuple(pixels[i:i + 4]) for i in range(0, len(pixels), 4)]


def forge_png(path, forged, change, texts=lambda pixels: {}):
    """Writes a copy whose bytes, top row first, `change` has had in its hands, and then the text
    chunks that `texts` names for them."""
    chunks = read_chunks(path)
    width, height = struct.unpack_from(">2I", chunks[0][1])
    packed = b"".join(contents for kind, contents in chunks if kind == b"IDAT")
    pixels = _unfiltered(zlib.decompress(packed), 3 * width)
    change(pixels)
    rows = b"".join(b"\0" + pixels[3 * width * y:3 * width * (y + 1)] for y in range(height))
    new_texts = texts(bytes(pixels))
    out = bytearray(SIGNATURE)
    for kind, contents in [chunk for chunk in chunks if chunk[0] not in (b"IDAT", b"IEND")] + [
            [b"IDAT", zlib.compress(rows)], [b"IEND", b""]]:
        if kind == b"tEXt":
            name = contents.split(b"\0", 1)[0].decode()
            contents = f"{name}\0{new_texts[name]}".encode() if name in new_texts else contents
        body = kind + contents
        out += struct.pack(">I", len(contents)) + body + struct.pack(">I", zlib.crc32(body))
    forged.write_bytes(out)


def read_rgb(path):
    """Width, height and the bytes of every pixel, top row first."""
    chunks = read_chunks(path)
    width, height, depth, colour = struct.unpack_from(">2I2B", chunks[0][1])
    assert (depth, colour) == (8, 2), "not 8-bit RGB"
    packed = b"".join(contents for kind, contents in chunks if kind == b"IDAT")
    return width, height, bytes(_unfiltered(zlib.decompress(packed), 3 * width))

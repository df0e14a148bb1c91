"""The parts of the wire format that a proxy needs: ZMTP 3 frames without encryption (https://rfc.zeromq.org/spec/23), and
numbers in a control frame (MessagePack, https://github.com/msgpack/msgpack)."""

import ctypes
import struct

GREETING_BYTES = 64
MORE, LONG, COMMAND = 1, 2, 4  # flags of a frame


async def read_frame(reader):
    """Returns (flags, body) of the next frame. Raises asyncio.IncompleteReadError at the stream's end."""
    flags = (await reader.readexactly(1))[0]
    size = struct.unpack(">Q", await reader.readexactly(8))[0] if flags & LONG else (await reader.readexactly(1))[0]
    return flags, await reader.readexactly(size)


async def read_message(reader):
    """Returns (command, frames): a command has one frame, a message one or more."""
    flags, body = await read_frame(reader)
    frames = [body]
    while flags & MORE:
        flags, body = await read_frame(reader)
        frames.append(body)
    return bool(flags & COMMAND), frames


def encode_message(command, frames):
    parts = []
    for i, body in enumerate(frames):
        flags = (COMMAND if command else 0) | (MORE if i + 1 < len(frames) else 0)
        if len(body) > 255:
            parts.append(struct.pack(">BQ", flags | LONG, len(body)))
        else:
            parts.append(bytes((flags, len(body))))
        parts.append(body)
    return b"".join(parts)


def _fixstr(text):
    return bytes((0xA0 | len(text),)) + text.encode()


def message_type(control):
    """Returns `type` of a control frame, or None."""
    at = control.find(_fixstr("type"))
    if at < 0 or at + 5 >= len(control) or control[at + 5] & 0xE0 != 0xA0:
        return None
    return control[at + 6:at + 6 + (control[at + 5] & 0x1F)].decode(errors="replace")


def has_word(control, word):
    """Returns whether a string of the control frame is `word` (shorter than 32 letters)."""
    return _fixstr(word) in control


def with_number(control, key, value):
    """Returns the control frame with another unsigned number for the existing `key` (shorter than 32 letters)."""
    at = control.index(_fixstr(key)) + 1 + len(key)
    length = {0xCC: 1, 0xCD: 2, 0xCE: 4, 0xCF: 8}.get(control[at], 0)
    if length == 0 and control[at] > 0x7F:
        raise ValueError(f"{key} is no unsigned number")
    return control[:at] + b"\xcf" + struct.pack(">Q", value) + control[at + 1 + length:]


def xxh3(data):
    """Returns the XXH3-64, the checksum of bulk frames."""
    library = ctypes.CDLL("libxxhash.so.0")
    library.XXH3_64bits.restype = ctypes.c_uint64
    library.XXH3_64bits.argtypes = [ctypes.c_char_p, ctypes.c_size_t]
    return library.XXH3_64bits(data, len(data))

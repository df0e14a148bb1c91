"""Workers that are not what they seem: honest ones whose messages a proxy rewrites."""

import random
import struct

import wire

HEADER_BYTES = 24  # rays, non-finite samples and lost throughput of a cell
COLUMNS = 9
SQUARES_LEFT_OUT, ODD_LEFT_OUT, HAS_BASE = 1, 2, 128


def lied(cells):
    """The cells of a result with a little less light in the first pixel, and numbers that are all still possible
    (common/image/packed_sums.h); None where that cannot be done."""
    at = HEADER_BYTES + 1
    flags = cells[HEADER_BYTES]
    widths = []
    for column in range(COLUMNS):
        if (column // 3 == 1 and flags & SQUARES_LEFT_OUT) or (column // 3 == 2 and flags & ODD_LEFT_OUT):
            continue
        widths.append(cells[at] & ~HAS_BASE)
        at += 9 if cells[at] & HAS_BASE else 1
    # The first record begins with the red sum. A bit far from its highest, so that widths stay what they are.
    word = int.from_bytes(cells[at:at + 8], "little")
    bit = next((bit for bit in range(widths[0] - 6, widths[0] - 16, -1) if bit > 0 and word >> bit & 1), None)
    if bit is None:
        return None
    word ^= 1 << bit
    return cells[:at] + struct.pack("<Q", word)[:len(cells[at:at + 8])] + cells[at + 8:]


class Liar:
    """Rewrites a share of a worker's results: the same one always alike, however often it is sent."""

    def __init__(self, seed, share):
        self.seed = seed
        self.share = share
        self.lies = set()  # checksums of what was changed
        self.results = set()

    def __call__(self, up, frames):
        if not up or wire.message_type(frames[0]) != "result":
            return frames
        control, cells = frames
        name = wire.xxh3(cells)
        self.results.add(name)
        if random.Random(f"{self.seed} {name}").random() >= self.share:
            return frames
        other = lied(cells)
        if other is None:
            return frames
        self.lies.add(name)
        return [wire.with_number(control, "bulk_xxh3", wire.xxh3(other)), other]


def of_another_release(up, frames):
    """Rewrites a worker's greeting: its pictures are of another trace version."""
    if up and wire.message_type(frames[0]) == "hello":
        return [wire.with_number(frames[0], "trace_version", 1000000), *frames[1:]]
    return frames

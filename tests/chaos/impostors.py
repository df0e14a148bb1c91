"""Makes correct workers faulty: a proxy rewrites their messages."""

import random
import struct

import wire

HEADER_BYTES = 24  # rays, non-finite samples and lost throughput of a cell
COLUMNS = 9
SQUARES_LEFT_OUT, ODD_LEFT_OUT, HAS_BASE = 1, 2, 128


def falsified(cells):
    """Returns the cells of a result with a little less light in the first pixel. All numbers remain possible
(common/image/packed_sums.h). Returns None if that is impossible."""
    at = HEADER_BYTES + 1
    flags = cells[HEADER_BYTES]
    widths = []
    for column in range(COLUMNS):
        if (column // 3 == 1 and flags & SQUARES_LEFT_OUT) or (column // 3 == 2 and flags & ODD_LEFT_OUT):
            continue
        widths.append(cells[at] & ~HAS_BASE)
        at += 9 if cells[at] & HAS_BASE else 1
    # The first record begins with the red sum. Changes a bit far below its highest one, so that widths do not change.
    word = int.from_bytes(cells[at:at + 8], "little")
    bit = next((bit for bit in range(widths[0] - 6, widths[0] - 16, -1) if bit > 0 and word >> bit & 1), None)
    if bit is None:
        return None
    word ^= 1 << bit
    return cells[:at] + struct.pack("<Q", word)[:len(cells[at:at + 8])] + cells[at + 8:]


class FaultyWorker:
    """Falsifies a share of a worker's results, in the same way each time that a result is sent."""

    def __init__(self, seed, share):
        self.seed = seed
        self.share = share
        self.wrong = set()  # checksums of the falsified results
        self.results = set()
        self.merged = 0  # results that the coordinator has used, or compared with others

    def __call__(self, up, frames):
        if not up and wire.message_type(frames[0]) == "verdict":
            self.merged += wire.has_word(frames[0], "accepted") or wire.has_word(frames[0], "mismatch")
        if not up or wire.message_type(frames[0]) != "result":
            return frames
        control, cells = frames
        name = wire.xxh3(cells)
        self.results.add(name)
        if random.Random(f"{self.seed} {name}").random() >= self.share:
            return frames
        other = falsified(cells)
        if other is None:
            return frames
        self.wrong.add(name)
        return [wire.with_number(control, "bulk_xxh3", wire.xxh3(other)), other]


def of_another_release(up, frames):
    """Rewrites a worker's `hello` to another trace version."""
    if up and wire.message_type(frames[0]) == "hello":
        return [wire.with_number(frames[0], "trace_version", 1000000), *frames[1:]]
    return frames

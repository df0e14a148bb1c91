"""Compares the facts of ParRay about a file with those of the programs of the field."""

import dataclasses

import atoms

# Keys of notes about atoms of the file that are not read as particles. Particles that are hidden later do count.
LEFT_OUT = ("alternatives", "duplicates", "unplaced", "left_out", "sites_merged")
KEPT = ("virtual", "hidden_virtual", "unknown_elements")
GUESSED = ("guessed_elements", "unknown_elements", "mended_elements", "beads")
COPIES = ("boundary_copies",)
WITHOUT_BONDS = ("left_out_bonds", "alternatives")
UNKNOWN = "unknown"
EMPTY_FRAMES = ("empty_frames", "unreadable_frames")
EXPLAINING = (*LEFT_OUT, *KEPT, *GUESSED, *EMPTY_FRAMES)


@dataclasses.dataclass
class Said:
    """The facts of `parray validate --json` about a particle file."""
    particles: int
    box: list
    elements: dict = None  # count by symbol; "": unknown
    frames: int = None
    cell: list = None      # a, b, c, alpha, beta, gamma
    notes: dict = None     # count by key
    atoms: tuple = None    # positions and symbols, as from atoms.Converter
    copies: int = None     # spheres of the default scene beyond the atoms; None: not counted
    format: str = None
    bonds: int = 0

    def noted(self, keys):
        return sum(count for key, count in (self.notes or {}).items() if key.startswith(keys))


def said(facts):
    """Returns the facts in the JSON."""
    file = facts["particle_files"][0]
    elements = file.get("elements")
    if elements is not None:
        elements = {"" if symbol == "unknown" else symbol: count for symbol, count in elements.items()}
    cell = file.get("cell")
    notes = {}
    for note in file.get("notes", []):
        notes[note["key"]] = notes.get(note["key"], 0) + note["count"]
    return Said(file["particles"], [file["box"]["low"], file["box"]["high"]], elements, file.get("frames"),
                cell and cell["lengths"] + cell["angles"], notes, format=file["format"],
                bonds=file.get("bonds", 0))


def close(a, b):
    """Returns whether two numbers agree. Files have three decimals; some programs use single precision."""
    return abs(a - b) <= 2e-3 + 2e-6 * max(abs(a), abs(b))


def same_box(box, other, span_only):
    """Returns whether two boxes agree. With `span_only`, compares only sizes, because the program moves the origin."""
    if span_only:
        return all(close(h - l, oh - ol) for l, h, ol, oh in zip(*box, *other))
    return all(close(x, y) for side, other_side in zip(box, other) for x, y in zip(side, other_side))


def within(box, other):
    return all(x >= y - 2e-3 for x, y in zip(box[0], other[0])) and all(x <= y + 2e-3 for x, y in zip(box[1], other[1]))


def same_cell(cell, other):
    return all(abs(x - y) <= 1e-3 * max(1, abs(y)) for x, y in zip(cell[:3], other[:3])) and all(
        abs(x - y) <= 0.06 for x, y in zip(cell[3:], other[3:]))


def otherwise_named(elements, other):
    """Returns the least number of atoms with different elements."""
    symbols = {*elements, *other}
    more = sum(max(0, elements.get(s, 0) - other.get(s, 0)) for s in symbols)
    return max(more, sum(max(0, other.get(s, 0) - elements.get(s, 0)) for s in symbols))


def compared(said, last, facts):
    """Returns by field: None (equal, or unknown to one of them), or (whether a note explains it, the difference as text).
    The fields "bonds" and "each element" are UNKNOWN if one of them does not know them, which is no agreement."""
    left_out = facts.particles - said.particles
    # A program may leave out particles that ParRay keeps with a note: lone pairs and other virtual sites.
    all_told = said.noted(LEFT_OUT) == left_out if left_out > 0 else 0 < -left_out <= said.noted(KEPT)
    found = dict.fromkeys(("particles", "box", "last box", "elements", "frames", "cell", "copies", "bonds", "places",
                           "each element"))

    def differ(name, told, ours, theirs):
        found[name] = (told, f"{ours}; {facts.program}: {theirs}")

    if left_out:
        differ("particles", all_told, said.particles, facts.particles)
    if not same_box(said.box, facts.box, facts.span_only):
        inside = within(said.box, facts.box) if left_out > 0 else within(facts.box, said.box)
        differ("box", all_told and inside, rounded(said.box), rounded(facts.box))
    if last and facts.last_box and not same_box(last.box, facts.last_box, facts.span_only):
        missing = (facts.last_particles or 0) - last.particles
        differ("last box", 0 < missing == last.noted(LEFT_OUT) and within(last.box, facts.last_box), rounded(last.box), rounded(facts.last_box))
    if facts.elements is not None and said.elements is not None and said.elements != facts.elements:
        others = otherwise_named(said.elements, facts.elements)
        told = others <= said.noted(GUESSED) + (abs(left_out) if all_told else 0)
        differ("elements", told, said.elements, facts.elements)
    elif facts.elements is not None and said.elements is None and set(facts.elements) != {""}:
        differ("elements", said.noted(GUESSED) == said.particles, "none", facts.elements)
    if None not in (facts.frames, said.frames) and facts.frames != said.frames:
        differ("frames", said.frames - said.noted(EMPTY_FRAMES) == facts.frames, said.frames, facts.frames)
    if facts.cell and (not said.cell or not same_cell(said.cell, facts.cell)):
        differ("cell", False, said.cell and [round(x, 3) for x in said.cell], [round(x, 3) for x in facts.cell])
    if said.copies is not None and said.copies != said.noted(COPIES):
        differ("copies", False, f"{said.copies} drawn, {said.noted(COPIES)} in the notes", "none")
    if facts.bonds is None:
        found["bonds"] = UNKNOWN
    elif said.bonds != facts.bonds:
        differ("bonds", said.noted(WITHOUT_BONDS) > 0, said.bonds, facts.bonds)
    if said.atoms is None or facts.atoms is None:
        differ("places", False, "the atoms cannot be compared", "")
        return found
    theirs = facts.atoms if facts.elements is not None else (facts.atoms[0], None)
    misplaced, misnamed = atoms.differences(said.atoms, theirs, facts.span_only)
    if misplaced:
        differ("places", all_told and misplaced <= abs(left_out), f"{misplaced} atoms at other places", "")
    found["each element"] = UNKNOWN if misnamed is None else None
    if misnamed:
        differ("each element", misnamed <= said.noted(GUESSED), f"{misnamed} atoms of other elements", "")
    return found


def knows_elements(said, facts):
    """Returns whether ParRay and one of the programs know elements."""
    return said.atoms[1] is not None and any(f.elements is not None for f in facts)


def rounded(box):
    return [[round(x, 3) for x in side] for side in box]


def verdict(said, last, facts, kind):
    """Returns the verdict, and by field the reason if it is not `same`. A field is right if one program agrees. `kind`: the
    format's name for ParRay; None: any."""
    if said is None:
        return {"verdict": "refused alone" if facts else "refused by both", "why": {}}
    if not facts:
        return {"verdict": "read alone", "why": {}}
    if kind not in (None, said.format):
        return {"verdict": "differs", "why": {"format": f"read as {said.format}, but is {kind}"}}
    found = [compared(said, last, f) for f in facts]
    why = {}
    for name in found[0]:
        known = [f[name] for f in found if f[name] is not UNKNOWN]
        if known and all(known):
            why[name] = known
    untold = any(not any(told for told, _ in differences) for differences in why.values())
    return {"verdict": "differs" if untold else "told" if why else "same",
            "why": {name: " | ".join(words for _, words in differences) for name, differences in why.items()}}

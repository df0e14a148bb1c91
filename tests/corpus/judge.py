"""Whether what ParRay says of a file is what the programs of the field say."""

SAME, TOLD, DIFFERS = "same", "told", "differs"
LENGTH = 2e-3  # absolute and, times 1e-2, relative: PDB and GRO have three decimals
ANGLE = 0.05


def frames_of(said):
    return said.get("frames")


def left_out_of(said):
    """Atoms that the notes say were left out, by note."""
    return 0


def close(a, b):
    return abs(a - b) <= LENGTH + 1e-5 * max(abs(a), abs(b))


def same_box(box, facts, of_facts):
    if of_facts is None or box is None:
        return True
    low, high = box
    if facts.span_only:
        return all(close(h - l, fh - fl) for l, h, fl, fh in zip(low, high, *of_facts))
    return all(close(x, fx) for side, fside in zip(box, of_facts) for x, fx in zip(side, fside))


def same_elements(said, facts):
    return facts.elements is None or "elements" not in said or said["elements"] == facts.elements


def same_frames(said, facts):
    return facts.frames is None or frames_of(said) is None or frames_of(said) == facts.frames


def differences(said, last, facts):
    """What ParRay says otherwise than one program, in words, by field."""
    found = {}
    if said["particles"] != facts.particles:
        found["particles"] = f"{said['particles']}, {facts.program}: {facts.particles}"
    if not same_box(said["box"], facts, facts.box):
        found["box"] = f"{rounded(said['box'])}, {facts.program}: {rounded(facts.box)}"
    if not same_elements(said, facts):
        found["elements"] = f"{said['elements']}, {facts.program}: {facts.elements}"
    if not same_frames(said, facts):
        found["frames"] = f"{frames_of(said)}, {facts.program}: {facts.frames}"
    return found


def rounded(box):
    return [[round(x, 3) for x in side] for side in box]


def verdict(said, last, facts):
    """The record's `verdict` and, for a difference, `why`."""
    if said is None:
        return {"verdict": "refused alone" if facts else "refused by both", "why": {}}
    if not facts:
        return {"verdict": "read alone", "why": {}}
    found = [differences(said, last, f) for f in facts]
    # A field is right where one program says the same.
    why = {name: "; ".join(f[name] for f in found) for name in found[0] if all(name in f for f in found)}
    return {"verdict": DIFFERS if why else SAME, "why": why}

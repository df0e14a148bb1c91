"""The table of outcomes, the list of defects, and the goal."""

import collections
import re

VERDICTS = ("same", "told", "differs", "refused alone", "refused by both", "read alone")
ACCEPTED = 0.98  # of what the programs read
OURS = ("pdb", "mmcif", "chem_comp", "cif", "gro", "pqr", "pdbqt", "mol2", "sdf", "mol", "xyz", "dump", "data", "ply",
        "dcd", "xtc", "netcdf")


# What a refusal has to name, by the ending of files that are none of ParRay's.
FOREIGN = {"arc": "Tinker", "txyz": "Tinker", "crd": "CHARMM", "dms": "SQLite", "g96": "GROM", "gsd": "GSD", "h5md": "HDF5",
           "mmtf": "MMTF", "rst7": "AMBER", "tng": "TNG", "trr": "TRR", "bcif": "BinaryCIF", "mdcrd": "AMBER",
           "inpcrd": "AMBER", "": "DL_POLY|VASP", "cfg": "AtomEye", "yaml": "YAML", "bin": "LAMMPS", "restart": "LAMMPS",
           "local": "LAMMPS"}


def by_kind(records):
    table = collections.defaultdict(collections.Counter)
    for record in records:
        table[record["kind"]][record["verdict"]] += 1
    return table


def goal(records):
    ours = [r for r in records if r["kind"] in OURS]
    read = [r for r in ours if r["field"]]
    return {"files": len(records), "of formats of ParRay": len(ours), "read by the programs": len(read),
            "accepted": sum(r["refusal"] is None for r in read), "differ": sum(r["verdict"] == "differs" for r in ours),
            "refused without a name": sum(map(is_unnamed, records))}


def holds(records):
    g = goal(records)
    return g["accepted"] >= ACCEPTED * g["read by the programs"] and g["differ"] == 0 and g["refused without a name"] == 0


def row(name, counter):
    return f"{name:<12}" + "".join(f"{counter[v] or '-':>17}" for v in ("files", *VERDICTS))


def table_of(records):
    lines = [f"{'format':<12}" + "".join(f"{v:>17}" for v in ("files", *VERDICTS))]
    total = collections.Counter()
    table = by_kind(records)
    for kind in sorted(table, key=lambda k: (k not in OURS, OURS.index(k) if k in OURS else 0, k)):
        table[kind]["files"] = sum(table[kind].values())
        total.update(table[kind])
        lines.append(row(kind, table[kind]))
    return "\n".join([*lines, row("all", total)])


def is_unnamed(record):
    """Whether the refusal of a format that is none of ParRay's does not say what the file looks like."""
    word = FOREIGN.get(record["kind"])
    return bool(word and record["refusal"] and not re.search(word, record["refusal"]))


def is_defect(record):
    return (record["verdict"] == "differs" or (record["verdict"] == "refused alone" and record["kind"] in OURS)
            or is_unnamed(record))


def line_of(record):
    why = record["refusal"] or "; ".join(f"{name}: {text}" for name, text in record["why"].items())
    return f"{record['verdict']}: {record['kind']}: {record['file']}: {why}"


def text_of(records, everything):
    g = goal(records)
    share = g["accepted"] / max(1, g["read by the programs"])
    listed = [line_of(r) for r in records if everything or is_defect(r)]
    return "\n".join([*listed, "", table_of(records), "",
                      f"accepted: {g['accepted']} of {g['read by the programs']} files that the programs read, "
                      f"{100 * share:.1f} % (goal: {100 * ACCEPTED:.0f} %); differ without a word: {g['differ']} (goal: 0); "
                      f"of other formats, refused without their name: {g['refused without a name']} (goal: 0)"])


def as_json(records):
    return {"goal": goal(records), "holds": holds(records),
            "formats": {kind: dict(counter) for kind, counter in by_kind(records).items()}, "records": records}

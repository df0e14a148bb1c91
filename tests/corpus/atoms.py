"""Compares atom by atom: the element and the position of each atom in ParRay with those in a program of the field."""

import json
import pathlib
import tempfile

import numpy
from scipy.spatial import cKDTree

UNKNOWN = "?"  # element of a particle whose element ParRay does not know
SYMBOLS = ("H He Li Be B C N O F Ne Na Mg Al Si P S Cl Ar K Ca Sc Ti V Cr Mn Fe Co Ni Cu Zn Ga Ge As Se Br Kr Rb Sr Y Zr Nb Mo "
           "Tc Ru Rh Pd Ag Cd In Sn Sb Te I Xe Cs Ba La Ce Pr Nd Pm Sm Eu Gd Tb Dy Ho Er Tm Yb Lu Hf Ta W Re Os Ir Pt Au Hg Tl "
           "Pb Bi Po At Rn Fr Ra Ac Th Pa U Np Pu Am Cm Bk Cf Es Fm Md No Lr Rf Db Sg Bh Hs").split()  # with looks of their own
BY_ELEMENT = ("--material", "by-element", "--radius", "by-element")


def atoms_of(positions, names=None):
    """Returns the atoms of a program as (positions, symbols). The symbols are None if the program does not know elements."""
    places = numpy.array(positions, dtype=float).reshape(-1, 3)
    return places, None if names is None else numpy.array([spelled(name) for name in names], dtype="U2")


def spelled(name):
    """Returns the usual spelling of a symbol. Deuterium is hydrogen; other texts are unknown."""
    symbol = str(name).strip().capitalize()
    return "H" if symbol in ("D", "T") else symbol if symbol in SYMBOLS else UNKNOWN


class Converter:
    """Reads the atoms of ParRay from the spheres that `parray convert --expand` writes. Radius and colour show the element."""

    def __init__(self, parray):
        self.parray = parray  # a function that runs the program with words
        self.looks = {}       # (radius, colour): symbol

    def atoms(self, path, elements):
        """Returns (positions, symbols) of the file's first frame, without copies on faces of the cell. `elements`: whether the
        file has elements. Returns None if ParRay cannot write the scene."""
        spheres = self.spheres(path, ("--crystal", "off", *(BY_ELEMENT if elements else ())))
        if spheres is None:
            return None
        places = numpy.array([center for center, _ in spheres], dtype=float).reshape(-1, 3)
        if not elements:
            return places, None
        looks = self.looks_of_elements()
        return places, numpy.array([looks.get(look, UNKNOWN) for _, look in spheres], dtype="U2")

    def copies(self, path, atoms):
        """Returns how many spheres more than `atoms` ParRay draws by default. Returns None if it cannot write the scene."""
        spheres = self.spheres(path, ())
        return None if spheres is None else len(spheres) - atoms

    def looks_of_elements(self):
        if not self.looks:
            with tempfile.TemporaryDirectory() as home:
                path = pathlib.Path(home) / "elements.xyz"
                path.write_text(f"{len(SYMBOLS)}\n\n" + "".join(f"{s} {10 * i} 0 0\n" for i, s in enumerate(SYMBOLS)))
                self.looks = dict(zip((look for _, look in self.spheres(path, BY_ELEMENT)), SYMBOLS, strict=True))
            assert len(self.looks) == len(SYMBOLS), "two elements look alike"
        return self.looks

    def spheres(self, path, options):
        """Returns (centre, (radius, colour)) of each particle."""
        with tempfile.TemporaryDirectory() as home:
            out = pathlib.Path(home) / "scene.json"
            # The style flat has no floor, and no lights that are spheres.
            result = self.parray("convert", path, out, "--expand", "--hide", "none", "--style", "flat,spheres", *options)
            if result.returncode:
                return None
            scene = json.loads(out.read_text())
        colors = {name: tuple(material["albedo"]) for name, material in scene["materials"].items() if "albedo" in material}
        return [(s["center"], (s["radius"], colors.get(s["material"]))) for s in scene["spheres"]]


def differences(ours, theirs, moved):
    """Returns (the number of atoms of ParRay that the program has not at the same place, the number of those that have
    another element). The second is None if one of them does not know elements. `moved`: the program moves the origin."""
    (places, symbols), (other_places, other_symbols) = ours, theirs
    if moved:
        places, other_places = places - places.min(axis=0), other_places - other_places.min(axis=0)
    limit = 4e-3 + 4e-6 * max(numpy.abs(places).max(), numpy.abs(other_places).max())
    tree = cKDTree(other_places)
    distances, nearest = tree.query(places)
    misplaced = int((distances > limit).sum())
    if len(places) == len(other_places):
        misplaced = max(misplaced, int((cKDTree(places).query(other_places)[0] > limit).sum()))
    if symbols is None or other_symbols is None:
        return misplaced, None
    suspects = numpy.flatnonzero((distances <= limit) & (symbols != other_symbols[nearest]))
    # Several atoms may have one place.
    misnamed = sum(symbols[i] not in other_symbols[tree.query_ball_point(places[i], limit)] for i in suspects)
    return misplaced, misnamed

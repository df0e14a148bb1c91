#!/usr/bin/env python3
"""Makes the data of PICTURES.md that come from no package: picture_data.py DIRECTORY

box.lammpstrj  8,000 atoms of a simple cubic lattice with noise; their vx contains a shear wave
grains.csv     400 grains that do not overlap, with radius, speed and type
"""

import math
import pathlib
import random
import sys


def box(cells=20, spacing=2.5):
    """Returns the lines of a LAMMPS dump: a lattice of `cells` cubed atoms, `spacing` angstrom apart."""
    rng = random.Random(1)
    edge = cells * spacing
    lines = ["ITEM: TIMESTEP", "0", "ITEM: NUMBER OF ATOMS", str(cells**3), "ITEM: BOX BOUNDS pp pp pp"]
    lines += [f"0 {edge}"] * 3 + ["ITEM: ATOMS id type x y z vx"]
    for atom in range(cells**3):
        place = (atom % cells, atom // cells % cells, atom // cells**2)
        at = [spacing * (index + 0.5) + rng.gauss(0, 0.12) for index in place]
        speed = 3 * math.sin(2 * math.pi * at[2] / edge) + rng.gauss(0, 0.4)
        lines.append(f"{atom + 1} 1 {at[0]:.4f} {at[1]:.4f} {at[2]:.4f} {speed:.4f}")
    return lines


def grains(count=400, edge=8.0, depth=4.0):
    """Returns the rows of a table of spheres in a box of edge by edge by depth: large spheres, and small ones between."""
    rng = random.Random(4)
    placed = []
    tries = 0
    while len(placed) < count:
        tries += 1
        radius = rng.uniform(0.25, 0.6) if tries < 30000 else rng.uniform(0.15, 0.3)
        at = [rng.uniform(radius, size - radius) for size in (edge, edge, depth)]
        if all(math.dist(at, other) > radius + size for other, size in placed):
            placed.append((at, radius))
    rows = ["x,y,z,radius,speed,type"]
    for at, radius in placed:
        speed = 0.3 * at[2] + rng.uniform(0, 0.2)
        rows.append(",".join(f"{value:.4f}" for value in (*at, radius, speed)) + f",{1 if radius > 0.35 else 2}")
    return rows


def main():
    target = pathlib.Path(sys.argv[1])
    target.mkdir(parents=True, exist_ok=True)
    (target / "box.lammpstrj").write_text("\n".join(box()) + "\n")
    (target / "grains.csv").write_text("\n".join(grains()) + "\n")


if __name__ == "__main__":
    main()

"""MDAnalysis: a selection, frame by frame, each with its error."""

import pathlib

import MDAnalysis

import parray

helix = pathlib.Path(__file__).parents[2] / "scenes/particles/helix.pdb"
universe = MDAnalysis.Universe(helix)
for frame, _ in enumerate(universe.trajectory):
    picture = parray.render(universe.select_atoms("not resname HOH"), width=600, height=450, spp=64)
    picture.save(f"helix-{frame:04}.png")
    print(frame, picture)

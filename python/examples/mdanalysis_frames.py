"""MDAnalysis: the frames of a trajectory, with one camera and one range of colours."""

import pathlib

import MDAnalysis

import parray

helix = pathlib.Path(__file__).parents[2] / "scenes/particles/helix.pdb"
universe = MDAnalysis.Universe(helix)
options = {"select": "not water", "color_by": "resid", "legend": True, "style": "publication"}
pictures = parray.render(universe, frames="all", **options, width=600, height=450, target_error=0.02)
for frame, picture in enumerate(pictures):
    picture.save(f"helix-{frame:04}.png")
    print(frame, picture)

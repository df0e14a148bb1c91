"""ASE: carbon monoxide on platinum, coloured by element, and then by the forces, with the cell."""

import ase.build
from ase.calculators.emt import EMT

import parray

slab = ase.build.fcc111("Pt", (6, 6, 3), vacuum=8)
ase.build.add_adsorbate(slab, ase.build.molecule("CO"), 2.5, "ontop", offset=(3, 3))

picture = parray.render(slab, width=600, height=450, target_error=0.02)
picture.save("slab.png")
print(picture)

slab.calc = EMT()
slab.get_forces()
picture = parray.render(slab, color_by="forces", legend=True, cell=True, width=600, height=450, target_error=0.02)
picture.save("forces.png")
print(picture)

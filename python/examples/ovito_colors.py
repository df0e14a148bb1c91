"""OVITO: the structure types that a pipeline finds, and then the colours that it shows."""

import numpy as np
from ovito.data import DataCollection, SimulationCell
from ovito.modifiers import ColorCodingModifier, CommonNeighborAnalysisModifier
from ovito.pipeline import Pipeline, StaticSource

import parray

corners = 4.0 * np.stack(np.meshgrid(*[np.arange(6)] * 3, indexing="ij"), -1).reshape(-1, 1, 3)
atoms = corners + 2.0 * np.array([[0, 0, 0], [0, 1, 1], [1, 0, 1], [1, 1, 0]])
data = DataCollection()
particles = data.create_particles(count=atoms.size // 3)
particles.create_property("Position", data=atoms.reshape(-1, 3) + np.random.default_rng(5).normal(0, 0.12, (atoms.size // 3, 3)))
particles.vis.radius = 1.3
data.objects.append(SimulationCell(pbc=(True, True, True)))
data.cell_[:, :3] = np.diag([24.0] * 3)

pipeline = Pipeline(source=StaticSource(data=data))
pipeline.modifiers.append(CommonNeighborAnalysisModifier())
picture = parray.render(pipeline, color_by="Structure Type", legend=True, cell=True, width=600, height=450, spp=64)
picture.save("structure.png")
print(picture)

pipeline.modifiers.append(ColorCodingModifier(property="Position.Z"))
picture = parray.render(pipeline, width=600, height=450, spp=64)
picture.save("ovito.png")
print(picture)

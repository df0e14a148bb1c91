"""OVITO: whatever a pipeline makes of the data, in its colours."""

import numpy as np
from ovito.data import DataCollection
from ovito.modifiers import ColorCodingModifier
from ovito.pipeline import Pipeline, StaticSource

import parray

data = DataCollection()
particles = data.create_particles(count=1000)
particles.create_property("Position", data=np.random.default_rng(5).normal(0, 8, (1000, 3)))
pipeline = Pipeline(source=StaticSource(data=data))
pipeline.modifiers.append(ColorCodingModifier(property="Position.Z"))

picture = parray.render(pipeline, width=600, height=450, spp=64)
picture.save("ovito.png")
print(picture)

"""Positions, radii and colours of numpy: the sum of many small steps, coloured by time."""

import numpy as np

import parray

steps = np.random.default_rng(3).normal(size=(2000, 3))
walk = np.cumsum(steps, axis=0)
time = np.linspace(0, 1, len(walk))[:, None]
colors = (1 - time) * [0.9, 0.35, 0.1] + time * [0.1, 0.3, 0.8]

picture = parray.render(walk, 1.2, parray.srgb_to_linear(colors), width=600, height=450, target_error=0.02)
picture.save("walk.png")
print(picture)

"""A farm: several pictures at once, each shown as it is done.

    parray-coordinator --http 127.0.0.1:7480 & parray-worker &
"""

import asyncio

import numpy as np

import parray

farm = parray.Farm("http://127.0.0.1:7480")


async def main() -> None:
    dice = np.random.default_rng(1)
    jobs = [farm.submit(dice.normal(size=(n, 3)), 0.1, width=300, height=200, spp=64) for n in (10, 100, 1000)]
    for job in jobs:
        print(job, await job)


asyncio.run(main())

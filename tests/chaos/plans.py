"""The plan of a history: its seed alone determines the events."""

import dataclasses
import random

SIZE = ("--width", "64", "--height", "48")

# All kinds of jobs. Each takes one thread about a second.
SPECS = {
    "uniform": ("one-weekend-20.json", "--spp", "3000"),
    "sobol": ("shells.json", "--spp", "2200", "--sampler", "sobol"),
    "closed": ("cavity.json", "--spp", "200", "--schedule", "guided"),
    "exact": ("one-weekend-484.json", "--spp", "1200", "--precision", "f64", "--schedule", "factoring"),
    "halves": ("shells.json", "--spp", "1500", "--schedule", "static", "--precision", "f32"),
    "target": ("glass.json", "--target-error", "0.0012"),
    "half-width": ("one-weekend-20.json", "--target-half-width", "0.02", "--sampler", "sobol"),
    "passes": ("one-weekend-484.json", "--passes", "200000,600000,1500000,3000000"),
    "even-passes": ("glass.json", "--adaptive", "off", "--target-error", "0.002"),
}


@dataclasses.dataclass(frozen=True)
class Job:
    at: float  # seconds after the beginning
    kind: str
    priority: int
    waits: bool  # its client stays and writes the picture


@dataclasses.dataclass(frozen=True)
class Event:
    at: float
    what: str  # a method of History
    lasts: float = 0  # seconds until it is undone
    which: int = 0  # of the workers, or whatever there are several of


@dataclasses.dataclass(frozen=True)
class Plan:
    seed: int
    workers: int
    small_disk: bool  # the state is on a disk that can be filled
    spot_checks: float
    impostor: str  # "", "faulty" or "another release": one more worker
    jobs: tuple
    events: tuple


# Weight and longest duration of each kind of event.
KINDS = {
    "kill_worker": (5, 0.5), "stop_worker": (4, 1.8), "end_worker": (2, 0.5), "new_worker": (2, 0),
    "kill_coordinator": (4, 1.0), "stop_coordinator": (3, 1.5), "end_coordinator": (2, 0.5),
    "cut": (3, 0), "tear": (3, 0), "freeze": (2, 1.5), "swallow": (2, 1.2),
    "lose": (3, 1.5), "shuffle": (3, 1.5), "corrupt": (3, 1.5), "slow": (2, 1.0),
    "pause_job": (2, 0.5), "fill_disk": (4, 1.0),
}


def plan_of(seed):
    dice = random.Random(seed)
    small_disk = dice.random() < 0.5
    impostor = dice.choice(("", "", "", "", "", "faulty", "another release"))
    kinds = [kind for kind in KINDS if small_disk or kind != "fill_disk"]
    weights = [KINDS[kind][0] for kind in kinds]
    jobs = [Job(0 if i == 0 else dice.uniform(0, 1), dice.choice(sorted(SPECS)), dice.randrange(101),
                dice.random() < 0.5) for i in range(dice.randint(1, 3))]
    events = []
    for _ in range(dice.randint(3, 8)):
        kind = dice.choices(kinds, weights)[0]
        events.append(Event(round(dice.uniform(0.1, 2.2), 2), kind, round(dice.uniform(0, KINDS[kind][1]), 2),
                            dice.randrange(1000)))
    spot_checks = 1 if impostor == "faulty" else dice.choice((0, 0, 0.2))
    return Plan(seed, dice.randint(3 if impostor == "faulty" else 2, 4), small_disk, spot_checks, impostor, tuple(jobs),
                tuple(sorted(events, key=lambda event: event.at)))

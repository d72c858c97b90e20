"""Studies of a stated effect, simulated and put through the tests that a report makes: how often they detect it.

An effect draws the outcomes of one study and says what the report detects in them. :func:`detections` counts that over
many studies of several sizes, and :func:`needed` finds the size with which it is detected often enough.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.seeds import generator
from lockprobe.foundation.workers import THIS_PROCESS, Pool
from lockprobe.statistics.outcomes import Outcomes
from lockprobe.statistics.proportions import proportion

TRIALS = (15, 30, 60, 120, 240)
"""Trials per condition at which power is measured."""

MOST_TRIALS = 10_000
"""Trials per condition up to which a study is simulated."""

BATCH = 10
"""Studies that a process simulates before it reports."""

Progress = Callable[[int, int], None]
"""Called with the work done and all work."""

Flags = NDArray[np.bool_]


class Effect(Protocol):
    """What is true of an agent. Jobs carry it to other processes."""

    @property
    def address(self) -> tuple[str, ...]:
        """Names its random streams."""

    def detected(self, trials: int, luck: np.random.Generator, tests: np.random.Generator) -> Iterable[Hashable]:
        """Simulate a study of so many trials per condition: what the report detects in it."""


def played(solved: Flags, doses: Sequence[float]) -> Outcomes:
    """Ended trials, from whether each block was solved at each dose, or under each condition; shape (blocks, doses)."""
    blocks, nothing = len(solved), np.zeros(solved.size, dtype=np.int64)
    return Outcomes(
        dose=np.tile(np.array(doses, dtype=np.float64), blocks), repetition=nothing + 1,
        trial=np.repeat(np.arange(1, blocks + 1), len(doses)), length=nothing, solved=solved.reshape(-1), onset=nothing,
    )  # fmt: skip


Detections = Mapping[int, Counter[Hashable]]
"""Trials per condition -> in how many studies each thing was detected."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Rate:
    """In how many simulated studies with so many trials per condition a test detected something."""

    trials: int
    studies: int
    detected: int

    @property
    def power(self) -> float:
        """The share of studies, [0, 1]."""
        return self.detected / self.studies

    @property
    def error(self) -> float:
        """Monte Carlo standard error of the power, after adding one study of each outcome."""
        smooth = (self.detected + 1) / (self.studies + 2)
        return math.sqrt(smooth * (1 - smooth) / self.studies)


@dataclass(frozen=True, slots=True, kw_only=True)
class Needed:
    """The trials per condition with which a test reaches the target power.

    Attributes:
        measured: Its power at every measured number of trials, ascending.
        trials: The number at which power first reaches the target, interpolated in its logarithm; None if none does.
        low: Lower end of its 95 % interval: where the upper ends of power's Wilson intervals reach the target; None if
            they do at the smallest number.
        high: Upper end: where the lower ends reach it; None if they do not.
        below: Whether the smallest measured number of trials reaches the target.
    """

    measured: tuple[Rate, ...]
    trials: int | None
    low: int | None
    high: int | None
    below: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Simulation:
    """How much is simulated.

    Attributes:
        trials: Numbers of trials per condition.
        least: The smallest of them that makes a study.
        target: Power to be reached, (0, 1).
        studies: Studies of each effect and number of trials.
        workers: The pool of processes; their number changes nothing.
        progress: Called with the number of studies done, and of all.
    """

    trials: Sequence[int] = TRIALS
    least: int = 2
    target: float = 0.8
    studies: int = 100
    workers: Pool = THIS_PROCESS
    progress: Progress = lambda done, of: None

    def __post_init__(self) -> None:
        if not 0 < self.target < 1:
            raise BadValue("target power", self.target, "a number between 0 and 1")
        if not self.trials or min(self.trials) < self.least or max(self.trials) > MOST_TRIALS:
            expected = f"numbers of at least {self.least} and at most {MOST_TRIALS}"
            raise BadValue("trials per condition", list(self.trials), expected)


_Job = tuple[Effect, int, int, range]
"""Some studies of one effect: its trials per condition, the seed, and the numbers of these studies."""


def detections(effects: Sequence[Effect], how: Simulation, seed: int) -> list[Detections]:
    """Simulate studies, and count what the report detects of each effect."""
    sizes = sorted(set(how.trials))
    places, jobs = [*product(range(len(effects)), sizes)], list[_Job]()
    for number, size in places:
        starts = range(0, how.studies, BATCH)
        jobs += [(effects[number], size, seed, range(how.studies)[first : first + BATCH]) for first in starts]
    found, done, batches = {at: Counter[Hashable]() for at in places}, 0, len(jobs) // len(places)
    for i, detected in enumerate(how.workers.map(_simulated, jobs)):
        found[places[i // batches]] += detected
        done += len(jobs[i][3])
        how.progress(done, how.studies * len(places))
    return [{size: found[number, size] for size in sizes} for number in range(len(effects))]


def _simulated(job: _Job) -> Counter[Hashable]:
    effect, trials, seed, numbers = job
    found = Counter[Hashable]()
    for number in numbers:
        path: tuple[str | int, ...] = (*effect.address, trials, number)
        found.update(effect.detected(trials, generator(seed, *path), generator(seed, *path, "tests")))
    return found


def needed(found: Detections, what: Hashable, how: Simulation) -> Needed:
    """The trials with which one thing is detected with the target power."""
    target = how.target
    measured = tuple(Rate(trials=size, studies=how.studies, detected=of[what]) for size, of in found.items())
    shares = [proportion(rate.detected, rate.studies) for rate in measured]

    def reached(power_at: Sequence[float]) -> int | None:
        """The first number of trials at which interpolated power reaches the target; None if none does."""
        if power_at[0] >= target:
            return measured[0].trials
        for (before, low), (after, high) in pairwise(zip(measured, power_at, strict=True)):
            if high >= target:
                way = (target - low) / (high - low)
                return math.ceil(
                    math.exp(math.log(before.trials) + way * math.log(after.trials / before.trials)) - 1e-9
                )
        return None

    low = reached([share.high for share in shares])
    return Needed(
        measured=measured,
        trials=reached([share.value for share in shares]),
        low=None if low == measured[0].trials else low,
        high=reached([share.low for share in shares]),
        below=measured[0].power >= target,
    )

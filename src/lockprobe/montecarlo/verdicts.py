"""Error rates of the verdicts of a study of controls, in simulated worlds with a known mechanism."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lockprobe.analysis.why import Verdict, verdict_of
from lockprobe.errors import BadValue
from lockprobe.montecarlo.blocks import Played, played_blocks
from lockprobe.parallel import THIS_PROCESS, Pool
from lockprobe.seeds import generator
from lockprobe.studies.studyfile import study

__all__ = ["MECHANISMS", "STATED", "VerdictRates", "stated_rates", "verdict_rates"]

MECHANISMS: Mapping[str, Verdict] = {
    "world:loop-breaker": "disturbs",
    "world:information": "says",
    "world:information-hurts": "says",
    "world:perseverant": "says",
    "world:careful-believer": "says",
    "world:irrelevant": "no change",
    "world:lost-half": "no change",
}
"""World -> what is true of it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class VerdictRates:
    """The verdicts of studies of one size in one world.

    Attributes:
        world: Agent spec.
        truth: The true verdict.
        blocks: Blocks per study.
        studies: Number of studies.
        verdicts: Verdict -> number of studies that concluded it, most frequent first.
    """

    world: str
    truth: Verdict
    blocks: int
    studies: int
    verdicts: Mapping[Verdict, int]

    @property
    def right(self) -> float:
        """Share of studies that named the true mechanism, [0, 1]."""
        return self.verdicts.get(self.truth, 0) / self.studies

    @property
    def wrong(self) -> float:
        """Share of studies that claimed a wrong mechanism, or wrongly claimed that nothing changes, [0, 1]."""
        silent = (self.truth, "not detectable", "unexplained")
        return sum(n for found, n in self.verdicts.items() if found not in silent) / self.studies


def verdict_rates(
    worlds: Sequence[str],
    *,
    blocks: Sequence[int] = (150,),
    studies: int = 200,
    pool: int = 4000,
    p: float = 0.4,
    seed: int = 1,
    workers: Pool = THIS_PROCESS,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> list[VerdictRates]:
    """Play a pool of blocks of every world, draw studies from it with replacement, and count their verdicts.

    Rates are those of the pool: they carry its sampling error as well as that of the studies.

    Args:
        worlds: Agent specs of known mechanism, from :data:`MECHANISMS`.
        blocks: Study sizes in blocks, each at least 2.
        studies: Studies drawn of each size.
        pool: Blocks played of each world.
        p: The rate at which reports are hit, (0, 1].
        seed: Seed of everything; the number of workers changes nothing.
        workers: The pool of processes that simulates the studies.
        progress: Called with the number of blocks played and their total.

    Raises:
        BadValue: If a number is too small.
    """
    for what, number, least in (("blocks", min(blocks), 2), ("studies", studies, 1), ("pool", pool, max(blocks))):
        if number < least:
            raise BadValue(what, number, f"a number from {least}")
    pools = played_blocks([_arms(world, p, pool, seed) for world in worlds], pool, workers=workers, progress=progress)
    rates = []
    for world, solved in zip(worlds, pools, strict=True):
        for size in blocks:
            rng = generator(seed, "verdicts", world, str(size))
            drawn = (solved[rng.integers(len(solved), size=size)].T.astype(np.float64) for _ in range(studies))
            rates.append(_rates(world, MECHANISMS[world], size, [verdict_of(*arms) for arms in drawn]))
    return rates


def _arms(world: str, p: float, pool: int, seed: int) -> Played:
    """True reports, lies and retracted lies in a world."""
    planned = study("why", agent=world, p=[p], trials=pool, repetitions=1, seed=seed)
    arms = tuple(one for one in planned.conditions if one.name in ("truth", "lie", "retracted"))
    return Played(study=planned, agent=world, conditions=arms)


STATED: Mapping[str, tuple[float, float, float]] = {
    "what they say": (0.23, 0.67, 0.23),
    "that they disturb": (0.23, 0.67, 0.67),
    "no change": (0.45, 0.45, 0.45),
}
"""Effects of the size of the paper's (Sec. 3.2) by either reason, and none: success under truth, lie, retracted lie."""


def stated_rates(
    name: str, success: Sequence[float], *, blocks: Sequence[int], studies: int = 200, seed: int = 1
) -> list[VerdictRates]:
    """The verdict rates of studies of a stated effect, if arms share no luck.

    A seeded agent shares its luck between arms, and needs fewer blocks.

    Args:
        name: Name of the effect.
        success: Success under true reports, lies and retracted lies, each in [0, 1].
        blocks: Study sizes in blocks, each at least 2.
        studies: Simulated studies of each size.
        seed: Seed of everything.

    Raises:
        BadValue: If these are no three shares, or a number is too small.
    """
    if len(success) != 3 or not all(0 <= share <= 1 for share in success):
        raise BadValue("success", list(success), "three shares from 0 to 1: under truth, lie and retracted lie")
    if min(blocks) < 2 or studies < 1:
        raise BadValue("blocks", list(blocks), "numbers from 2, and at least one study")
    truth, lie, retracted = success
    stated: Verdict = "no change" if lie == truth else "says" if retracted == truth else "disturbs"
    if retracted not in (truth, lie):
        stated = "both"
    found = []
    for size in blocks:
        rng = generator(seed, "stated", name, str(size))
        drawn = ((rng.random((3, size)) < np.array(success)[:, None]).astype(np.float64) for _ in range(studies))
        found.append(_rates(name, stated, size, [verdict_of(*arms) for arms in drawn]))
    return found


def _rates(world: str, truth: Verdict, blocks: int, found: Sequence[Verdict]) -> VerdictRates:
    verdicts = dict(Counter(found).most_common())
    return VerdictRates(world=world, truth=truth, blocks=blocks, studies=len(found), verdicts=verdicts)

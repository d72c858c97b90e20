"""Error rates of the verdicts of a study of controls, in simulated worlds with a known mechanism."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.parallel import THIS_PROCESS, Pool
from lockprobe.foundation.seeds import generator
from lockprobe.simulation.montecarlo.blocks import Played, played_blocks
from lockprobe.simulation.montecarlo.propagation import propagate
from lockprobe.statistics.mechanism import MARGIN, Claim, Decision, Verdict, decide
from lockprobe.statistics.why_arms import ARMS
from lockprobe.studies.studyfile import study

__all__ = ["MECHANISMS", "STATED", "Mechanism", "VerdictRates", "mechanism_of", "stated_rates", "verdict_rates"]

Assertion = Literal["changes", "no change", "says", "form"]
"""What a verdict can assert: that lies change success; that they change it by less than the margin; that they act
through what they say; that they act as any odd report does."""

_ASSERTED: Mapping[Verdict, tuple[Assertion, ...]] = {
    "says": ("changes", "says"),
    "form": ("changes", "form"),
    "both": ("changes", "says", "form"),
    "blurred": ("changes",),
    "not decided": ("changes",),
    "no change": ("no change",),
    "inconclusive": (),
}


@dataclass(frozen=True, slots=True)
class Mechanism:
    """What is true of a world.

    Attributes:
        verdict: What a study concludes that is large enough, whatever the size of the change.
        acts: The assertions on how lies act that are true, although some may not show in corrected reports.
    """

    verdict: Verdict
    acts: tuple[Literal["says", "form"], ...] = ()

    def right(self, verdict: Verdict, total: float) -> bool:
        """Whether a verdict is the one that is due: this one, or that the change is below the margin, if it is.

        Args:
            verdict: The conclusion of a study.
            total: The exact total effect, [-1, 1].
        """
        return (verdict == self.verdict and total != 0) or (verdict == "no change" and abs(total) < MARGIN)

    def wrong(self, verdict: Verdict, total: float) -> bool:
        """Whether a verdict asserts something false; the arguments are those of :meth:`right`."""
        true = {*self.acts, "changes"} if total else set()
        return not {*_ASSERTED[verdict]} <= true | ({"no change"} if abs(total) < MARGIN else set())


_SAYS, _FORM = Mechanism("says", ("says",)), Mechanism("form", ("form",))
_NOTHING = Mechanism("no change")

MECHANISMS: Mapping[str, Mechanism] = {
    "world:loop-breaker": _FORM,
    "world:form-by-length": _FORM,
    "world:sceptic": _FORM,
    "world:novelty": Mechanism("not decided"),
    "world:any-falsehood": _SAYS,
    "world:first-believer": _SAYS,
    "world:last-believer": _SAYS,
    "world:agreed-believer": _SAYS,
    "world:plain-believer": Mechanism("not decided", ("says",)),
    "world:correction-jolt": Mechanism("blurred", ("says",)),
    "world:half-and-half": Mechanism("both", ("says", "form")),
    "world:information": _SAYS,
    "world:information-hurts": _SAYS,
    "world:perseverant": _SAYS,
    "world:careful-believer": _SAYS,
    "world:irrelevant": _NOTHING,
    "world:lost-half": _NOTHING,
}
"""World -> what is true of it. In three, corrected reports cannot show how a lie acts: novelty takes notice of the
first odd report alone, which comes too early where reports are corrected; the plain believer does not believe a report
that is corrected; and any correction jolts the last one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class VerdictRates:
    """The verdicts of studies of one size in one world.

    Attributes:
        world: Agent spec, or the name of a stated effect.
        truth: What a study concludes that is large enough.
        change: The exact change of success by lies, [-1, 1].
        blocks: Blocks per study.
        studies: Number of studies.
        verdicts: Verdict -> number of studies that concluded it, most frequent first.
        claims: Claim -> number of studies that made it, most frequent first.
        right: Share of studies with that verdict, or with ``no change`` if the change is below the margin, [0, 1].
        wrong: Share of studies that assert something false: a way of acting that is not the world's, any way or change
            where nothing changes, or ``no change`` where the change is the margin or more, [0, 1].
    """

    world: str
    truth: Verdict
    change: float
    blocks: int
    studies: int
    verdicts: Mapping[Verdict, int]
    claims: Mapping[Claim, int]
    right: float
    wrong: float


def verdict_rates(
    worlds: Sequence[str],
    *,
    blocks: Sequence[int] = (150,),
    studies: int = 200,
    pool: int | None = None,
    p: float = 0.4,
    seed: int = 1,
    workers: Pool = THIS_PROCESS,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> list[VerdictRates]:
    """Play a pool of blocks of every world, draw studies from it, and count their verdicts.

    A pool that suffices is divided into studies that share no block; else blocks are drawn with replacement, so that
    rates carry the sampling error of the pool as well as that of the studies.

    Args:
        worlds: Agent specs of known mechanism, from :data:`MECHANISMS`.
        blocks: Study sizes in blocks, each at least 2.
        studies: Studies drawn of each size.
        pool: Blocks played of each world; None for as many as the studies need, at most 4000 unless one study has more.
        p: The rate at which reports are hit, (0, 1].
        seed: Seed of everything; the number of workers changes nothing.
        workers: The pool of processes that simulates the studies.
        progress: Called with the number of blocks played and their total.

    Raises:
        BadValue: If a number is too small.
    """
    _check(blocks, studies)
    played = min(max(4000, *blocks), studies * max(blocks)) if pool is None else pool
    if played < max(blocks):
        raise BadValue("pool", played, f"a number from {max(blocks)}")
    pools = played_blocks(
        [_arms(world, p, played, seed) for world in worlds], played, workers=workers, progress=progress
    )
    rates = []
    for world, solved in zip(worlds, pools, strict=True):
        total = _total(world, p)
        for size in blocks:
            drawn = _drawn(solved, size, studies, generator(seed, "verdicts", world, str(size)))
            rates.append(_rates(world, MECHANISMS[world], total, size, drawn))
    return rates


def _check(blocks: Sequence[int], studies: int) -> None:
    for what, number, least in (("blocks", min(blocks), 2), ("studies", studies, 1)):
        if number < least:
            raise BadValue(what, number, f"a number from {least}")


def _arms(world: str, p: float, pool: int, seed: int) -> Played:
    """The arms of the study in a world, in the order of :data:`~lockprobe.statistics.why_arms.ARMS`."""
    planned = study("why", agent=world, p=[p], trials=pool, repetitions=1, seed=seed)
    by_name = {one.name: one for one in planned.conditions}
    return Played(study=planned, agent=world, conditions=tuple(by_name[arm] for arm in ARMS))


def _total(world: str, p: float) -> float:
    """The exact total effect in a world; an effect that is rounding error is 0."""
    found = propagate(world, condition=ARMS["lie"].format(p=p, reading="")).success - propagate(world).success
    return found if abs(found) > _ROUNDING else 0.0


def _drawn(solved: NDArray[np.bool_], size: int, studies: int, rng: np.random.Generator) -> Iterator[NDArray[np.bool_]]:
    """Studies from a pool of blocks, each of shape (size, arms)."""
    apart = size * studies <= len(solved)
    for number in range(studies):
        yield solved[number * size :][:size] if apart else solved[rng.integers(len(solved), size=size)]


STATED: Mapping[str, tuple[float, ...]] = {
    "what they say last": (0.23, 0.67, 0.23, 0.23, 0.67, 0.67, 0.23),
    "what they say first": (0.23, 0.67, 0.23, 0.67, 0.23, 0.67, 0.23),
    "as any odd report": (0.23, 0.67, 0.67, 0.67, 0.67, 0.67, 0.67),
    "small, said last": (0.45, 0.60, 0.45, 0.45, 0.60, 0.60, 0.45),
    "no change": (0.45,) * 7,
}
"""Effect -> success in each of :data:`~lockprobe.statistics.why_arms.ARMS`: three of the paper's size (Sec. 3.2), a
small
one, and none."""


def stated_rates(
    name: str, success: Sequence[float], *, blocks: Sequence[int], studies: int = 200, seed: int = 1
) -> list[VerdictRates]:
    """The verdict rates of studies of a stated effect, if arms share no luck.

    A seeded agent shares its luck between arms, and needs fewer blocks.

    Args:
        name: Name of the effect.
        success: Success in each of :data:`~lockprobe.statistics.why_arms.ARMS`, each in [0, 1].
        blocks: Study sizes in blocks, each at least 2.
        studies: Simulated studies of each size.
        seed: Seed of everything.

    Raises:
        BadValue: If these are not as many shares as arms, or a number is too small.
    """
    if len(success) != len(ARMS) or not all(0 <= share <= 1 for share in success):
        raise BadValue("success", list(success), f"{len(ARMS)} shares from 0 to 1, for {', '.join(ARMS)}")
    _check(blocks, studies)
    mechanism, total, found = mechanism_of(success), success[1] - success[0], []
    for size in blocks:
        rng = generator(seed, "stated", name, str(size))
        drawn = (rng.random((size, len(ARMS))) < np.array(success) for _ in range(studies))
        found.append(_rates(name, mechanism, total, size, drawn))
    return found


def mechanism_of(success: Sequence[float]) -> Mechanism:
    """What is true of success in each of :data:`~lockprobe.statistics.why_arms.ARMS`.

    What reports say acts if two false statements do more than two true ones in the direction of the total effect, or if
    a false statement does wherever it stands last, or first; the form acts if true corrections and remarks do it too.
    """
    truth, lie, both_true, lie_truth, truth_lie, both_false, remark = success
    if lie == truth:
        return _NOTHING

    def more(one: float, other: float) -> bool:
        return (one - other) * (lie - truth) > _ROUNDING

    says = (
        more(both_false, both_true)
        or (more(truth_lie, both_true) and more(both_false, lie_truth))
        or (more(lie_truth, both_true) and more(both_false, truth_lie))
    )
    corrections = more(both_true, truth)
    if says:
        return Mechanism("both", ("says", "form")) if corrections and more(remark, truth) else _SAYS
    if corrections and more(remark, truth):
        return _FORM
    return Mechanism("blurred" if corrections else "not decided")


def _rates(
    world: str, mechanism: Mechanism, total: float, blocks: int, drawn: Iterable[NDArray[np.bool_]]
) -> VerdictRates:
    """The rates of studies, each of shape (blocks, arms)."""
    found: list[Decision] = [decide(dict(zip(ARMS, one.T.astype(np.float64), strict=True))) for one in drawn]
    verdicts = Counter(one.verdict for one in found)
    due, false = (
        sum(n for verdict, n in verdicts.items() if judged(verdict, total)) / len(found)
        for judged in (mechanism.right, mechanism.wrong)
    )
    return VerdictRates(
        world=world,
        truth=mechanism.verdict if total else "no change",
        change=total,
        blocks=blocks,
        studies=len(found),
        verdicts=dict(verdicts.most_common()),
        claims=dict(Counter(claim for one in found for claim in one.claims).most_common()),
        right=due,
        wrong=false,
    )


_ROUNDING = 1e-9

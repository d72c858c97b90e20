"""How often the study ``why`` names a true or a false mechanism: its rule of seven arms, and an older one of three.

    OMP_NUM_THREADS=1 python benchmarks/why_rules.py [--studies 400] [--blocks 50,150,600] [--pool 2000] [--workers 2]

Both rules judge the same studies. Those of a world of known mechanism are drawn with replacement from a pool of blocks
that the world has played, so that its arms share their luck; those of stated shares of success have independent luck.
A study is right if its verdict is that of a large study, or that success changes by less than the margin where it
does; it is wrong if its verdict asserts something false (:class:`lockprobe.simulation.power.why.Mechanism`).
A verdict that decides nothing is neither, nor is one that names one of two ways.

The older rule has true reports, lies and retracted lies. It takes the difference that a retraction makes for what a lie
says, and what remains of the effect for the form.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.parallel import Pool, Processes
from lockprobe.foundation.seeds import generator
from lockprobe.simulation.exact.propagation import propagate
from lockprobe.simulation.montecarlo.blocks import Played, played_blocks
from lockprobe.simulation.power.why import STATED, Mechanism, mechanism_of
from lockprobe.statistics.agent_comparison.paired import Array, BlockMean
from lockprobe.statistics.paired_proportions import equivalence
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.why.arms import ARMS
from lockprobe.statistics.why.mechanism import MARGIN, Verdict, decide, mean_over_blocks
from lockprobe.studies.options.studyfile import study

P = 0.4

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

PATTERNS: Mapping[str, tuple[float, ...]] = {
    **STATED,
    "no change, low success": (0.23,) * 7,
    "a change of the margin, said last": (0.45, 0.55, 0.45, 0.45, 0.55, 0.55, 0.45),
    "lies hurt, said last": (0.67, 0.40, 0.67, 0.67, 0.40, 0.40, 0.67),
    "only if both statements are false": (0.23, 0.67, 0.23, 0.23, 0.23, 0.67, 0.23),
    "if any statement is false": (0.23, 0.67, 0.23, 0.67, 0.67, 0.67, 0.23),
    "last more than first": (0.23, 0.67, 0.23, 0.38, 0.52, 0.67, 0.23),
    "said last, and as any odd report": (0.23, 0.67, 0.45, 0.45, 0.67, 0.67, 0.45),
    "said last; a remark does it as well": (0.23, 0.67, 0.23, 0.23, 0.67, 0.67, 0.67),
    "odd reports, the longer the more": (0.23, 0.60, 0.72, 0.72, 0.72, 0.72, 0.50),
    "any correction": (0.23, 0.67, 0.67, 0.67, 0.67, 0.67, 0.23),
    "plain lies alone": (0.23, 0.67, 0.23, 0.23, 0.23, 0.23, 0.23),
    "statements that disagree": (0.23, 0.67, 0.23, 0.67, 0.67, 0.23, 0.23),
    "as any odd report, unless statements disagree": (0.23, 0.67, 0.67, 0.40, 0.40, 0.67, 0.67),
}
"""Success in each arm."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A world or a pattern, and what is true of it.

    Attributes:
        name: Its name.
        mechanism: What is true of it.
        total: The exact change of success by lies.
        source: The pool of blocks, shape (blocks, arms), or the success in each arm, shape (arms,).
    """

    name: str
    mechanism: Mechanism
    total: float
    source: NDArray[np.bool_] | NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """Studies of one size in one case."""

    case: Case
    blocks: int
    studies: int


def older(solved: Mapping[str, Array]) -> Verdict:
    """The verdict of the older rule."""

    def detected(found: BlockMean) -> bool:
        return found.p_value is not None and found.p_value < ALPHA and found.clear

    truth, lie, retracted = (solved[arm] for arm in ("truth", "lie", "lie-truth"))
    change = lie - truth
    if not detected(mean_over_blocks(change)):
        small = equivalence(int(np.sum(change < 0)), int(np.sum(change > 0)), len(change), MARGIN)
        return "no change" if small < ALPHA else "inconclusive"
    says, form = (detected(mean_over_blocks(part)) for part in (lie - retracted, retracted - truth))
    return "both" if says and form else "says" if says else "form" if form else "not decided"


def drawn(job: Job, rng: np.random.Generator) -> dict[str, Array]:
    """One study: arm -> whether each block was solved."""
    source = job.case.source
    solved = (
        rng.random((job.blocks, len(ARMS))) < source
        if source.ndim == 1
        else source[rng.integers(len(source), size=job.blocks)]
    )
    return dict(zip(ARMS, solved.T.astype(np.float64), strict=True))


def verdicts(job: Job) -> tuple[Counter[Verdict], Counter[Verdict]]:
    """The verdicts of the older rule and of this one on the same studies."""
    rng = generator(1, "why rules", job.case.name, str(job.blocks))
    pairs = [(older(one), decide(one).verdict) for one in (drawn(job, rng) for _ in range(job.studies))]
    return Counter(old for old, _ in pairs), Counter(new for _, new in pairs)


def worlds(names: Sequence[str], pool: int, workers: Pool) -> list[Case]:
    """Worlds with their exact effect and the blocks that they have played."""
    asked = []
    for world in names:
        planned = study("why", agent=world, p=[P], trials=pool, repetitions=1, seed=1)
        by_name = {one.name: one for one in planned.conditions}
        asked.append(Played(study=planned, agent=world, conditions=tuple(by_name[arm] for arm in ARMS)))
    pools = played_blocks(asked, pool, workers=workers)
    return [
        Case(name=name, mechanism=MECHANISMS[name], total=total(name), source=pool)
        for name, pool in zip(names, pools, strict=True)
    ]


def total(world: str) -> float:
    """The exact change of success by lies, without rounding errors."""
    return round(propagate(world, condition=f"flip?p={P}").success - propagate(world).success, 9)


def row(job: Job, found: tuple[Counter[Verdict], Counter[Verdict]]) -> tuple[str, float]:
    """A row of the table, and the share of wrong studies of this rule."""
    case = job.case
    rights, wrongs = (
        [sum(n for one, n in rule.items() if judged(one, case.total)) / job.studies for rule in found]
        for judged in (case.mechanism.right, case.mechanism.wrong)
    )
    change = f"{100 * case.total:+.1f}" if case.total else "0"
    truth = case.mechanism.verdict if case.total else "no change"
    said = ", ".join(f"{verdict} {n}" for verdict, n in found[1].most_common())
    shares = [f"{share:.3f}" for share in (*rights, *wrongs)]
    return f"| {' | '.join([case.name, change, truth, str(job.blocks), *shares, said])} |", wrongs[1]


def main() -> None:
    """Print the table, and the worst share of wrong studies."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--studies", type=int, default=400)
    parser.add_argument("--blocks", default="50,150,600")
    parser.add_argument("--pool", type=int, default=2000, help="blocks played of each world")
    parser.add_argument("--workers", type=int, default=2)
    asked = parser.parse_args()
    workers = Processes(asked.workers)
    patterns = [
        Case(name=name, mechanism=mechanism_of(shares), total=round(shares[1] - shares[0], 9), source=np.array(shares))
        for name, shares in PATTERNS.items()
    ]
    jobs = [
        Job(case=case, blocks=int(size), studies=asked.studies)
        for case in (*worlds(list(MECHANISMS), asked.pool, workers), *patterns)
        for size in asked.blocks.split(",")
    ]
    heads = (
        "world or pattern",
        "change",
        "truth",
        "blocks",
        "right: older",
        "this",
        "wrong: older",
        "this",
        "verdicts of this rule",
    )
    print(f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}")
    worst = 0.0, ""
    for job, found in zip(jobs, workers.map(verdicts, jobs), strict=True):
        text, wrong = row(job, found)
        worst = max(worst, (wrong, f"{job.case.name} at {job.blocks} blocks"))
        print(text, flush=True)
    error = (worst[0] * (1 - worst[0]) / asked.studies) ** 0.5
    print(f"\nThis rule is wrong most often in {worst[1]}: {worst[0]:.3f} ± {error:.3f} (Monte Carlo standard error).")


if __name__ == "__main__":
    main()

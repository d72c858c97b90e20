"""Blocks until a study is decided, against fixed designs of equal power; ``every_look.py`` runs it.

Conditions are pairs of trials of equal luck: normal latent skills with a correlation. A study that stops when it is
decided looks after every five blocks, plays no condition that is decided, and its control until all are. The fixed
design has the report's tests at one look, McNemar's and that of the interval; where nothing differs, its exact test of
equivalence.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from looking import NEVER, said_at_every_look, same_as_the_report
from numpy.typing import NDArray

from lockprobe.foundation.seeds import generator
from lockprobe.statistics.paired_proportions import FEW, MOST_EXACT, score
from lockprobe.statistics.paired_proportions import _at_most as equivalence_one_sided
from lockprobe.statistics.proportions import ALPHA, paired
from lockprobe.studies.until import LOOK_EVERY, MARGIN, MOST

Array = NDArray[np.float64]

POWERS = (0.8, 0.9, 0.95)
LONGEST = 12_000
"""Blocks after which a simulated study is given up."""

PAIRS = ((0.233, 0.667), (0.3, 0.5), (0.5, 0.6), (0.9, 0.995), (0.3, 0.3), (0.5, 0.5), (0.9, 0.9))
"""Success under the control and under every dose: effects of 43, 20, 10 and 9.5 points, and none."""

LUCKS = (0.0, 0.3, 0.7)
DOSES = (1, 3, 6)


@dataclass(frozen=True, slots=True)
class Truth:
    """What is true of a study.

    Attributes:
        first, second: Success under the control, and under every dose.
        luck: Correlation of the latent skills of a block.
        doses: Doses against the control.
    """

    first: float
    second: float
    luck: float
    doses: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Calls:
    """Blocks that fixed designs need, and those until a study is decided.

    Attributes:
        truth: What is true.
        fixed: Blocks of the fixed design of each of :data:`POWERS`, for a single dose.
        blocks: Blocks until every dose is decided, shape (studies,).
        trials: Trials that are played until then, per condition, shape (studies,).
        wrong: Share of studies with a false decision.
    """

    truth: Truth
    fixed: tuple[int, ...]
    blocks: Array
    trials: Array
    wrong: float


@dataclass(frozen=True, slots=True)
class Job:
    """Studies of one truth."""

    truth: Truth
    studies: int
    seed: int


def differing(truth: Truth) -> tuple[float, float]:
    """The share of pairs solved under the control alone, and under the dose alone."""
    from scipy.stats import multivariate_normal, norm

    ends = norm.ppf([truth.first, truth.second])
    both = float(multivariate_normal.cdf(ends, cov=[[1, truth.luck], [truth.luck, 1]], abseps=1e-9, releps=1e-9))
    return truth.first - both, truth.second - both


def decided(job: Job) -> Calls:
    """Simulate studies until they are decided."""
    truth, batch = job.truth, 50
    size = 500 if truth.first != truth.second else 1500
    found = [
        _until(truth, min(batch, job.studies - i), size, generator(job.seed, "calls", str(truth), i))
        for i in range(0, job.studies, batch)
    ]
    at, wrong = np.concatenate([one for one, _ in found]), np.concatenate([one for _, one in found])
    at = np.ceil(at / LOOK_EVERY) * LOOK_EVERY
    blocks = at.max(axis=1)
    return Calls(
        truth=truth,
        fixed=tuple(fixed(truth, power) for power in POWERS),
        blocks=blocks,
        trials=(at.sum(axis=1) + blocks) / (truth.doses + 1),
        wrong=float(wrong.mean()),
    )


def _until(truth: Truth, studies: int, size: int, rng: np.random.Generator) -> tuple[Array, NDArray[np.bool_]]:
    """The block at which each dose is decided, and whether a decision was false; longer studies if some are not."""
    from scipy.stats import norm

    ends = norm.ppf([truth.first, *[truth.second] * truth.doses])
    pairs = np.empty((studies, 0, truth.doses), dtype=np.int8)
    while True:
        block = rng.standard_normal((studies, size, 1)) * truth.luck**0.5
        skill = block + rng.standard_normal((studies, size, truth.doses + 1)) * (1 - truth.luck) ** 0.5
        solved = (skill < ends).astype(np.int8)
        pairs = np.concatenate([pairs, solved[..., 1:] - solved[..., :1]], axis=1)
        said = said_at_every_look(pairs, margin=MARGIN)
        effect, small = said.first(said.effect != 0), said.first(said.small)
        at = np.minimum(effect, small)
        size = pairs.shape[1]
        if at.max() < NEVER or 2 * size > LONGEST:
            break
    same_as_the_report(pairs, said, margin=MARGIN)
    place = np.searchsorted(said.blocks, np.minimum(at, said.blocks[-1]))
    way = np.take_along_axis(said.effect, place[:, None], axis=1)[:, 0]
    change = truth.second - truth.first
    wrong = np.where(effect <= small, way != np.sign(change), abs(change) >= MARGIN - 1e-9) & (at < NEVER)
    return np.minimum(at, size).astype(np.float64), wrong.any(axis=1)


@cache
def fixed(truth: Truth, power: float) -> int:
    """The fewest blocks with which the fixed design has this power for each dose, corrected for all (Bonferroni)."""
    of = _power_of_none if truth.first == truth.second else _power_of_effect
    low, high = 5, 10
    while of(truth, high) < power:
        low, high = high, 2 * high
    while high - low > 1:
        half = (low + high) // 2
        low, high = (low, half) if of(truth, half) >= power else (half, high)
    return high


def _power_of_effect(truth: Truth, pairs: int) -> float:
    first, second, chance = _tables(truth, pairs)
    return float(chance[rejects(first, second, pairs, truth.doses)].sum())


def rejects(first: Array, second: Array, pairs: int, choices: int) -> NDArray[np.bool_]:
    """Whether the report concludes that success differs: McNemar's exact test and the interval, corrected."""
    from scipy.stats import binom, norm

    differ = first + second
    exact = np.minimum(1.0, 2 * binom.cdf(np.minimum(first, second), differ, 0.5))
    n = pairs + 2
    middle = (second - first) / n
    away = np.abs(middle) / np.sqrt(((differ + 1) / n - middle**2) / n)
    away = np.where(differ <= FEW, np.minimum(away, np.abs(score(first, second, pairs, 0.0))), away)
    found: NDArray[np.bool_] = choices * np.maximum(exact, 2 * norm.sf(away)) < ALPHA
    return found


def same_as_paired(rng: np.random.Generator, draws: int = 200) -> None:
    """Hold :func:`rejects` to the numbers of a report."""
    for pairs in rng.integers(5, 80, draws).tolist():
        solved = rng.random((2, pairs)) < rng.random((2, 1))
        found = paired(solved[0], solved[1])
        counts = np.array([found.only_first]), np.array([found.only_second])
        assert rejects(*counts, pairs, 1)[0] == (max(found.p_value, found.interval_p) < ALPHA)


def _power_of_none(truth: Truth, pairs: int) -> float:
    first, second, chance = _tables(truth, pairs)
    scores = [score(*both, pairs, MARGIN) for both in ((first, second), (second, first))]
    small = [one <= _critical(pairs, ALPHA / truth.doses) for one in scores]
    return float(chance[small[0] & small[1]].sum())


@cache
def _critical(pairs: int, level: float) -> float:
    """The largest score that rejects, one-sided, a difference of the margin or more."""
    from scipy.stats import norm

    if pairs > MOST_EXACT:
        return float(norm.ppf(level))
    tables = [(i, j) for i in range(pairs + 1) for j in range(pairs + 1 - i)]
    scores = score(*zip(*tables, strict=True), pairs, MARGIN).round(9).tolist()
    by_score = dict(zip(scores, tables, strict=True))
    values = sorted(by_score)
    low, high = -1, len(values)
    while high - low > 1:
        half = (low + high) // 2
        below = equivalence_one_sided(*by_score[values[half]], pairs, MARGIN) < level
        low, high = (half, high) if below else (low, half)
    return values[low] + 1e-8 if low >= 0 else -math.inf


@cache
def _tables(truth: Truth, pairs: int) -> tuple[Array, Array, Array]:
    """All numbers of pairs that fall either way which matter, and their probability."""
    from scipy.special import gammaln, xlogy

    one, two = differing(truth)
    first, second = np.indices((pairs + 1, pairs + 1)).reshape(2, -1).astype(np.float64)
    kept = first + second <= pairs
    first, second = first[kept], second[kept]
    alike = pairs - first - second
    ways = math.lgamma(pairs + 1) - gammaln(first + 1) - gammaln(second + 1) - gammaln(alike + 1)
    chance = np.exp(ways + xlogy(first, one) + xlogy(second, two) + xlogy(alike, max(0.0, 1 - one - two)))
    likely = chance > 1e-12
    return first[likely], second[likely], chance[likely]


def table(found: Sequence[Calls]) -> str:
    """The table of these studies."""
    fixed_heads = [f"fixed, power {power:g}" for power in POWERS]
    until_heads = ["mean", "median", "95 % of studies", "trials / fixed, power 0.9", f"decided by {MOST}", "wrong"]
    heads = ["success", "luck", "doses", *fixed_heads, *until_heads]
    lines = [heads, ["---"] * len(heads)]
    for one in found:
        low, middle, high = np.quantile(one.blocks, (0.025, 0.5, 0.975), method="inverted_cdf")
        truth = one.truth
        longest = f"{high:.0f}" if high < 6000 else "over 6000"
        lines.append(
            [
                f"{truth.first:g} / {truth.second:g}",
                f"{truth.luck:g}",
                str(truth.doses),
                *map(str, one.fixed),
                f"{one.blocks.mean():.0f}",
                f"{middle:.0f}",
                f"{low:.0f} to {longest}",
                f"{one.trials.mean() / one.fixed[1]:.2f}",
                f"{np.mean(one.blocks <= MOST):.2f}",
                f"{one.wrong:.3f}",
            ]
        )
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)

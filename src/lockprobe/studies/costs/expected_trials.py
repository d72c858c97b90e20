"""What a study that stops when it is decided is expected to play, under an assumption that is named.

Nobody knows how much it will play: that depends on what is true. So the estimate assumes two truths, an effect of the
size of the paper's and none, and draws the trials that are still to come by them. Trials on record stay as they are.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.seeds import generator
from lockprobe.studies.decisions import Array, Family, Outcomes, played_out
from lockprobe.studies.stopping import at_most, families, outcomes_of, own_places
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial

_STUDIES = {"decided": 60, "width": 10}
"""Simulated studies by rule: an interval takes longer to compute, and its width varies less."""

_MOST = 2000
"""Blocks that are simulated; a study that is open then counts as played to its most."""


@dataclass(frozen=True, slots=True)
class Spread:
    """A number over simulated studies.

    Attributes:
        mean: Its mean.
        low, high: Between these lie 95 % of the studies.
    """

    mean: float
    low: float
    high: float


def spread(values: Sequence[float]) -> Spread:
    """The mean of some numbers, and the range of the middle 95 % of them.

    >>> spread([10, 20, 30])
    Spread(mean=20.0, low=10.5, high=29.5)
    """
    low, high = np.quantile(values, (0.025, 0.975)).tolist()
    return Spread(float(np.mean(values)), low, high)


@dataclass(frozen=True, slots=True)
class Assumption:
    """What is taken to be true of an agent; trials share no luck, as those of a sampled model.

    Attributes:
        name: A short name.
        says: The assumption in words.
        low: Success under the first control, [0, 1].
        high: Success under every condition that is compared with one of ``low``; under those that are compared with one
            of ``high`` it is ``low``.
    """

    name: str
    says: str
    low: float
    high: float

    def success(self, asked: Iterable[Family]) -> dict[str, float]:
        """Success under each condition that is asked for.

        Among the arms of a study of controls, the truth alone has the lower one.
        """
        found: dict[str, float] = {}
        for family in asked:
            for more, less in (pair for one in family.questions for pair in one.terms):
                if family.after:
                    found |= {label: self.high for label in (more, less) if label not in found}
                else:
                    first = found.setdefault(less or more, self.low)
                    found.setdefault(more, self.high if first == self.low else self.low)
        return found


ASSUMPTIONS = (
    Assumption("effect", "success is 23 % or 67 %, so that all differ from their control as in the paper", 0.23, 0.67),
    Assumption("no effect", "success is 23 % under every condition", 0.23, 0.23),
)
"""An effect of the size of the paper's (Sec. 3.2), and none."""


@dataclass(frozen=True, slots=True)
class Outlook:
    """The trials that an agent is expected to play from now on.

    Attributes:
        assumption: What is taken to be true.
        shares: Condition -> the expected number of trials, as a share of those that it may have to play at most.
        totals: Trials under all conditions, one number for each simulated study.
        decided: In how many of these studies everything is decided within the most.
    """

    assumption: Assumption
    shares: Mapping[str, float]
    totals: tuple[int, ...]
    decided: int


def outlooks(study: Study, agent: str, trials: Iterable[Trial]) -> list[Outlook]:
    """What an agent is expected to play from now on, of a study that stops when it is decided.

    Args:
        study: The study, with ``until``.
        agent: Spec of the agent.
        trials: Trials on record.
    """
    now = _now(study, agent, trials)
    compared = any(not one.of_share for family in now.asked for one in family.questions)
    return [_outlook(study, now, assumed) for assumed in ASSUMPTIONS if compared or assumed.low == assumed.high]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Now:
    """Where an agent stands.

    Attributes:
        asked: What is asked of it.
        known: The outcomes on record; blocks that are not are NaN and not broken.
        owed: Condition -> the trials that it may have to play at most.
        finished: Condition -> trials on record, of the blocks that are simulated.
    """

    asked: tuple[Family, ...]
    known: Outcomes
    owed: Mapping[str, int]
    finished: Mapping[str, int]


def _now(study: Study, agent: str, trials: Iterable[Trial]) -> _Now:
    trials = list(trials)
    recorded = outcomes_of(study, agent, trials)
    ranks = np.array([rank for rank, _ in own_places(study, agent)[:_MOST]])
    known = {label: _at(ranks, *one) for label, one in recorded.items()}
    owed = Counter(plan.condition.label for plan in at_most(study, agent, trials))
    return _Now(
        asked=families(study, agent),
        known=known,
        owed={label: owed[label] for label in known},
        finished={label: int((broken | ~np.isnan(solved)).sum()) for label, (solved, broken) in known.items()},
    )


def _at(ranks: NDArray[np.int64], solved: Array, broken: NDArray[np.bool_]) -> tuple[Array, NDArray[np.bool_]]:
    """The outcomes on record at some places of the order, as if nothing were recorded after the last of them."""
    more = max(0, 1 + int(ranks[-1]) - len(solved))
    return np.append(solved, [np.nan] * more)[ranks], np.append(broken, [False] * more)[ranks]


def _outlook(study: Study, now: _Now, assumed: Assumption) -> Outlook:
    assert study.until is not None
    rng, more, decided = generator(study.seed, "outlook", assumed.name), [], 0
    success = assumed.success(now.asked)
    for _ in range(_STUDIES[study.until.rule]):
        course = played_out(
            now.asked,
            {label: _drawn(*one, success.get(label, 0.0), rng) for label, one in now.known.items()},
            study.until,
        )
        decided += all(one.at is not None for one in course.decisions)
        more.append({label: _still(now, label, end) for label, end in course.bought.items()})
    means = {label: sum(one[label] for one in more) / len(more) for label in now.known}
    return Outlook(
        assumption=assumed,
        shares={label: mean / now.owed[label] if now.owed[label] else 0.0 for label, mean in means.items()},
        totals=tuple(sum(one.values()) for one in more),
        decided=decided,
    )


def _drawn(
    solved: Array, broken: NDArray[np.bool_], success: float, rng: np.random.Generator
) -> tuple[Array, NDArray[np.bool_]]:
    """The outcomes on record under a condition, and all others by its success."""
    return np.where(np.isnan(solved) & ~broken, rng.random(len(solved)) < success, solved), broken


def _still(now: _Now, label: str, end: int) -> int:
    """The trials that are still to be played of a condition that is played in this many blocks."""
    if end == len(now.known[label][0]):
        return now.owed[label]
    return min(now.owed[label], max(0, end - now.finished[label]))

"""Human participants in a study: success and steps.

People count as one agent. A person plays several boxes and may learn from box to box, which agents cannot, so first
boxes are also counted apart.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.seeds import generator
from lockprobe.statistics.clustered import ClusteredProportion, alike_weights, crossed_proportion
from lockprobe.statistics.outcomes import conditions_played, ended
from lockprobe.statistics.proportions import Proportion, proportion
from lockprobe.trial.record import Fact, Trial

RESAMPLES = 2000

Array = NDArray[np.float64]
Labels = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Steps:
    """Steps that people need to open a box. An unsolved trial is censored at its budget.

    Attributes:
        median: Kaplan-Meier median; None if fewer than half were solved.
        low, high: Ends of its 95 % interval; None if beyond the budget or unknown.
        mean: Mean; an unsolved trial counts with its whole budget.
    """

    median: int | None
    low: int | None
    high: int | None
    mean: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PeopleAt:
    """The results of people under one condition, or in one modality over all conditions.

    Attributes:
        modality: How the box was shown.
        condition: Label of the condition; empty for all together.
        people: Number of people.
        success: Trials solved, clustered by player and luck.
        steps: Steps that they needed, with the Kaplan-Meier median.
    """

    modality: str
    condition: str
    people: int
    success: ClusteredProportion
    steps: Steps


@dataclass(frozen=True, slots=True, kw_only=True)
class AtPosition:
    """The results of people on the boxes at one position in their sequence.

    Attributes:
        position: From 1.
        success: Share solved, with Wilson's interval: each person has one box.
    """

    position: int
    success: Proportion


@dataclass(frozen=True, slots=True, kw_only=True)
class People:
    """All people of a study, over all conditions that they played.

    Attributes:
        people: People with such a trial that ended.
        trials: Those trials.
        fewest, most: Fewest and most trials of one person.
        success: Share solved over all conditions.
        alike: Mean over people of the share that each solved, [0, 1]; it equals ``success`` if all have as many trials.
        first: Share of first boxes solved, without learning from other boxes.
        positions: Results by position, where it is known.
        at: Results by condition: flip rates, ascending, then the others in the order of the trials.
        over: Results by modality, over all conditions.
        saw: Number of trials by fact about the display (view, language, feedback and so on) and its value.
    """

    people: int
    trials: int
    fewest: int
    most: int
    success: ClusteredProportion
    alike: float
    first: Proportion
    positions: tuple[AtPosition, ...]
    at: tuple[PeopleAt, ...]
    over: tuple[PeopleAt, ...]
    saw: Mapping[str, Mapping[str, int]]


_SAW = ("view", "history", "feedback", "design", "words", "page")
"""Facts of a person's trial that describe the display."""


def people(trials: Sequence[Trial]) -> People | None:
    """The results of people in the trials of one study; None if none of their trials has ended."""
    begun = [trial for trial in trials if trial.player]
    own = ended(begun)
    if not own:
        return None
    sizes = Counter(trial.agent for trial in own)
    conditions = conditions_played(own)
    modalities = dict.fromkeys(conditions.values())
    first = [trial for trial in own if trial.facts.get("position") == 1]
    return People(
        people=len(sizes),
        trials=len(own),
        fewest=min(sizes.values()),
        most=max(sizes.values()),
        success=_success(begun),
        alike=float(np.mean([trial.solved for trial in own] * alike_weights([trial.agent for trial in own]))),
        first=proportion(sum(trial.solved for trial in first), len(first)),
        positions=tuple(_positions(own)),
        at=tuple(_at([t for t in begun if t.condition == one], shown, one) for one, shown in conditions.items()),
        over=tuple(_at([t for t in begun if t.modality == one], one, "") for one in modalities),
        saw={
            name: dict(Counter(_said(trial.facts[name]) for trial in own if name in trial.facts))
            for name in _SAW
            if any(name in trial.facts for trial in own)
        },
    )


def _said(value: Fact) -> str:
    return ("no", "yes")[value] if isinstance(value, bool) else str(value)


def _success(begun: Sequence[Trial]) -> ClusteredProportion:
    """The share of ended trials that were solved, with an interval that holds whatever became of broken ones."""

    def share(trials: Sequence[Trial], broken: bool) -> ClusteredProportion:
        person, luck = _labels(trials)
        solved = [broken if trial.ending == "error" else trial.solved for trial in trials]
        return crossed_proportion(solved, np.ones(len(trials)), person, luck)

    return replace(share(ended(begun), False), low=share(begun, False).low, high=share(begun, True).high)


def _positions(trials: Sequence[Trial]) -> Iterable[AtPosition]:
    by: dict[int, list[bool]] = {}
    for trial in trials:
        position = trial.facts.get("position")
        if isinstance(position, int):
            by.setdefault(position, []).append(trial.solved)
    for position in sorted(by):
        yield AtPosition(position=position, success=proportion(sum(by[position]), len(by[position])))


def _at(begun: Sequence[Trial], modality: str, condition: str) -> PeopleAt:
    trials = ended(begun)
    return PeopleAt(
        modality=modality,
        condition=condition,
        people=len({trial.agent for trial in trials}),
        success=_success(begun),
        steps=_steps_of(trials, modality, condition),
    )


def _steps_of(trials: Sequence[Trial], modality: str, condition: str) -> Steps:
    """Steps that people needed in ended trials, at least one, of a modality and a condition (empty for several)."""
    reached, budget = _reached(trials)
    shares = reached.mean(axis=0)
    drawn = _drawn(trials, _stream(trials[0], trials[0].spec, modality, condition), reached)
    low = high = None
    if drawn:
        medians = [_median(one) for one in drawn]
        low = _within(min(float(np.percentile(of, 2.5, method="lower")) for of in medians), budget)
        high = _within(max(float(np.percentile(of, 97.5, method="higher")) for of in medians), budget)
    return Steps(median=_within(float(_median(shares)), budget), low=low, high=high, mean=float(_mean(shares)))


def _labels(trials: Sequence[Trial]) -> tuple[Labels, Labels]:
    """The player and the luck of each trial, numbered from 0."""
    names = [trial.agent for trial in trials], [f"{trial.repetition}/{trial.trial}" for trial in trials]
    person, luck = (np.unique(of, return_inverse=True)[1].reshape(-1).astype(np.int64) for of in names)
    return person, luck


def _reached(trials: Sequence[Trial]) -> tuple[Array, int]:
    """Whether each trial was solved by step 0, 1, ... up to the budget, shape (trials, budget + 1); and the budget."""
    budget = max(trial.budget for trial in trials)
    steps = np.array([len(trial.steps) if trial.solved else budget + 1 for trial in trials])
    return (steps[:, None] <= np.arange(budget + 1)).astype(np.float64), budget


def _drawn(trials: Sequence[Trial], rng: np.random.Generator, reached: Array) -> list[Array]:
    """Shares solved by each step in two cluster bootstraps: over people, and over luck.

    No bootstrap keeps two crossed kinds of clusters, so each kind is resampled alone, and the wider interval is used.
    If people have unequally many trials, they are resampled once more with every person counted alike, since those who
    left early may differ from those who stayed.

    Args:
        trials: The trials of people.
        rng: The stream of the draws.
        reached: Values of these trials, of shape (trials, steps).

    Returns:
        For each way of resampling, shares of shape (resamples, steps); empty with a single person or luck.
    """
    kinds = _labels(trials)
    if min(len(np.unique(kind)) for kind in kinds) < 2:
        return []
    boxes = np.bincount(kinds[0])
    ways = [(kind, np.ones(len(kind))) for kind in kinds]
    if np.ptp(boxes):
        ways.append((kinds[0], 1 / boxes[kinds[0]]))
    found = []
    for kind, weight in ways:
        k = int(kind.max()) + 1
        times = rng.multinomial(k, np.full(k, 1 / k), size=RESAMPLES).astype(np.float64)
        sums = np.zeros((k, reached.shape[1]))
        np.add.at(sums, kind, weight[:, None] * reached)
        found.append(times @ sums / (times @ np.bincount(kind, weight))[:, None])
    return found


def _median(shares: Array) -> NDArray[np.int64]:
    """The first step by which half are solved; the budget plus 1 if that never happens."""
    found: NDArray[np.int64] = np.sum(shares < 0.5 - 1e-12, axis=-1)
    return found


def _mean(shares: Array) -> Array:
    found: Array = np.sum(1 - shares[..., :-1], axis=-1)
    return found


def _within(step: float, budget: int) -> int | None:
    return int(step) if step <= budget else None


def _stream(first: Trial, agent: str, modality: str, condition: str) -> np.random.Generator:
    """The stream of one number. That of a condition of flips alone is named after its rate, whatever its label is."""
    place = (condition if first.p is None else str(first.p)) if condition else "None"
    return generator(first.seed, "analysis", agent, modality, place, "people")

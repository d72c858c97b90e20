"""Agents' steps relative to people's on the same trials, as ratios of Kaplan-Meier medians.

An unsolved trial is censored at its budget, so failures do not look fast. A ratio of 2 means twice the steps of people.
ARC-AGI-3 scores the inverse, squared.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.seeds import generator
from lockprobe.trial.record import Trial

__all__ = ["RelativeSteps", "Steps", "labels", "relative_steps", "steps_of"]

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
class RelativeSteps:
    """An agent's steps relative to those of people, on the trials that both finished.

    Attributes:
        agent: Its name, or its spec if it has none.
        modality: How the box was shown to both.
        condition: Label of the condition; empty for all together.
        trials: Trials that both finished.
        steps: The agent's median (Kaplan-Meier); None if it solved fewer than half.
        people: People's median on the same trials; None if people solved fewer than half.
        ratio: ``steps`` over ``people``; None if either is missing.
        least: Lower bound of the ratio if only the agent's median lies beyond the budget; else None.
        most: Upper bound of the ratio if only people's median lies beyond the budget; else None.
        low, high: Ends of the ratio's 95 % interval; None where it is open or unknown.
        mean_ratio: Ratio of mean steps, unsolved trials counted with the whole budget; it always exists.
        mean_low, mean_high: Ends of its 95 % interval; None with fewer than two people.
    """

    agent: str
    modality: str
    condition: str
    trials: int
    steps: int | None
    people: int | None
    ratio: float | None
    least: float | None
    most: float | None
    low: float | None
    high: float | None
    mean_ratio: float
    mean_low: float | None
    mean_high: float | None


def steps_of(trials: Sequence[Trial], modality: str, condition: str) -> Steps:
    """Steps that people needed in ended trials, at least one, of a modality and a condition (empty for several)."""
    reached, budget = _reached(trials)
    shares = reached.mean(axis=0)
    drawn = _drawn(trials, _stream(trials[0], trials[0].spec, modality, condition), [reached])
    low = high = None
    if drawn:
        medians = [_median(one[0]) for one in drawn]
        low = _within(min(float(np.percentile(of, 2.5, method="lower")) for of in medians), budget)
        high = _within(max(float(np.percentile(of, 97.5, method="higher")) for of in medians), budget)
    return Steps(median=_within(float(_median(shares)), budget), low=low, high=high, mean=float(_mean(shares)))


def labels(trials: Sequence[Trial]) -> tuple[Labels, Labels]:
    """The player and the luck of each trial, numbered from 0."""
    names = [trial.agent for trial in trials], [f"{trial.repetition}/{trial.trial}" for trial in trials]
    person, luck = (np.unique(of, return_inverse=True)[1].reshape(-1).astype(np.int64) for of in names)
    return person, luck


def relative_steps(
    counted: Sequence[Trial], own: Sequence[Trial], conditions: Mapping[str, str]
) -> Iterable[RelativeSteps]:
    """Every agent's steps relative to people's, for each modality: by condition, then over all where there are several.

    Steps are compared on the trials that people finished: the same panel, labels and interventions.

    Args:
        counted: All ended trials.
        own: The trials of people among them.
        conditions: Label of a condition that people played -> its modality.
    """
    agents = dict.fromkeys(trial.group for trial in counted if not trial.player)
    by_modality = grouped(conditions, conditions.__getitem__)
    slots = {_slot(trial): trial for trial in own}
    for agent, (modality, labelled) in product(agents, by_modality.items()):
        pairs = [
            (trial, slots[_slot(trial)])
            for trial in counted
            if trial.group == agent and trial.modality == modality and _slot(trial) in slots
        ]
        for condition in [*labelled, *([""] if len(labelled) > 1 else [])]:
            if here := [pair for pair in pairs if condition in ("", pair[0].condition)]:
                yield _relative(here, agent, modality, condition)


def _slot(trial: Trial) -> tuple[str, int, int]:
    return trial.condition, trial.repetition, trial.trial


def _relative(pairs: Sequence[tuple[Trial, Trial]], agent: str, modality: str, condition: str) -> RelativeSteps:
    theirs = [person for _, person in pairs]
    (own, budget), (people_reached, _) = _reached([trial for trial, _ in pairs]), _reached(theirs)
    both = _median(own.mean(axis=0)), _median(people_reached.mean(axis=0))
    steps, human = (_within(float(of), budget) for of in both)
    low, high, mean_low, mean_high = _intervals(
        _drawn(theirs, _stream(theirs[0], pairs[0][0].spec, modality, condition), [own, people_reached]), budget
    )
    told = steps is not None or human is not None
    return RelativeSteps(
        agent=agent,
        modality=modality,
        condition=condition,
        trials=len(pairs),
        steps=steps,
        people=human,
        ratio=steps / human if steps is not None and human is not None else None,
        least=float(both[0] / both[1]) if steps is None and human is not None else None,
        most=float(both[0] / both[1]) if human is None and steps is not None else None,
        low=low if told else None,
        high=high if told else None,
        mean_ratio=float(_mean(own.mean(axis=0)) / _mean(people_reached.mean(axis=0))),
        mean_low=mean_low,
        mean_high=mean_high,
    )


def _intervals(drawn: Sequence[Sequence[Array]], budget: int) -> tuple[float | None, ...]:
    """Interval ends of the ratios of medians and of means; None where a median lies beyond the budget too often."""
    if not drawn:
        return None, None, None, None
    lows, highs, means = [], [], []
    for own, human in drawn:
        one, two = _median(own), _median(human)
        lows.append(float(np.percentile(np.where(two > budget, 0.0, one / two), 2.5, method="lower")))
        highs.append(float(np.percentile(np.where(one > budget, math.inf, one / two), 97.5, method="higher")))
        means.append(np.percentile(_mean(own) / _mean(human), [2.5, 97.5]))
    low, high = min(lows), max(highs)
    return (
        low or None,
        high if math.isfinite(high) else None,
        float(min(ends[0] for ends in means)),
        float(max(ends[1] for ends in means)),
    )


def _reached(trials: Sequence[Trial]) -> tuple[Array, int]:
    """Whether each trial was solved by step 0, 1, ... up to the budget, shape (trials, budget + 1); and the budget."""
    budget = max(trial.budget for trial in trials)
    steps = np.array([len(trial.steps) if trial.solved else budget + 1 for trial in trials])
    return (steps[:, None] <= np.arange(budget + 1)).astype(np.float64), budget


def _drawn(theirs: Sequence[Trial], rng: np.random.Generator, groups: Sequence[Array]) -> list[list[Array]]:
    """Shares solved by each step in two cluster bootstraps: over people, and over luck.

    No bootstrap keeps two crossed kinds of clusters, so each kind is resampled alone, and the wider interval is used.
    If people have unequally many trials, they are resampled once more with every person counted alike, since those who
    left early may differ from those who stayed.

    Args:
        theirs: The trials of people.
        rng: The stream of the draws.
        groups: Values of these trials, each of shape (trials, steps).

    Returns:
        For each way of resampling and group, shares of shape (resamples, steps); empty with a single person or luck.
    """
    kinds = labels(theirs)
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
        n = times @ np.bincount(kind, weight)
        shares = []
        for group in groups:
            sums = np.zeros((k, group.shape[1]))
            np.add.at(sums, kind, weight[:, None] * group)
            shares.append(times @ sums / n[:, None])
        found.append(shares)
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

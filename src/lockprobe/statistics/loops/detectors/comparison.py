"""All loop detectors compared on random trials, with a planted loop and without.

Trials have 20 steps over 4 actions. Outside its planted loop an agent acts at random without immediate repeats.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.formatting import markdown_table
from lockprobe.foundation.seeds import generator
from lockprobe.statistics.loops.detectors.catalogue import DETECTORS, Detector
from lockprobe.statistics.loops.detectors.verdicts import threshold

__all__ = [
    "PLANTED",
    "Kind",
    "Made",
    "Row",
    "as_table",
    "comparison",
    "interrupted",
    "microseconds",
    "plant",
    "unplanted",
]

STEPS, ACTIONS = 20, 4

MOVES = 0.5
"""Probability that an attempt moves its joint; on chain-4 a random agent's attempts do in 48 of 100."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """A kind of planted loop.

    Attributes:
        name: In words.
        period: Distinct actions that are repeated in one order.
        copies: Number of repetitions.
        mutation: Probability that a planted action is replaced by another one.
    """

    name: str
    period: int
    copies: int
    mutation: float = 0.0

    @property
    def length(self) -> int:
        """Planted steps."""
        return self.period * self.copies


PLANTED = (
    Kind(name="A x6", period=1, copies=6),
    Kind(name="period 2 x4", period=2, copies=4),
    Kind(name="period 3 x3", period=3, copies=3),
    Kind(name="period 4 x3", period=4, copies=3),
    Kind(name="period 4 x3, 10 % mutated", period=4, copies=3, mutation=0.1),
    Kind(name="period 4 x5", period=4, copies=5),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Made:
    """Simulated trials, with or without a planted loop.

    Attributes:
        actions: Shape (trials, 20).
        moved: Whether each attempt moved its joint, shape (trials, 20).
        middle: Steps before the middle of the planted loop, shape (trials,); without one, of the whole trial.
    """

    actions: NDArray[np.int64]
    moved: NDArray[np.bool_]
    middle: NDArray[np.int64]


def unplanted(trials: int, rng: Generator, *, repeats: bool) -> Made:
    """Random trials without a planted loop, with or without immediate repeats."""
    turns = rng.integers(0 if repeats else 1, ACTIONS, (trials, STEPS))
    moved = rng.random((trials, STEPS)) < MOVES
    return Made(actions=turns.cumsum(axis=1) % ACTIONS, moved=moved, middle=np.full(trials, STEPS // 2))


def plant(kind: Kind, trials: int, rng: Generator) -> Made:
    """Random trials with a loop at a random place.

    Every copy of the loop meets the same outcomes. A mutated action differs from the one it replaces and from its
    neighbours, and its outcome is drawn again.
    """
    starts = rng.integers(0, STEPS - kind.length + 1, trials)
    words = rng.permuted(np.tile(np.arange(ACTIONS), (trials, 1)), axis=1)[:, : kind.period]
    loops = np.tile(words, kind.copies)
    # A trial is the sum of its turns: those inside the loop are the loop's, all others are random.
    turns = rng.integers(1, ACTIONS, (trials, STEPS))
    moved = rng.random((trials, STEPS)) < MOVES
    rows, places = np.arange(trials)[:, None], starts[:, None] + np.arange(kind.length)
    turns[rows, places[:, 1:]] = np.diff(loops) % ACTIONS
    moved[rows, places] = moved[rows, places[:, np.arange(kind.length) % kind.period]]
    actions = turns.cumsum(axis=1) % ACTIONS
    mutated = rng.random(places.shape) < kind.mutation
    for row, column in zip(*np.nonzero(mutated), strict=True):
        at = places[row, column]
        actions[row, at] = _other(actions[row, max(at - 1, 0) : at + 2].tolist(), rng)
        moved[row, at] = rng.random() < MOVES
    return Made(actions=actions, moved=moved, middle=starts + kind.length // 2)


def interrupted(made: Made, rng: Generator) -> tuple[list[list[int]], list[list[bool]]]:
    """The trials with two other actions in the middle of the loop, and their outcomes.

    Each added action differs from its neighbours.
    """
    actions, moved = made.actions.tolist(), made.moved.tolist()
    for row, went, middle in zip(actions, moved, made.middle.tolist(), strict=True):
        first = _other(row[middle - 1 : middle + 1], rng)
        row[middle:middle] = [first, _other([first, row[middle]], rng)]
        went[middle:middle] = (rng.random(2) < MOVES).tolist()
    return actions, moved


def _other(taken: list[int], rng: Generator) -> int:
    """An action that is not taken."""
    return int(rng.choice([action for action in range(ACTIONS) if action not in taken]))


PROBES = 100
"""Trials per kind that are relabelled, reversed and interrupted."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """The error rates of one detector. All shares are in [0, 1].

    Attributes:
        detector: Its name.
        false_uniform: Share of uniformly random trials that it flags.
        false_no_repeat: Share of random trials without immediate repeats that it flags; 5 % is intended for scores.
        auc: Planted kind -> probability that a trial with the loop scores higher than a random one without
            immediate repeats, ties counted half; 0.5 is no better than chance.
        found: Planted kind -> share of trials that it flags.
        relabelled: Of the planted trials that it flags, the share still flagged when the actions are renamed;
            None if it flags none.
        reversed: The same share when the trial is played backwards.
        interrupted: The same share with two other actions in the middle of the loop.
    """

    detector: str
    false_uniform: float
    false_no_repeat: float
    auc: Mapping[str, float]
    found: Mapping[str, float]
    relabelled: float | None
    reversed: float | None
    interrupted: float | None


def comparison(trials_per_kind: int = 1000, seed: int = 0) -> tuple[Row, ...]:
    """Compare every detector on random trials and planted loops, 20 of each kind or more; equal seeds, equal rows."""
    if trials_per_kind < 20:
        raise BadValue("trials per kind", trials_per_kind, "at least 20")
    uniform = unplanted(trials_per_kind, generator(seed, "detectors", "uniform"), repeats=True)
    no_repeat = unplanted(trials_per_kind, generator(seed, "detectors", "no-repeat"), repeats=False)
    planted = {kind.name: plant(kind, trials_per_kind, generator(seed, "detectors", kind.name)) for kind in PLANTED}
    probes = _probes(list(planted.values()), seed)
    return tuple(_row(detector, uniform, no_repeat, planted, probes) for detector in DETECTORS)


Trials = Sequence[tuple[list[int], list[bool]]]
"""Actions and outcomes of each trial."""


def _row(detector: Detector, uniform: Made, no_repeat: Made, planted: Mapping[str, Made], probes: list[Trials]) -> Row:
    negatives = _scores(detector, _trials(no_repeat))
    positives = {name: _scores(detector, _trials(made)) for name, made in planted.items()}
    before, *after = (_scores(detector, trials) > _threshold(detector, trials) for trials in probes)
    kept = [float(flagged[before].mean()) if before.any() else None for flagged in after]
    limit = _threshold(detector, probes[0])
    return Row(
        detector=detector.name,
        false_uniform=float((_scores(detector, _trials(uniform)) > limit).mean()),
        false_no_repeat=float((negatives > limit).mean()),
        auc={name: _auc(scores, negatives) for name, scores in positives.items()},
        found={name: float((scores > limit).mean()) for name, scores in positives.items()},
        relabelled=kept[0],
        reversed=kept[1],
        interrupted=kept[2],
    )


def _probes(planted: Sequence[Made], seed: int) -> list[Trials]:
    """Some planted trials of each kind: unchanged, renamed, reversed, interrupted."""
    rng = generator(seed, "detectors", "probes")
    some = Made(
        actions=np.concatenate([made.actions[:PROBES] for made in planted]),
        moved=np.concatenate([made.moved[:PROBES] for made in planted]),
        middle=np.concatenate([made.middle[:PROBES] for made in planted]),
    )
    plain = _trials(some)
    names = rng.permuted(np.tile(np.arange(ACTIONS), (len(plain), 1)), axis=1)
    renamed = np.take_along_axis(names, some.actions, axis=1).tolist()
    return [
        plain,
        list(zip(renamed, some.moved.tolist(), strict=True)),
        [(actions[::-1], moved[::-1]) for actions, moved in plain],
        list(zip(*interrupted(some, rng), strict=True)),
    ]


def _trials(made: Made) -> Trials:
    return list(zip(made.actions.tolist(), made.moved.tolist(), strict=True))


def _scores(detector: Detector, trials: Trials) -> NDArray[np.float64]:
    return np.array([detector.score(actions, moved) for actions, moved in trials])


def _threshold(detector: Detector, trials: Trials) -> float:
    return threshold(detector, len(trials[0][0]), ACTIONS)


def _auc(positives: NDArray[np.float64], negatives: NDArray[np.float64]) -> float:
    """Area under the ROC curve: Mann and Whitney's U over all pairs."""
    from scipy.stats import mannwhitneyu

    found = mannwhitneyu(positives, negatives, method="asymptotic")
    return float(found.statistic / (len(positives) * len(negatives)))


def microseconds(detector: Detector, trials: int = 200) -> float:
    """Mean processor time of one score over random trials of 20 steps, microseconds; it varies from run to run."""
    some = _trials(unplanted(trials, generator(0, "detectors", "clock"), repeats=False))
    begun = time.process_time()
    _scores(detector, some)
    return (time.process_time() - begun) / trials * 1e6


def as_table(rows: Sequence[Row], times: Mapping[str, float] | None = None) -> str:
    """The rows as a Markdown table; planted kinds as area under the curve [share flagged].

    With ``times``, microseconds per trial by detector, it has one more column.
    """
    head = ["detector", "false, uniform", "false, no repeat", *rows[0].auc, "renamed", "backwards", "interrupted"]
    lines = [
        [
            row.detector,
            f"{row.false_uniform:.3f}",
            f"{row.false_no_repeat:.3f}",
            *[f"{row.auc[name]:.2f} [{row.found[name]:.2f}]" for name in row.auc],
            *["-" if kept is None else f"{kept:.2f}" for kept in (row.relabelled, row.reversed, row.interrupted)],
        ]
        for row in rows
    ]
    if times is not None:
        head.append("µs")
        lines = [[*line, f"{times[row.detector]:.0f}"] for line, row in zip(lines, rows, strict=True)]
    return markdown_table(head, *lines, numbers=True)

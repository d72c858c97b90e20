"""All detectors on the same trials, of which the truth is known."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe.analysis.detectors.catalogue import DETECTORS, Detector
from lockprobe.analysis.detectors.planted import ACTIONS, PLANTED, Made, interrupted, plant, unplanted
from lockprobe.analysis.detectors.verdicts import threshold
from lockprobe.errors import BadValue
from lockprobe.seeds import generator

__all__ = ["Row", "as_table", "comparison", "microseconds"]

PROBES = 100
"""Trials per kind that are relabelled, reversed and interrupted."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """What one detector does. All shares are in [0, 1].

    Attributes:
        detector: Its name.
        false_uniform: Share of uniformly random trials that it flags.
        false_no_repeat: Share of random trials without immediate repeats that it flags; of scores 5 % is meant.
        auc: Planted kind -> probability that a trial with the loop scores higher than a random one without
            immediate repeats, ties counted half; 0.5 tells nothing apart.
        found: Planted kind -> share of trials that it flags.
        relabelled: Of the planted trials that it flags, the share still flagged when the actions are renamed;
            None if it flags none.
        reversed: The same when the trial is played backwards.
        interrupted: The same with two other actions in the middle of the loop.
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
    """Every detector on random trials and on planted loops; equal seeds give equal rows.

    Args:
        trials_per_kind: Random trials of each null, and trials of each planted kind (at least 20).
        seed: Of the trials.
    """
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
    """Some planted trials of each kind: as they are, renamed, backwards, interrupted."""
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
    """Area under the ROC curve: Mann and Whitney's U from mid-ranks, over all pairs."""
    from scipy.stats import rankdata

    ranks = rankdata(np.concatenate([positives, negatives]))[: len(positives)]
    n = len(positives)
    return float((ranks.sum() - n * (n + 1) / 2) / (n * len(negatives)))


def microseconds(detector: Detector, trials: int = 200) -> float:
    """Processor time of one score in microseconds, over random trials of 20 steps. A clock reading: it differs."""
    some = _trials(unplanted(trials, generator(0, "detectors", "clock"), repeats=False))
    begun = time.process_time()
    _scores(detector, some)
    return (time.process_time() - begun) / trials * 1e6


def as_table(rows: Sequence[Row], times: Mapping[str, float] | None = None) -> str:
    """The rows as a Markdown table; planted kinds as area under the curve [share flagged].

    Args:
        rows: What was found.
        times: Microseconds per trial by detector, for one column more.
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
    table = [head, ["---", *["---:"] * (len(head) - 1)], *lines]
    return "\n".join("| " + " | ".join(line) + " |" for line in table)

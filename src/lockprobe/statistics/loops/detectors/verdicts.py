"""Which trials a detector flags, with the scores' thresholds set to 5 % false positives.

A false positive is a flagged trial of an agent that acts at random without immediate repeats, in trials of the same
length. Rules keep the thresholds of their frameworks.
"""

from __future__ import annotations

import json
from collections.abc import Hashable, Sequence
from functools import cache, lru_cache
from importlib.resources import files
from math import ceil
from statistics import fmean

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.seeds import generator
from lockprobe.statistics.loops.detectors.catalogue import DETECTORS, Detector
from lockprobe.statistics.loops.words import letters
from lockprobe.statistics.outcomes import ended
from lockprobe.trial.record import Trial

__all__ = ["calibrated", "flags", "score", "share_flagged", "threshold"]

FALSE_POSITIVES = 0.05

CALIBRATION = 500
"""Random trials per threshold: the true share of false positives is within 2 points of the nominal one."""

LONGEST = 100
"""Steps that a score uses; of a longer trial it uses the beginning."""

_KNOWN_ACTIONS = 4
"""Joints of the box whose thresholds are in the table."""


def threshold(detector: Detector, length: int, actions: int = 4) -> float:
    """The score above which a trial of this length is flagged; 0 for a rule.

    Those of usual trials come from ``thresholds.json``, made by ``scripts/make_detector_thresholds.py``.

    Args:
        detector: One of the detectors.
        length: Steps in the trial (at most 100, which is all that a score looks at).
        actions: Actions to choose from (at least 2).
    """
    if detector.rule:
        return 0.0
    if actions < 2:
        raise BadValue("actions", actions, "at least 2")
    if not 0 <= length <= LONGEST:
        raise BadValue("length of the trial", length, f"0 to {LONGEST} steps")
    known = _known().get(detector.name, ()) if actions == _KNOWN_ACTIONS else ()
    return known[length] if length < len(known) else calibrated(detector, length, actions)


@cache
def _known() -> dict[str, list[float]]:
    """Score -> its thresholds on a box of four joints, by length from 0."""
    text = files("lockprobe.statistics.loops.detectors").joinpath("thresholds.json").read_text(encoding="utf-8")
    found: dict[str, list[float]] = json.loads(text)
    return found


@cache
def calibrated(detector: Detector, length: int, actions: int) -> float:
    """The threshold of a score, from random trials."""
    scores = sorted(detector.score(trial, ()) for trial in _random_trials(length, actions))
    return scores[ceil((1 - FALSE_POSITIVES) * CALIBRATION) - 1]


@lru_cache(maxsize=32)
def _random_trials(length: int, actions: int) -> list[str]:
    """Trials without immediate repeats on which all scores of this length are calibrated."""
    rng = generator(0, "detectors", length, actions)
    trials = rng.integers(1, actions, (CALIBRATION, length)).cumsum(axis=1) % actions
    return [letters(trial) for trial in trials.tolist()]


def score(detector: Detector, actions: Sequence[Hashable], moved: Sequence[bool]) -> float:
    """A detector's score of a trial. Rules look at all of it, scores at its first 100 steps."""
    if detector.rule or len(actions) <= LONGEST:
        return detector.score(actions, moved)
    return detector.score(actions[:LONGEST], moved[:LONGEST])


def flags(detector: Detector, actions: Sequence[Hashable], moved: Sequence[bool], *, joints: int = 4) -> bool:
    """Whether a detector flags a trial.

    Args:
        detector: One of the detectors.
        actions: The actions in order.
        moved: Whether each moved its joint as the agent was told; may be empty for most detectors.
        joints: Number of actions to choose from.
    """
    return score(detector, actions, moved) > threshold(detector, min(len(actions), LONGEST), joints)


def share_flagged(trials: Sequence[Trial], detectors: Sequence[Detector] = DETECTORS) -> dict[str, float]:
    """The share of trials that each detector flags, by its name; empty without trials. Error trials are left out."""
    counted = [
        (letters(trial.actions), [bool(step.told_moved) for step in trial.steps], len(trial.joints))
        for trial in ended(trials)
    ]
    if not counted:
        return {}
    return {
        detector.name: fmean(flags(detector, actions, moved, joints=joints) for actions, moved, joints in counted)
        for detector in detectors
    }

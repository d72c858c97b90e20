"""Error rates of a robot's verdicts on its attempts: verdicts from force and path, compared with the truth."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

from lockprobe.statistics.clustered import ClusteredProportion, clustered_proportion
from lockprobe.trial.record import Step, Trial

__all__ = ["Verdicts", "verdicts"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdicts:
    """A robot's verdicts over all trials, clustered by luck. Agents are told the truth, not these verdicts.

    Attributes:
        attempts: Steps with a verdict.
        failed: Steps without a grip on the handle or without a conclusion.
        wrong: Share of the verdicts "moved" and "blocked" that contradict the truth.
        moved_for_blocked: Wrong verdicts "moved".
        blocked_for_moved: Wrong verdicts "blocked".
    """

    attempts: int
    failed: int
    wrong: ClusteredProportion
    moved_for_blocked: int
    blocked_for_moved: int


def verdicts(trials: Sequence[Trial]) -> Verdicts | None:
    """Count a robot's verdicts, including trials that broke later; None if no step has a verdict."""
    by_luck: dict[tuple[int, int], list[Step]] = defaultdict(list)
    for trial in trials:
        by_luck[trial.repetition, trial.trial] += [step for step in trial.steps if "verdict" in step.sensed]
    steps = [step for members in by_luck.values() for step in members]
    if not steps:
        return None
    told = [
        [step for step in members if step.sensed["verdict"] in ("moved", "blocked")] for members in by_luck.values()
    ]
    wrong = [[step for step in members if (step.sensed["verdict"] == "moved") != step.moved] for members in told]
    return Verdicts(
        attempts=len(steps),
        failed=len(steps) - sum(map(len, told)),
        wrong=clustered_proportion(list(map(len, wrong)), list(map(len, told))),
        moved_for_blocked=sum(not step.moved for members in wrong for step in members),
        blocked_for_moved=sum(step.moved for members in wrong for step in members),
    )

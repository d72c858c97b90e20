"""Does an agent heed what it is told? One that never does plays the same trials under every condition."""

from __future__ import annotations

from collections.abc import Sequence

from lockprobe.analysis.outcomes import ended
from lockprobe.record import Trial

__all__ = ["REPORTS", "ignores_reports"]

REPORTS = 10
"""Reports that differ between conditions, each with an action after it, before an agent is said to ignore them."""


def ignores_reports(trials: Sequence[Trial]) -> bool:
    """Whether the same repetition and trial went alike at every p, though the agent had been told otherwise.

    What counts are reports that were followed by another action: of the last report of a trial nobody can say what it
    would have done. They have to be ``REPORTS`` at least, since an agent may act alike for once after a false report.
    Where several play as one agent it is never blind: another one played each p.
    """
    if trials[0].player:
        return False
    acted: dict[tuple[int, int], set[tuple[str, ...]]] = {}
    told: dict[tuple[int, int], list[tuple[object, ...]]] = {}
    for trial in ended(trials):
        luck = trial.repetition, trial.trial
        acted.setdefault(luck, set()).add(trial.actions)
        told.setdefault(luck, []).append(tuple((step.told_moved, step.told_state) for step in trial.steps[:-1]))
    if any(len(ways) > 1 for ways in acted.values()):
        return False
    differing = sum(len(set(reports)) > 1 for ways in told.values() for reports in zip(*ways, strict=False))
    return differing >= REPORTS

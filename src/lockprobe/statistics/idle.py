"""What the interventions of a condition changed, and conditions that changed nothing: these are no null results."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from lockprobe.foundation.spec import spec_name
from lockprobe.statistics.outcomes import ended
from lockprobe.trial.condition import PLANT
from lockprobe.trial.record import Trial


def steps_changed(trials: Sequence[Trial]) -> Counter[str] | None:
    """Spec of every intervention -> the steps of ended trials that it changed; "" -> those that any of them changed.

    At such a step the agent was told, asked or remembered something else than without it, or another joint than the
    chosen one was attempted. None if some record does not say, or no trial has ended.
    """
    counted = ended(trials)
    if len({tuple(trial.changed) for trial in counted}) != 1:
        return None
    found = Counter({"": sum(trial.changed_steps for trial in counted)})
    for trial in counted:
        found.update(trial.changed)
    return found


def never_acted(trials: Sequence[Trial]) -> bool:
    """Whether interventions of a condition changed nothing, or it has a flip rate above 0 and no report was false."""
    found, steps = steps_changed(trials), [step for trial in ended(trials) for step in trial.steps]
    if not found or len(found) == 1 or not steps:
        return False
    return not found[""] or (bool(trials[0].p) and not any(step.told_falsely for step in steps))


def idle_interventions(trials: Sequence[Trial], acting: Sequence[str]) -> list[str]:
    """What changed nothing: "" for the condition as a whole, or some of its interventions that should act."""
    found = steps_changed(trials)
    if not found or len(found) == 1 or not any(trial.steps for trial in ended(trials)):
        return []
    if not found[""] and not any(spec_name(spec) == PLANT for spec in acting):
        return [""]
    return [spec for spec in acting if found.get(spec) == 0]

"""A policy of no known family, and a trial on record in the terms of a population."""

from dataclasses import dataclass

from lockprobe.agents.policy import Policy


@dataclass(frozen=True, kw_only=True)
class Diary(Policy[tuple]):
    """Remembers every report, and lets the last one bear on its choice; of no family that is known elsewhere."""

    def begin(self, view):
        return ()

    def remember(self, view, memory, told):
        return (*memory, told)

    def probabilities(self, view, memory):
        weights = [1.0 + j for j in range(view.joints)]
        for told in memory[-2:]:
            weights[(told.joint + told.moved + (told.shifted or 0)) % view.joints] += 4
        return tuple(weight / sum(weights) for weight in weights)


def as_recorded(trial):
    """Joints by place in panel order, whether they moved, what was told of it."""
    joints = [trial.joints.index(step.joint) for step in trial.steps]
    return joints, [step.moved for step in trial.steps], [step.told_moved for step in trial.steps], trial.solved

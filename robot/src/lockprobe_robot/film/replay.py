"""Plays recorded trials again: the plant is built anew from its spec and its stream, and each step is compared."""

from __future__ import annotations

from collections.abc import Iterator

from lockprobe.boxes.box import bits
from lockprobe.foundation.errors import BadFile, TrialFault
from lockprobe.studies.study import Study
from lockprobe.trial.plan import Plan
from lockprobe.trial.protocols import Plant
from lockprobe.trial.record import Fact, Snapshot, Trial


def plan_of(study: Study, trial: Trial) -> Plan:
    """The plan of a recorded trial.

    Raises:
        BadFile: If the study's settings have no such trial.
    """
    for plan in study.plans(trial.agent):
        if plan.key == trial.key and (plan.box.names, plan.names.labels) == (trial.joints, trial.labels):
            return plan
    raise BadFile("study.json", f"its settings do not describe the trial {trial.key}")


def played_again(trial: Trial, plant: Plant) -> Iterator[tuple[int, Snapshot, str | None]]:
    """Play a recorded trial again on a plant, which is closed in the end.

    Yields:
        The step, from 0, or -1 for the beginning; what is seen after it; the first difference of what was played from
        the record, in one line, or None.

    Raises:
        TrialFault: If it breaks, and did not at the same boundary then.
    """
    differs: str | None = None
    try:
        snapshot = plant.observe()
        yield -1, snapshot, None
        for at, step in enumerate(trial.steps):
            before, snapshot = bits(snapshot.configuration), plant.attempt(trial.joints.index(step.joint))
            pairs: list[tuple[str, Fact, Fact]] = [
                ("configuration before it", step.state, before),
                ("outcome", "moved" if step.moved else "blocked", snapshot.outcome),
            ]
            if "verdict" in step.sensed and "verdict" in snapshot.sensed:
                pairs.append(("robot's verdict", step.sensed["verdict"], snapshot.sensed["verdict"]))
            for what, recorded, replayed in pairs:
                if recorded != replayed and differs is None:
                    differs = f"step {at + 1} differs from the record: {what} {recorded} there, {replayed} here"
            yield at, snapshot, differs
    except TrialFault as fault:
        if trial.error is None or trial.error.boundary != fault.boundary:
            raise
    finally:
        plant.close()

"""A trial as one line of JSON and back. What is read is checked: an impossible record is refused, not analysed."""

from __future__ import annotations

import math

from pydantic import TypeAdapter, ValidationError

from lockprobe.errors import BadValue
from lockprobe.record import SCHEMA_VERSION, Step, Trial

__all__ = ["trial_from_json", "trial_to_json"]

_adapter: TypeAdapter[Trial] = TypeAdapter(Trial)


def trial_to_json(trial: Trial) -> bytes:
    """One line of JSON without a newline; fields at their defaults are left out, the schema version never is."""
    line = _adapter.dump_json(trial, exclude_defaults=True)
    return line[:-1] + b',"schema":%d}' % trial.schema if b'"schema":' not in line else line


def trial_from_json(line: bytes | str) -> Trial:
    """The trial on one line of a journal.

    Raises:
        BadValue: If the line is no trial, of a schema version that this release does not know, or impossible.
    """
    try:
        trial = _adapter.validate_json(line)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise BadValue("trial record", where or "line", f"a trial ({first['msg']})") from error
    if trial.schema != SCHEMA_VERSION:
        raise BadValue("trial record, schema version", trial.schema, str(SCHEMA_VERSION))
    _check(trial)
    return trial


def _check(trial: Trial) -> None:
    """Refuses what cannot have happened."""
    if not 0 <= trial.p <= 1:  # a number that is none fails too
        raise BadValue("trial record, p", trial.p, "a number from 0 to 1")
    if trial.target not in trial.joints:
        raise BadValue("trial record, target", trial.target, f"one of the joints {', '.join(trial.joints)}")
    if len(trial.steps) > trial.budget:
        raise BadValue("trial record, steps", len(trial.steps), f"at most the budget of {trial.budget}")
    if trial.ending != "error" and not trial.steps:
        raise BadValue("trial record, steps", 0, f"at least one in a trial that ended as {trial.ending}")
    for number, step in enumerate(trial.steps, 1):
        _check_step(trial, step, number)
    reached = bool(trial.steps) and trial.steps[-1].moved and trial.steps[-1].joint == trial.target
    if trial.solved and not reached:
        raise BadValue("trial record, ending", "solved", "a last step that moved the target")


def _check_step(trial: Trial, step: Step, number: int) -> None:
    where = f"trial record, step {number}"
    if step.step != number:
        raise BadValue(f"{where}, number", step.step, str(number))
    if step.joint not in trial.joints:
        raise BadValue(f"{where}, joint", step.joint, f"one of {', '.join(trial.joints)}")
    if len(step.state) != len(trial.joints) or not set(step.state) <= {"0", "1"}:
        raise BadValue(f"{where}, state", step.state, f"{len(trial.joints)} positions, each 0 or 1")
    if not all(math.isfinite(chance) for chance in step.decision.probabilities or ()):
        raise BadValue(f"{where}, probabilities", step.decision.probabilities, "numbers from 0 to 1")

"""Writes a trial as one line of JSON and reads it back. Impossible records are refused, not analysed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pydantic import TypeAdapter, ValidationError

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.terminal_text import one_line
from lockprobe.foundation.validation import check_choice, check_probability
from lockprobe.trial.pictures.picture import PICTURE_NAME, PictureKind
from lockprobe.trial.record import Fact, Step, Trial
from lockprobe.trial.source import CAMERA, UNCLEAR, is_reading

_adapter: TypeAdapter[Trial] = TypeAdapter(Trial)

LONGEST = 10_000
"""The most steps of a trial."""


def trial_to_json(trial: Trial) -> bytes:
    """One line of JSON without a newline; fields at their defaults are left out."""
    return one_line(_adapter.dump_json(trial, exclude_defaults=True))


def trial_from_json(line: bytes | str) -> Trial:
    """The trial on one line as :func:`trial_to_json` makes it.

    Raises:
        BadValue: If the line is not a trial, or is impossible.
    """
    try:
        trial = _adapter.validate_json(line, strict=True, extra="forbid")
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise BadValue("trial record", where or "line", f"a trial ({first['msg']})") from error
    _check(trial)
    return trial


def _check(trial: Trial) -> None:
    """Refuse a record of something that cannot have happened."""
    if trial.target not in trial.joints:
        raise BadValue("trial record, target", trial.target, f"one of the joints {', '.join(trial.joints)}")
    if not (len(trial.joints) == len(trial.labels) and sorted(trial.labels) == sorted(trial.listing)):
        raise BadValue("trial record, labels", trial.labels, f"one for each of {len(trial.joints)} joints, each listed")
    _check_pictures("trial record", trial.opening_pictures)
    _check_reading("trial record", trial.opening_sensed, len(trial.joints))
    for step in trial.steps:
        check_step(step, trial.joints, trial.labels)
    check_whole(trial)


def check_whole(trial: Trial) -> None:
    """Refuse parts of a record that are possible and do not fit each other.

    Raises:
        BadValue: If its key, its steps, their changes or its ending contradict the rest.
    """
    _check_name(trial)
    if not len(trial.steps) <= trial.budget <= LONGEST:
        raise BadValue("trial record, steps", len(trial.steps), f"at most the budget of {min(trial.budget, LONGEST)}")
    for number, step in enumerate(trial.steps, 1):
        if step.step != number:
            raise BadValue(f"trial record, step {number}, number", step.step, str(number))
    for spec, count in (*trial.changed.items(), ("all together", trial.changed_steps)):
        if not 0 <= count <= len(trial.steps):
            raise BadValue(f"trial record, steps changed by {spec}", count, f"0 to {len(trial.steps)}, its steps")
    _check_ending(trial)


def _check_name(trial: Trial) -> None:
    """Check that its key is the one of its fields, so that no two trials of a study share a key."""
    if trial.fork is not None and trial.fork.parent != str(trial.name):
        raise BadValue("trial record, fork of", trial.fork.parent, str(trial.name))
    if trial.key != (expected := str(trial.fork or trial.name)):
        raise BadValue("trial record, key", trial.key, expected)
    if trial.p is not None:
        check_probability("trial record, flip.p", trial.p)


def _check_pictures(where: str, pictures: Mapping[PictureKind, str]) -> None:
    """Refuse names of pictures that are not hashes, so that no record points outside its directory."""
    for kind, name in pictures.items():
        if not PICTURE_NAME.fullmatch(name):
            raise BadValue(f"{where}, {kind} picture", name, "twenty hexadecimal digits and .png")


def _check_reading(where: str, sensed: Mapping[str, Fact], joints: int) -> None:
    """Refuse a reading of a camera that is not one of all joints."""
    if CAMERA in sensed and not is_reading(sensed[CAMERA], joints):
        raise BadValue(f"{where}, {CAMERA}", sensed[CAMERA], f"{joints} positions, each 0, 1 or {UNCLEAR}")


def _check_ending(trial: Trial) -> None:
    """Check that the trial ends when the target moves or the steps run out, or with an error if there is one."""
    reached = [step.step for step in trial.steps if step.moved and step.joint == trial.target]
    if (trial.error is None) == (trial.ending == "error"):
        raise BadValue("trial record, error", trial.error, f"one exactly if the ending is error, not {trial.ending}")
    if reached != ([len(trial.steps)] if trial.solved else []):
        expected = "a last step that moved the target" if trial.solved else "no step that moved the target"
        raise BadValue("trial record, ending", trial.ending, f"solved, or {expected}" if reached else expected)
    if trial.ending == "budget" and len(trial.steps) != trial.budget:
        raise BadValue("trial record, steps", len(trial.steps), f"{trial.budget}, since the steps ran out")


def check_step(step: Step, joints: Sequence[str], labels: Sequence[str]) -> None:
    """Refuse a step that does not fit the joints, or a decision that does not fit the labels.

    Raises:
        BadValue: If it does not.
    """
    where, decision = f"trial record, step {step.step}", step.decision
    check_choice(f"{where}, joint", step.joint, joints)
    check_choice(f"{where}, decision", decision.joint, labels)
    for name, bits in (("state", step.state), ("told state", step.told_state)):
        if bits is not None and not (len(bits) == len(joints) and set(bits) <= {"0", "1"}):
            raise BadValue(f"{where}, {name}", bits, f"{len(joints)} positions, each 0 or 1")
    chances = decision.probabilities
    if chances is not None and not (len(chances) == len(joints) and all(0 <= chance <= 1 for chance in chances)):
        raise BadValue(f"{where}, probabilities", chances, f"{len(joints)} numbers from 0 to 1")
    if decision.claim_probability is not None:
        check_probability(f"{where}, claim probability", decision.claim_probability)
    _check_pictures(where, step.pictures)
    _check_reading(where, step.sensed, len(joints))

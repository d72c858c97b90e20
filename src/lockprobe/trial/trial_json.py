"""Writes a trial as one line of JSON and reads it back. Impossible records are refused, not analysed.

Anyone can write an agent, so every decision is checked before it is executed, too.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from reprlib import repr as shortened

from pydantic import TypeAdapter, ValidationError

from lockprobe.foundation.errors import BadValue, ReplyFault
from lockprobe.foundation.redaction import without_keys
from lockprobe.foundation.terminal_text import one_line
from lockprobe.trial.pictures.picture import PICTURE_NAME, PictureKind
from lockprobe.trial.record import Decision, Fact, Step, Task, Trial
from lockprobe.trial.source import CAMERA, UNCLEAR, is_reading

_trial: TypeAdapter[Trial] = TypeAdapter(Trial)
_decision: TypeAdapter[Decision] = TypeAdapter(Decision)

LONGEST = 10_000
"""The most steps of a trial."""

Faults = Iterator[tuple[str, object, str]]
"""What is wrong in a record, what it is, and what it should be."""


def trial_to_json(trial: Trial) -> bytes:
    """One line of JSON without a newline; fields at their defaults are left out."""
    return one_line(_trial.dump_json(trial, exclude_defaults=True))


def trial_from_json(line: bytes | str) -> Trial:
    """The trial on one line as :func:`trial_to_json` makes it; ``BadValue`` if that cannot have happened."""
    try:
        trial = _trial.validate_json(line, strict=True, extra="forbid")
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise BadValue("trial record", where or "line", f"a trial ({first['msg']})") from error
    joints = trial.joints
    if trial.target not in joints:
        raise BadValue("trial record, target", trial.target, f"one of the joints {', '.join(joints)}")
    if not (len(joints) == len(trial.labels) and sorted(trial.labels) == sorted(trial.listing)):
        raise BadValue("trial record, labels", trial.labels, f"one for each of {len(joints)} joints, each listed")
    refuse(_seen(trial.opening_pictures, trial.opening_sensed, len(joints)))
    for step in trial.steps:
        refuse(of_step(step, joints, trial.labels), f"step {step.step}, ")
    refuse(of_whole(trial))
    return trial


def refuse(faults: Faults, where: str = "") -> None:
    """Refuse a record by the first of its faults."""
    for what, got, expected in faults:
        raise BadValue(f"trial record, {where}{what}", got, expected)


def of_step(step: Step, joints: Sequence[str], labels: Sequence[str]) -> Faults:
    """What is wrong with a step of a trial with these joints and labels."""
    if step.joint not in joints:
        yield "joint", step.joint, f"one of {', '.join(joints)}"
    for name, bits in (("state", step.state), ("told state", step.told_state)):
        if bits is not None and not (len(bits) == len(joints) and set(bits) <= {"0", "1"}):
            yield name, bits, f"{len(joints)} positions, each 0 or 1"
    yield from _of_decision(step.decision, labels)
    yield from _seen(step.pictures, step.sensed, len(joints))


def _seen(pictures: Mapping[PictureKind, str], sensed: Mapping[str, Fact], joints: int) -> Faults:
    """Names of pictures are hashes, so that no record points outside its directory; a reading is one of all joints."""
    for kind, name in pictures.items():
        if not PICTURE_NAME.fullmatch(name):
            yield f"{kind} picture", name, "twenty hexadecimal digits and .png"
    if CAMERA in sensed and not is_reading(sensed[CAMERA], joints):
        yield CAMERA, sensed[CAMERA], f"{joints} positions, each 0, 1 or {UNCLEAR}"


def of_whole(trial: Trial) -> Faults:
    """What is wrong between the parts of a record: its key, its steps, their changes and its ending."""
    steps, budget = len(trial.steps), trial.budget
    if trial.fork is not None and trial.fork.parent != str(trial.name):
        yield "fork of", trial.fork.parent, str(trial.name)
    if trial.key != (expected := str(trial.fork or trial.name)):  # no two trials of a study share a key
        yield "key", trial.key, expected
    if (p := trial.p) is not None and not 0 <= p <= 1:
        yield "flip.p", p, "a number from 0 to 1"
    if not steps <= budget <= LONGEST:
        yield "steps", steps, f"at most the budget of {min(budget, LONGEST)}"
    for number, step in enumerate(trial.steps, 1):
        if step.step != number:
            yield f"step {number}, number", step.step, str(number)
    for spec, count in (*trial.changed.items(), ("all together", trial.changed_steps)):
        if not 0 <= count <= steps:
            yield f"steps changed by {spec}", count, f"0 to {steps}, its steps"
    yield from _of_ending(trial, steps)


def _of_ending(trial: Trial, steps: int) -> Faults:
    """A trial ends when the target moves or the steps run out, or with an error if there is one."""
    if (trial.error is None) == (trial.ending == "error"):
        yield "error", trial.error, f"one exactly if the ending is error, not {trial.ending}"
    reached = [step.step for step in trial.steps if step.moved and step.joint == trial.target]
    if reached != ([steps] if trial.solved else []):
        last = "a last step that moved the target" if trial.solved else "no step that moved the target"
        yield "ending", trial.ending, f"solved, or {last}" if reached else last
    if trial.ending == "budget" and steps != trial.budget:
        yield "steps", steps, f"{trial.budget}, since the steps ran out"


def _of_decision(decision: Decision, labels: Sequence[str]) -> Faults:
    """What is wrong with a decision on joints with these labels; its texts and its usage are not looked at."""
    if decision.joint not in labels:
        yield "decision", decision.joint, f"one of {', '.join(labels)}"
    if decision.claimed not in ("moved", "blocked", None):
        yield "claimed", decision.claimed, "one of moved, blocked, None"
    chances, claimed = decision.probabilities, decision.claim_probability
    many = chances is None or (isinstance(chances, tuple | list) and len(chances) == len(labels))
    if not (many and _are_shares(chances or ())):
        yield "probabilities", chances, f"{len(labels)} numbers from 0 to 1"
    if claimed is not None and not _are_shares([claimed]):
        yield "claim probability", claimed, "a number from 0 to 1"


def _are_shares(values: Iterable[object]) -> bool:
    return all(isinstance(one, float | int) and 0 <= one <= 1 for one in values)


def usable(decision: Decision, task: Task) -> Decision:
    """A decision without API keys in its texts and without claims where nobody asked.

    ``ReplyFault`` if it cannot be executed or recorded.
    """
    if (why := _why_unusable(decision, task.joints)) is not None:
        raise ReplyFault(why, tuple(map(str, getattr(decision, "replies", None) or ())))
    if decision.hypothesis or decision.replies:
        decision = replace(
            decision,
            hypothesis=without_keys(decision.hypothesis),
            replies=tuple(map(without_keys, decision.replies)),
            served=without_keys(decision.served),
        )
    return decision if task.assessment else replace(decision, claimed=None, claim_probability=None)


def _why_unusable(decision: object, labels: Sequence[str]) -> str | None:
    if not isinstance(decision, Decision):  # of an object the type alone, because its words may hold anything
        plain = decision is None or isinstance(decision, str | int | float)
        found = shortened(decision) if plain else f"an object of type {type(decision).__name__}"
        return f"decide returned {found}; return Decision(joint=…)"
    try:
        for what, got, expected in _of_decision(decision, labels):
            return f"its {what}: got {shortened(got)}, expected {expected}"
        added = (decision.hypothesis, decision.replies, decision.usage, decision.served, decision.tidied)
        if added != ("", (), None, "", ()):  # what models add goes to the record and back, which takes longer
            _decision.validate_json(_decision.dump_json(decision, exclude_defaults=True, warnings=False), strict=True)
    except ValidationError as error:
        first = error.errors()[0]
        return f"its {'.'.join(map(str, first['loc']))} cannot be written ({first['msg']})"
    except (TypeError, ValueError) as error:
        return f"it cannot be written ({error})"
    return None

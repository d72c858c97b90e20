"""Writes a trial as one line of JSON and reads it back. Impossible records are refused, not analysed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from operator import attrgetter
from reprlib import repr as shortened
from typing import Any

from pydantic import TypeAdapter, ValidationError

from lockprobe.foundation.errors import BadValue, ReplyFault
from lockprobe.foundation.redaction import without_keys
from lockprobe.foundation.terminal_text import one_line
from lockprobe.trial.record import LONGEST_TRIAL, Decision, Step, Task, Trial
from lockprobe.trial.source import CAMERA, UNCLEAR, is_reading

_trial: TypeAdapter[Trial] = TypeAdapter(Trial)
_decision: TypeAdapter[Decision] = TypeAdapter(Decision)

_beside = attrgetter("claim_probability", "hypothesis", "replies", "served", "usage", "tidied")
_NOTHING = _beside(Decision(joint=""))
"""What a decision says beside the joint and the claim, and what it mostly is."""

_MOST = 1 << 20
"""Different steps that a reader keeps."""

_SAME = ("facts", "channels", "joints", "plant", "interventions", "specs", "doses", "changed")
"""What trials of one agent and condition mostly have in common."""

_Faults = Iterator[tuple[str, object, str]]
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
    for what, got, expected in _faults(trial):
        raise BadValue(f"trial record, {what}", got, expected)
    return trial


class TrialReader:
    """Reads many records by :func:`trial_from_json`; equal parts of them are one object, so a million fit into memory.

    Most steps of agents that say no more than a joint are the same in many trials.
    """

    def __init__(self) -> None:
        self._steps: dict[tuple[object, ...], Step] = {}
        self._alike: dict[tuple[str, str, str], Trial] = {}

    def read(self, record: bytes) -> Trial:
        """The trial of a record."""
        trial = trial_from_json(record)
        like = self._alike.setdefault((trial.agent, trial.condition, trial.box), trial)
        shared: dict[str, Any] = {name: one for name in _SAME if (one := getattr(like, name)) == getattr(trial, name)}
        steps = list[Step]()
        for step in trial.steps:
            plain = not (step.sensed or step.pictures or step.decision.replies)
            keep = self._steps.setdefault if len(self._steps) < _MOST else self._steps.get
            what = step.step, step.state, step.joint, step.moved, step.chosen, step.decision
            told = step.told_moved, step.told_state, step.told, step.remark
            steps.append(keep((*what, *told), step) if plain else step)
        return replace(trial, steps=tuple(steps), **shared)


def _faults(trial: Trial) -> _Faults:
    """What is wrong between the parts of a record: its steps, its key, their changes and its ending.

    A trial ends when the target moves or the steps run out, or with an error if there is one.
    """
    steps, budget, joints, name = len(trial.steps), trial.budget, trial.joints, str(trial.name)
    known, wide = f"one of {', '.join(joints)}", len(joints)
    readings = [one[CAMERA] for one in (trial.opening_sensed, *(step.sensed for step in trial.steps)) if CAMERA in one]
    for step in trial.steps:
        if step.joint not in joints:
            yield f"step {step.step}, joint", step.joint, known
        for what, bits in (("state", step.state), ("told state", step.told_state)):
            if bits is not None and not (len(bits) == wide and set(bits) <= {"0", "1"}):
                yield f"step {step.step}, {what}", bits, f"{wide} positions, each 0 or 1"
        for what, got, expected in _of_decision(step.decision, trial.labels):
            yield f"step {step.step}, {what}", got, expected
    key, numbers = str(trial.fork or name), [step.step for step in trial.steps]  # no two trials of a study share a key
    reached = [step.step for step in trial.steps if step.moved and step.joint == trial.target]
    last = "a last step that moved the target" if trial.solved else "no step that moved the target"
    counts = (*trial.changed.items(), ("all together", trial.changed_steps))
    listed = len(trial.labels) == wide and sorted(trial.labels) == sorted(trial.listing)
    failed = "one exactly if the ending is error"
    for right, what, got, expected in (
        (trial.target in joints, "target", trial.target, known),
        (listed, "labels", trial.labels, f"one for each of {wide} joints, each listed"),
        *((is_reading(one, wide), CAMERA, one, f"{wide} positions, each 0, 1 or {UNCLEAR}") for one in readings),
        (trial.fork is None or trial.fork.parent == name, "fork of", trial.fork and trial.fork.parent, name),
        (trial.key == key, "key", trial.key, key),
        (0 <= (trial.p or 0) <= 1, "flip.p", trial.p, "a number from 0 to 1"),
        (steps <= budget <= LONGEST_TRIAL, "steps", steps, f"at most the budget of {min(budget, LONGEST_TRIAL)}"),
        (numbers == [*range(1, steps + 1)], "numbers of steps", numbers, f"1 to {steps}"),
        *((0 <= n <= steps, f"steps changed by {spec}", n, f"0 to {steps}, its steps") for spec, n in counts),
        ((trial.error is None) != (trial.ending == "error"), "error", trial.error, failed),
        (reached == [steps] * trial.solved, "ending", trial.ending, f"solved, or {last}" if reached else last),
        (trial.ending != "budget" or steps == budget, "steps", steps, f"{budget}, since the steps ran out"),
    ):
        if not right:
            yield what, got, expected


def _of_decision(decision: Decision, labels: Sequence[str]) -> _Faults:
    """What is wrong with a decision on joints with these labels, beside what its types say."""
    if decision.joint not in labels:
        yield "decision", decision.joint, f"one of {', '.join(labels)}"
    if decision.claimed not in ("moved", "blocked", None):
        yield "claimed", decision.claimed, "one of moved, blocked, None"
    if decision.probabilities is not None and len(decision.probabilities) != len(labels):
        yield "probabilities", decision.probabilities, f"{len(labels)} numbers from 0 to 1"


def usable(decision: Decision, task: Task) -> Decision:
    """A decision without API keys in its texts and without claims where nobody asked.

    Anyone can write an agent: ``ReplyFault`` if it cannot be executed or recorded.
    """
    if not isinstance(decision, Decision):  # of an object the type alone, because its words may hold anything
        plain = decision is None or isinstance(decision, str | int | float)
        found = shortened(decision) if plain else f"an object of type {type(decision).__name__}"
        raise ReplyFault(f"decide returned {found}; return Decision(joint=…)")
    chances, kept = decision.probabilities, tuple(map(str, decision.replies or ()))
    try:
        plain = type(chances) is tuple and all(type(one) is float and 0 <= one <= 1 for one in chances)
        if not (chances is None or plain) or _beside(decision) != _NOTHING:
            # what is beside the joint and the claim goes to the record and back, which takes longer
            _decision.validate_json(_decision.dump_json(decision, exclude_defaults=True, warnings=False), strict=True)
            decision = replace(
                decision,
                hypothesis=without_keys(decision.hypothesis),
                replies=tuple(map(without_keys, decision.replies)),
                served=without_keys(decision.served),
            )
        for what, got, expected in _of_decision(decision, task.joints):
            raise ReplyFault(f"its {what}: got {shortened(got)}, expected {expected}", kept)
    except ValidationError as error:
        first = error.errors()[0]
        raise ReplyFault(f"its {'.'.join(map(str, first['loc']))} cannot be written ({first['msg']})", kept) from None
    except (TypeError, ValueError) as error:
        raise ReplyFault(f"it cannot be written ({error})", kept) from None
    return decision if task.assessment else replace(decision, claimed=None, claim_probability=None)

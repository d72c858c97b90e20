"""A trial in shorthand: what was attempted, what happened, and what was told and claimed of it, in a few characters.

Numbers are made of it, so that a million trials fit into memory; who shows words reads the record. A trial whose record
says more (of a person, pictures, what was sensed, replies of a model, a correction, an error) has none, and is read
whole. What else a record holds is the same in all trials of one *kind*, of which one record is read.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import fields, replace
from operator import attrgetter
from typing import Any

from lockprobe.interventions.words import CORRECTION
from lockprobe.statistics.rules import state_after
from lockprobe.trial.record import Decision, Outcome, Step, Trial
from lockprobe.trial.trial_json import trial_to_json

_MARKS = {None: "-", True: "1", False: "0", "moved": "1", "blocked": "0"}
_TOLD: dict[str, bool | None] = {"-": None, "1": True, "0": False}
_CLAIMED: dict[str, Outcome | None] = {"-": None, "1": "moved", "0": "blocked"}

_FIRST = ord("A")
"""The letter of the first joint on the panel."""


def kind_of(trial: Trial) -> int:
    """Seven bytes of a digest of what a record says beside its place, its words and what happened."""
    of, alike = (trial.agent, trial.condition), (_ALIKE(trial), tuple(trial.changed))
    if (last := _LAST.get(of)) is not None and last[0] == alike:
        return last[1]
    kind = int.from_bytes(hashlib.blake2b(trial_to_json(_bare(trial)), digest_size=7).digest())
    _LAST[of] = alike, kind
    return kind


def shorthand(trial: Trial) -> str:
    """The first state, the labels, how many steps were changed, and each step: joint, moved, told, claimed, positions.

    Empty where the record says more.
    """
    more = trial.player or trial.error or trial.fork or trial.opening_pictures or trial.opening_sensed
    if more or not trial.steps or any(len(label) > 1 or label.isspace() for label in trial.labels):
        return ""
    letters, state, marks = {joint: chr(_FIRST + i) for i, joint in enumerate(trial.joints)}, trial.steps[0].state, []
    for step in trial.steps:
        said = step.decision
        replied = said.hypothesis or said.replies or said.served or said.tidied or said.usage
        if step.sensed or step.pictures or step.chosen or replied or CORRECTION in step.told or step.state != state:
            return ""
        told = _MARKS[step.moved], _MARKS[step.told_moved], _MARKS[said.claimed], step.told_state or ""
        marks.append(letters[step.joint] + "".join(told))
        state = state_after(trial, step)
    changed = ",".join(map(str, (trial.changed_steps, *trial.changed.values())))
    return " ".join((trial.steps[0].state, "".join(trial.labels), changed, *marks))


_OWN: dict[str, Any] = {
    "key": "", "repetition": 1, "trial": 1, "labels": (), "listing": (), "opening": "", "steps": (),
    "ending": "budget", "error": None, "changed_steps": 0,
}  # fmt: skip
"""What each trial has of its own, beside how often each intervention changed it, and what its kind has there."""

_ALIKE = attrgetter(*(one.name for one in fields(Trial) if one.name not in {*_OWN, "changed"}))

_LAST: dict[tuple[str, str], tuple[object, int]] = {}
"""What the last trial of an agent under a condition had in common with others, and its kind."""


def _bare(trial: Trial) -> Trial:
    """What trials of one kind have in common."""
    return replace(trial, **_OWN, changed=dict.fromkeys(trial.changed, 0))


class ShorthandReader:
    """Reads many trials in shorthand, without their words; equal parts of them are one object."""

    def __init__(self) -> None:
        self._kinds, self._labels = dict[int, Trial](), dict[str, tuple[str, ...]]()
        self._changed = dict[tuple[int, str], dict[str, int]]()
        self._steps = dict[tuple[str, ...], dict[tuple[int, str, str], tuple[Step, str]]]()

    def read(self, kind: int, written: str, record: Callable[[], Trial], **place: Any) -> Trial:
        """The trial in a place (key, repetition, trial, ending), from its record if that is the first of its kind."""
        if not written:
            return record()
        if (like := self._kinds.get(kind)) is None:
            self._kinds[kind] = _bare(trial := record())
            return trial
        state, labels, counts, *marks = written.split(" ")
        together, *each = map(int, counts.split(","))
        changed = self._changed.setdefault((kind, counts), dict(zip(like.changed, each, strict=True)))
        known, steps = self._steps.setdefault(like.joints, {}), list[Step]()
        for number, mark in enumerate(marks, 1):
            if (found := known.get((number, state, mark))) is None:
                step = Step(
                    step=number, state=state, joint=like.joints[ord(mark[0]) - _FIRST], moved=mark[1] == "1",
                    told_moved=_TOLD[mark[2]], told_state=mark[4:] or None, told="",
                    decision=Decision(joint="", claimed=_CLAIMED[mark[3]]),
                )  # fmt: skip
                found = known[number, state, mark] = step, state_after(like, step)
            step, state = found
            steps.append(step)
        names = self._labels.setdefault(labels, tuple(labels))
        return replace(like, labels=names, steps=tuple(steps), changed_steps=together, changed=changed, **place)

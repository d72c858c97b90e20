"""Reads many records: equal parts of them are parsed once and are one object afterwards.

Trials of one study have much in common: their settings, and most of their steps where agents say no more than a joint.
A :class:`TrialReader` cuts a record where its members begin, and parses a part only if it has not met its bytes before.
So many trials of strategies take a fraction of the time and of the memory. One that it cannot cut, it parses whole.
What it returns, and what it refuses, are the same as :func:`lockprobe.trial.trial_json.trial_from_json`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import fields, replace
from hashlib import blake2b
from typing import Any, NamedTuple

from pydantic import TypeAdapter, ValidationError

from lockprobe.foundation.errors import BadValue
from lockprobe.trial.record import Step, Trial
from lockprobe.trial.trial_json import of_step, of_whole, refuse, trial_from_json

_KEY, _STUDY, _STEPS, _STEP, _ENDING = b'{"key":"', b'","study":', b',"steps":[', b'{"step":', b'],"ending":'
_PLACE = re.compile(rb',"repetition":([1-9][0-9]{0,9}),"trial":([1-9][0-9]{0,9})(?=,)')

_MOST = 1 << 20
"""Different steps that are kept; further ones are parsed each time."""

_NAMES = [part.name for part in fields(Trial)]
_PARTS = tuple(
    _NAMES[_NAMES.index(first) : _NAMES.index(end) if end else None]
    for first, end in (("study", "repetition"), ("seed", "steps"), ("ending", ""))
)
"""The members of a trial before its place, between that and its steps, and behind them."""

_NOTHING: Mapping[Any, str] = {}
"""What was sensed at steps at which nothing was, and what was pictured."""

_step: TypeAdapter[Step] = TypeAdapter(Step)


class _Cut(NamedTuple):
    """The parts of a record: its key, repetition and trial, the members of :data:`_PARTS`, and its steps."""

    key: bytes
    place: tuple[int, int]
    parts: tuple[bytes, bytes, bytes]
    steps: list[bytes]


class TrialReader:
    """Reads records as JSON. Trials of one reader share what is equal in them."""

    def __init__(self) -> None:
        self._parts: dict[bytes, dict[str, Any]] = {}
        self._steps: dict[tuple[tuple[str, ...], tuple[str, ...]], dict[bytes, Step]] = {}
        self._same: dict[Any, Any] = {}
        self._kept = 0

    def read(self, record: bytes) -> Trial:
        """The trial of a record."""
        if (cut := _cut(record)) is None:
            return trial_from_json(record)
        if (trial := self._joined(cut)) is None:
            trial = trial_from_json(record)
            own = trial.error or trial.fork or trial.opening_sensed  # what only one trial has
            if not own and cut.place == (trial.repetition, trial.trial):
                for part, names in zip(cut.parts, _PARTS, strict=True):
                    self._parts.setdefault(part, {name: getattr(trial, name) for name in names})
                trial = self._joined(cut) or trial
        return trial

    def _joined(self, cut: _Cut) -> Trial | None:
        """The trial of parts that are known; None if one is not, or they make no trial."""
        before, between, behind = map(self._parts.get, cut.parts)
        if before is None or between is None or behind is None:
            return None
        joints, labels = between["joints"], between["labels"]
        known = self._steps.setdefault((joints, labels), {})
        try:
            steps = tuple([known.get(_digest(one)) or self._new_step(one, known, joints, labels) for one in cut.steps])
            key, (repetition, number) = cut.key.decode(), cut.place
            trial = Trial(key=key, repetition=repetition, trial=number, steps=steps, **before, **between, **behind)
            refuse(of_whole(trial))
        except (BadValue, ValidationError):  # parsed whole, the record says what is wrong with it
            return None
        return trial

    def _new_step(
        self, part: bytes, known: dict[bytes, Step], joints: tuple[str, ...], labels: tuple[str, ...]
    ) -> Step:
        step = _step.validate_json(_STEP + part + b"}", strict=True, extra="forbid")
        refuse(of_step(step, joints, labels))
        if step.decision.replies:  # different in every trial
            return step
        shared: dict[str, Any] = {
            name: self._same.setdefault(value, value)
            for name in ("state", "told_state", "told", "decision")
            for value in [getattr(step, name)]
        }
        step = replace(
            step,
            joint=joints[joints.index(step.joint)],
            sensed=step.sensed or _NOTHING,
            pictures=step.pictures or _NOTHING,
            **shared,
        )
        if self._kept < _MOST:
            known[_digest(part)] = step
            self._kept += 1
        return step


def likeness(trial: Trial, record: bytes) -> bytes | None:
    """Sixteen bytes that records have in common if they are alike but for their places, panels and steps.

    None if a record counts by itself: a person's, a fork, an error, and one with what adds up over steps, as usage.
    """
    asked = any(step.decision.replies or step.decision.usage or step.decision.tidied for step in trial.steps)
    alone = asked or trial.plant or trial.opening_pictures or trial.player or trial.fork or trial.error
    if alone or (cut := _cut(record)) is None:
        return None
    return _digest(cut.parts[0] + b"\n" + cut.parts[2])


def _digest(part: bytes) -> bytes:
    return blake2b(part, digest_size=16).digest()


def _cut(record: bytes) -> _Cut | None:
    """Cut a record where its members begin; None if they stand in another order.

    In JSON a quotation mark within a text is escaped, so a name between two of them, with a colon, is one of a member.
    Members of the same name within others are facts, which hold no lists.
    """
    head, _, rest = record.partition(_STEPS)
    steps, ending, _ = rest.rpartition(_ENDING)
    study, places = head.find(_STUDY), [*_PLACE.finditer(head)]
    key = head[len(_KEY) : study]
    if not (ending and study > 0 and len(places) == 1 and head.startswith(_KEY)) or b'"' in key or b"\\" in key:
        return None
    if steps and not (steps.startswith(_STEP) and steps.endswith(b"}")):
        return None
    (place,) = places
    return _Cut(
        key,
        (int(place[1]), int(place[2])),
        (head[study : place.start()], head[place.end() :], rest[len(steps) :]),
        steps[len(_STEP) : -1].split(b"}," + _STEP) if steps else [],
    )

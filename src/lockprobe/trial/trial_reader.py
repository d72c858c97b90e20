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
from types import MappingProxyType
from typing import Any, NamedTuple

from pydantic import TypeAdapter, ValidationError

from lockprobe.foundation.errors import BadValue
from lockprobe.trial.record import Decision, Step, Trial
from lockprobe.trial.trial_json import check_step, check_whole, trial_from_json

_KEY, _STUDY, _REPETITION = b'{"key":"', b'","study":', b',"repetition":'
_PLACE = re.compile(_REPETITION + rb'([1-9][0-9]{0,9}),"trial":([1-9][0-9]{0,9})(?=,)')
_STEPS, _FIRST_STEP, _NEXT_STEP, _ENDING = b',"steps":[', b'{"step":', b'},{"step":', b'],"ending":'
_REPLIES = b'"replies":'
"""Decisions with replies are different in every trial, and are not kept."""

_MOST = 1 << 20
"""Different steps that are kept; further ones are parsed each time."""

_NAMES = [part.name for part in fields(Trial)]
_BEFORE = _NAMES[_NAMES.index("study") : _NAMES.index("repetition")]
_BETWEEN = _NAMES[_NAMES.index("seed") : _NAMES.index("steps")]
_BEHIND = _NAMES[_NAMES.index("ending") :]

_NOTHING: Mapping[Any, str] = MappingProxyType({})
"""What was sensed at steps at which nothing was, and what was pictured."""

_step: TypeAdapter[Step] = TypeAdapter(Step)


class _Cut(NamedTuple):
    """The parts of a record: its key, the members before its place, its place, those before and behind its steps.

    Of the steps, where they begin and end in it.
    """

    key: bytes
    before: bytes
    place: tuple[int, int]
    between: bytes
    steps: tuple[int, int]
    behind: bytes


class TrialReader:
    """Reads records as JSON. Trials of one reader share what is equal in them."""

    def __init__(self) -> None:
        self._before: dict[bytes, dict[str, Any]] = {}
        self._between: dict[bytes, dict[str, Any]] = {}
        self._behind: dict[bytes, dict[str, Any]] = {}
        self._steps: dict[tuple[tuple[str, ...], tuple[str, ...]], dict[bytes, Step]] = {}
        self._decisions: dict[Decision, Decision] = {}
        self._same: dict[str, str] = {}
        self._kept = 0

    def read(self, record: bytes) -> Trial:
        """The trial of a record.

        Raises:
            BadValue: As :func:`lockprobe.trial.trial_json.trial_from_json`.
        """
        if (cut := _cut(record)) is None:
            return trial_from_json(record)
        if (trial := self._joined(record, cut)) is None:
            trial = trial_from_json(record)
            self._keep(cut, trial)
            trial = self._joined(record, cut) or trial
        return trial

    def _joined(self, record: bytes, cut: _Cut) -> Trial | None:
        """The trial of parts that are known; None if one is not, or they make no trial."""
        before, between = self._before.get(cut.before), self._between.get(cut.between)
        behind = self._behind.get(cut.behind)
        if before is None or between is None or behind is None:
            return None
        repetition, number = cut.place
        text, joints, labels = record[slice(*cut.steps)], between["joints"], between["labels"]
        known = self._steps.setdefault((joints, labels), {})
        parts = text[len(_FIRST_STEP) : -1].split(_NEXT_STEP) if text else []
        try:
            steps = tuple([known.get(_digest(part)) or self._new_step(part, known, joints, labels) for part in parts])
            key = cut.key.decode()
            trial = Trial(key=key, repetition=repetition, trial=number, steps=steps, **before, **between, **behind)
            check_whole(trial)
        except (BadValue, ValidationError):  # parsed whole, the record says what is wrong with it
            return None
        return trial

    def _new_step(
        self, part: bytes, known: dict[bytes, Step], joints: tuple[str, ...], labels: tuple[str, ...]
    ) -> Step:
        step = _step.validate_json(_FIRST_STEP + part + b"}", strict=True, extra="forbid")
        check_step(step, joints, labels)
        if _REPLIES in part:
            return step
        same, told_state = self._same, step.told_state
        step = replace(
            step,
            state=same.setdefault(step.state, step.state),
            joint=joints[joints.index(step.joint)],
            told_state=told_state and same.setdefault(told_state, told_state),
            told=same.setdefault(step.told, step.told),
            decision=self._decisions.setdefault(step.decision, step.decision),
            sensed=step.sensed or _NOTHING,
            pictures=step.pictures or _NOTHING,
        )
        if self._kept < _MOST:
            known[_digest(part)] = step
            self._kept += 1
        return step

    def _keep(self, cut: _Cut, trial: Trial) -> None:
        """Keep the parts of a trial, unless they hold what only one has: an error, a fork, a measurement."""
        only = trial.error is not None or trial.fork is not None or trial.opening_sensed
        if only or cut.place != (trial.repetition, trial.trial) or cut.key.decode() != trial.key:
            return
        for kept, part, names in (
            (self._before, cut.before, _BEFORE),
            (self._between, cut.between, _BETWEEN),
            (self._behind, cut.behind, _BEHIND),
        ):
            if part not in kept:
                kept[part] = {name: getattr(trial, name) for name in names}


def likeness(trial: Trial, record: bytes) -> bytes | None:
    """Sixteen bytes that records have in common if they are alike but for their places, panels and steps.

    None if a record counts by itself: a person's, a fork, an error, and one with what adds up over steps, as usage.
    """
    asked = any(step.decision.replies or step.decision.usage or step.decision.tidied for step in trial.steps)
    alone = asked or trial.plant or trial.opening_pictures or trial.player or trial.fork or trial.error
    if alone or (cut := _cut(record)) is None:
        return None
    return _digest(cut.before + b"\n" + cut.behind)


def _digest(part: bytes) -> bytes:
    """Sixteen bytes that stand for a part."""
    return blake2b(part, digest_size=16).digest()


def _cut(record: bytes) -> _Cut | None:
    """Cut a record where its members begin; None if they stand in another order.

    In JSON a quotation mark within a text is escaped, so a name between two of them, with a colon, is one of a member.
    Members of the same name within others are facts, which hold no lists.
    """
    study, steps, ending = record.find(_STUDY), record.find(_STEPS), record.rfind(_ENDING)
    repetition = record.find(_REPETITION, 0, max(steps, 0))
    place = _PLACE.match(record, repetition)
    if not record.startswith(_KEY) or not 0 < study < repetition < steps < ending or place is None:
        return None
    key, first = record[len(_KEY) : study], steps + len(_STEPS)
    if b'"' in key or b"\\" in key or record.find(_REPETITION, place.end(), steps) >= 0:
        return None
    if first < ending and not (record.startswith(_FIRST_STEP, first) and record.endswith(b"}", first, ending)):
        return None
    return _Cut(
        key,
        record[study:repetition],
        (int(place[1]), int(place[2])),
        record[place.end() : steps],
        (first, ending),
        record[ending:],
    )

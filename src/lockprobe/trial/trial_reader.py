"""Reads many lines of journals: equal parts of records are parsed once and are one object afterwards.

Trials of one study have much in common: their settings, and most of their steps where agents say no more than a joint.
A :class:`TrialReader` cuts a line where its members begin, and parses a part only if it has not met its bytes before.
So many trials of strategies take a fraction of the time and of the memory. A line that it cannot cut, it parses whole.
What it returns, and what it refuses, are the same as :func:`lockprobe.trial.trial_json.trial_from_line`.
"""

from __future__ import annotations

import re
from dataclasses import fields, replace
from typing import Any, NamedTuple

from pydantic import TypeAdapter, ValidationError

from lockprobe.foundation.errors import BadValue
from lockprobe.trial.record import Decision, Step, Trial
from lockprobe.trial.trial_json import check_step, check_whole, record_end, trial_from_json

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

_step: TypeAdapter[Step] = TypeAdapter(Step)


class _Cut(NamedTuple):
    """The parts of a line: its key, the members before its place, its place, those before and behind its steps.

    Of the steps, where they begin and end on the line.
    """

    key: bytes
    before: bytes
    place: tuple[int, int]
    between: bytes
    steps: tuple[int, int]
    behind: bytes


class Outline(NamedTuple):
    """A record without its steps.

    Attributes:
        kind: What it has in common with others: settings, ending and changes. Place, labels and steps are not its own.
        key: Its key.
        place: Its repetition and trial, from 1.
        steps: The number of its steps.
        identity: What was played.
        length: Bytes of the record at the beginning of its line.
    """

    kind: Trial
    key: str
    place: tuple[int, int]
    steps: int
    identity: str
    length: int


class TrialReader:
    """Reads lines of journals. Trials of one reader share what is equal in them."""

    def __init__(self) -> None:
        self._kinds: dict[tuple[bytes, bytes], Trial] = {}
        self._before: dict[bytes, dict[str, Any]] = {}
        self._between: dict[bytes, dict[str, Any]] = {}
        self._behind: dict[bytes, dict[str, Any]] = {}
        self._steps: dict[tuple[tuple[str, ...], tuple[str, ...]], dict[bytes, Step]] = {}
        self._decisions: dict[Decision, Decision] = {}
        self._kept = 0

    def read(self, line: bytes) -> tuple[Trial, str]:
        """The trial on one line of a journal, and the identity of what was played.

        Raises:
            BadValue: As :func:`lockprobe.trial.trial_json.trial_from_line`.
        """
        end, identity = record_end(line)
        if (cut := _cut(line, end)) is None:
            return trial_from_json(line[:end] + b"}"), identity
        if (trial := self._joined(line, cut)) is None:
            trial = trial_from_json(line[:end] + b"}")
            self._keep(cut, trial)
            trial = self._joined(line, cut) or trial
        elif (kind := (cut.before, cut.behind)) not in self._kinds and not _adds_up(trial):
            self._kinds[kind] = replace(trial, steps=())
        return trial, identity

    def outline(self, line: bytes) -> Outline | None:
        """The record on one line without its steps, which are not examined; None if it has to be read whole.

        These are the first records of their kind, those with what adds up over steps (usage, measurements), and those
        with escaped characters, whose bytes need not be those of :func:`lockprobe.trial.trial_json.trial_to_json`.

        Raises:
            BadValue: As :meth:`read`, if the line was changed or has no identity.
        """
        end, identity = record_end(line)
        if (cut := _cut(line, end)) is None or b"\\u" in line:
            return None
        kind = self._kinds.get((cut.before, cut.behind))
        if kind is None or cut.between not in self._between:
            return None
        last = line.rfind(_FIRST_STEP, *cut.steps) + len(_FIRST_STEP)
        steps = int(line[last : line.find(b",", last)]) if cut.steps[0] < cut.steps[1] else 0
        return Outline(kind, cut.key.decode(), cut.place, steps, identity, end)

    def _joined(self, line: bytes, cut: _Cut) -> Trial | None:
        """The trial of parts that are known; None if one is not, or they make no trial."""
        before, between = self._before.get(cut.before), self._between.get(cut.between)
        behind = self._behind.get(cut.behind)
        if before is None or between is None or behind is None:
            return None
        repetition, number = cut.place
        text, joints, labels = line[slice(*cut.steps)], between["joints"], between["labels"]
        known = self._steps.setdefault((joints, labels), {})
        parts = text[len(_FIRST_STEP) : -1].split(_NEXT_STEP) if text else []
        try:
            steps = tuple([known.get(part) or self._new_step(part, known, joints, labels) for part in parts])
            key = cut.key.decode()
            trial = Trial(key=key, repetition=repetition, trial=number, steps=steps, **before, **between, **behind)
            check_whole(trial)
        except (BadValue, ValidationError):  # parsed whole, the line says what is wrong with it
            return None
        return trial

    def _new_step(
        self, part: bytes, known: dict[bytes, Step], joints: tuple[str, ...], labels: tuple[str, ...]
    ) -> Step:
        step = _step.validate_json(_FIRST_STEP + part + b"}", strict=True, extra="forbid")
        check_step(step, joints, labels)
        if _REPLIES in part:
            return step
        step = replace(step, decision=self._decisions.setdefault(step.decision, step.decision))
        if self._kept < _MOST:
            known[part] = step
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


def _adds_up(trial: Trial) -> bool:
    """Whether steps of such a trial hold what adds up over a study: usage, measurements, a person's time."""
    asked = any(step.decision.replies or step.decision.usage for step in trial.steps)
    return bool(asked or trial.plant or trial.opening_pictures or trial.player)


def _cut(line: bytes, end: int) -> _Cut | None:
    """Cut the record on a line, which ends there, where its members begin; None if they stand in another order.

    In JSON a quotation mark within a text is escaped, so a name between two of them, with a colon, is one of a member.
    Members of the same name within others are facts, which hold no lists.
    """
    study, steps, ending = line.find(_STUDY), line.find(_STEPS), line.rfind(_ENDING, 0, end)
    repetition = line.find(_REPETITION, 0, max(steps, 0))
    place = _PLACE.match(line, repetition)
    if not line.startswith(_KEY) or not 0 < study < repetition < steps < ending or place is None:
        return None
    key, first = line[len(_KEY) : study], steps + len(_STEPS)
    if b'"' in key or b"\\" in key or line.find(_REPETITION, place.end(), steps) >= 0:
        return None
    if first < ending and not (line.startswith(_FIRST_STEP, first) and line.endswith(b"}", first, ending)):
        return None
    return _Cut(
        key,
        line[study:repetition],
        (int(place[1]), int(place[2])),
        line[place.end() : steps],
        (first, ending),
        line[ending:end],
    )

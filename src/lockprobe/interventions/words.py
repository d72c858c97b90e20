"""The modality ``symbolic``: reports in words, with the label and the state of each joint (paper, Sec. 2.2)."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import compress
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from lockprobe.boxes.sketch import in_rows
from lockprobe.foundation.validation import Checked
from lockprobe.trial.record import Moment, Outcome, Percept, Task, in_words

if TYPE_CHECKING:
    import numpy as np

Tell = Literal["state", "outcome", "both"]
"""The content of a report: the positions of all joints, the outcome of the attempt, or both."""

Form = Literal["words", "json"]
"""The form of a report: sentences, or one JSON object."""

CORRECTION = "Correction:"
"""The word before a report that corrects the previous one."""

Positions = tuple[bool, ...] | None

_KINDS: Mapping[str, str] = {"prismatic": "slider", "revolute": "knob"}


@dataclass(frozen=True, slots=True, kw_only=True)
class TextChannel(Checked):
    """Writes the percept as text. It removes what must not be told, and adds only places.

    With ``tell=state`` the agent has to infer the outcome of an attempt by comparing successive reports, as with
    pictures; with ``outcome`` positions are not told. Every form has the same content. With ``places`` the first report
    also says where joints lie on the panel, and which slide and which turn, as a picture shows it.
    """

    always_tells: ClassVar[bool] = True
    tell: Tell = "both"
    form: Form = "words"
    places: bool = False

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept with its text, without the facts that must not be told. Nothing is drawn from ``rng``."""
        joint, outcome, positions, corrects, _ = self.shown(percept)
        text = self.written(joint, outcome, positions, task, first=not past)
        if corrects is not None:
            _, first, where, *_ = corrects
            corrected = self.written(joint, first, where, task, first=False)
            text = corrected + (" " if self.form == "words" else "\n") + f"{CORRECTION} {text}"
        return percept.but(
            outcome=outcome,
            positions=positions,
            states_only=self.tell == "state",
            in_full=self.tell != "outcome" and self.form != "words",
            text=text,
        )

    def written(
        self, joint: str | None, outcome: Outcome | None, positions: Positions, task: Task, *, first: bool
    ) -> str:
        """The text of what is told; the ``first`` report of a trial may also say where joints lie."""
        rows = rows_of(task) if self.places and first else []
        if self.form == "words":
            attempted = joint if outcome is not None or (positions is not None and self.tell == "state") else None
            text = _sentences(attempted, outcome, positions, task.joints)
            return " ".join(filter(None, [text, *places_said(task, rows)])) if rows else text
        said: dict[str, object] = {}
        if joint is not None and (outcome, positions) != (None, None):
            said |= {"attempted": joint} | ({} if outcome is None else {"moved": outcome == "moved"})
        if positions is not None:
            said["positions"] = dict(zip(task.joints, map(int, positions), strict=True))
        if rows:
            kinds = {label: _kind(task, label) for label in task.joints} if task.kinds else {}
            said["panel"] = {"rows from above, each from left to right": rows} | ({"kinds": kinds} if kinds else {})
        return json.dumps(said) if said else ""

    def shown(self, percept: Percept) -> tuple[Any, ...]:
        """What agents get of a percept: the joint, the facts that are told, and pictures that were there before."""
        outcome = None if self.tell == "state" else percept.outcome
        positions = None if self.tell == "outcome" else percept.positions
        corrects = None if percept.corrects is None else self.shown(percept.corrects)
        return percept.joint, outcome, positions, corrects, percept.pictures


@lru_cache(maxsize=1 << 14)
def _sentences(joint: str | None, outcome: Outcome | None, positions: Positions, joints: tuple[str, ...]) -> str:
    """What is told of an attempt and of positions, which many trials share; nothing of an attempt without a joint."""
    said = [] if joint is None else [f"You attempted {joint}." if outcome is None else f"{joint} {in_words(outcome)}."]
    where = [] if positions is None else [f"At 1: {', '.join(compress(joints, positions)) or 'none'}."]
    return " ".join(said + where)


def rows_of(task: Task) -> list[list[str]]:
    """The labels on the panel in rows from top to bottom, each from left to right; empty if the panel is not shown."""
    return [[task.joints[i] for i in row] for row in in_rows(task.places)]


def _kind(task: Task, label: str) -> str:
    """The word for a sliding or turning joint; empty if its kind is not known."""
    return _KINDS.get(task.kinds[task.joints.index(label)], "") if task.kinds else ""


def places_said(task: Task, rows: Sequence[Sequence[str]]) -> list[str]:
    """Where joints lie on the panel, row by row, and which slide and which turn."""
    sentences = []
    for number, row in enumerate(rows, 1):
        where = "On the panel" if len(rows) == 1 else f"In row {number} of the panel from above"
        named = (f"{label} ({kind})" if (kind := _kind(task, label)) else label for label in row)
        sentences.append(f"{where}, from left to right: {', '.join(named)}.")
    return sentences

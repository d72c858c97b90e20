"""What a study found, as rows: the content of ``results.json``, which tables, figures and pages read.

A number is an :class:`Estimate`, a line of a figure a :class:`Curve`. What is no number is a
:class:`Fact`: a property, or a sentence. A quantity that could not be measured has no row.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from importlib import import_module
from operator import attrgetter
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from lockprobe.foundation.errors import LockprobeError, Missing
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.spec import PEOPLE
from lockprobe.report.left_out import LeftOutSection
from lockprobe.statistics.design import FLIPS, Axis
from lockprobe.statistics.proportions import ALPHA, Proportion
from lockprobe.trial.condition import Contrast


def _finite(value: object) -> object:
    """None for what is not a number, as JSON has it."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


Number = Annotated[float | None, BeforeValidator(_finite)]
Probability = Annotated[float | None, Field(ge=0, le=1), BeforeValidator(_finite)]


class Part(BaseModel):
    """A part of the results: frozen, described, and written without what has its default."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    def plain(self) -> dict[str, Any]:
        """The part as JSON holds it."""
        return self.model_dump(mode="json", exclude_defaults=True)


class _Measured(Part):
    """What an estimate and a curve have in common: the columns that say what they are of.

    No two rows of a study are equal in all of :data:`IDENTITY`.
    """

    quantity: str = Field(description="What is measured, for example success or success_by_step.")
    agent: str = Field(
        default="", description="Name of the agent, or its spec if it has none; empty for what no agent did."
    )
    modality: str = Field(default="", description="How the box was shown; under the condition, if under one.")
    condition: str = Field(default="", description="Name of the condition; empty for several.")
    control: str = Field(default="", description="The condition that is subtracted, in a difference.")
    versus: str = Field(default="", description="The agent that is subtracted, in a comparison of agents.")
    versus_modality: str = Field(default="", description="How that agent was shown the box.")
    axis: str = Field(default="", description="The dose over which it is computed, for example flip rate; or step.")
    of: str = Field(default="", description="What part of the quantity: a null model, an outcome, a repetition.")
    doses: dict[str, float] = Field(default={}, description="The doses of the condition, for example flip.p: 0.4.")
    n: int | None = Field(default=None, ge=0, description="How many trials, actions or claims it is of.")
    source: str = Field(default="", description="The package that measures it; empty for Lockprobe.")

    @property
    def pair(self) -> dict[str, str]:
        """The two agents that it compares, as columns."""
        return {name: getattr(self, name) for name in ("agent", "modality", "versus", "versus_modality")}


IDENTITY = (
    *("quantity", "agent", "modality", "condition", "control"),
    *("versus", "versus_modality", "axis", "of", "source"),
)
"""The columns that say what a row is of."""


BOUNDS = ("at least", "at most")
"""Parts of a share or a difference of trials some of which broke: what it is at least and at most, whatever became of
these."""


class Estimate(_Measured):
    """One number, with its interval and test where it has them."""

    unit: str = Field(
        default="share",
        description="share, points, ratio, direction, dose, steps, trials, attempts, people, claims, records, boxes, "
        "blocks, r, or what a package says; empty if it has none. Points are differences of shares, from -1 to 1; the "
        "column axis names a dose.",
    )
    count: int | None = Field(default=None, ge=0, description="Of a share: how many of them.")
    clusters: int | None = Field(default=None, ge=0, description="Clusters that the interval counts as independent.")
    value: Number = Field(default=None, description="The number; null where only its interval is known.")
    low: Number = Field(default=None, description="Lower end of its 95 % interval; null if open or unknown.")
    high: Number = Field(default=None, description="Upper end.")
    p_value: Probability = Field(default=None, description="P value, corrected as the next columns say.")
    family: str = Field(default="", description="The comparisons that are judged together.")
    corrected_for: int = Field(default=1, ge=1, description="How many comparisons the P value allows for.")
    test: str = Field(default="", description="The test of the P value.")
    note: str = Field(default="", description="What limits it, for example the end of an interval that is open.")

    @property
    def detected(self) -> bool:
        """Whether the test rejects at 0.05 and the interval leaves out 0."""
        clear = self.low is not None and self.high is not None and (self.low > 0 or self.high < 0)
        return self.p_value is not None and self.p_value < ALPHA and clear

    def plain(self) -> dict[str, Any]:
        """The row as JSON holds it: ten columns always, the others where they are no defaults."""
        kept = self.model_dump(mode="json", include=_ALWAYS)
        return kept | super().plain()


def clearness(row: Estimate) -> tuple[float, float]:
    """Sorts the clearest difference first: the smallest P value, without a test last, and of equal ones the largest."""
    return 2.0 if row.p_value is None else row.p_value, -abs(row.value or 0.0)


def detected_said(rows: Iterable[Estimate], what: str) -> str:
    """How many of how many were detected; empty if none was tested."""
    judged = [row for row in rows if row.p_value is not None]
    return f"{sum(row.detected for row in judged)} of {len(judged)} {what} detected." if judged else ""


_ALWAYS = {"quantity", "agent", "condition", "unit", "n", "value", "low", "high", "p_value", "test"}
"""Columns that every row of ``results.json`` has."""


class Curve(_Measured):
    """A number along an axis, such as the share solved by each step, with its band."""

    x: tuple[float, ...] = Field(description="Places on the axis, ascending.")
    value: tuple[Number, ...] = Field(description="The number at each of them.")
    low: tuple[Number, ...] = Field(default=(), description="Lower end of its 95 % band; empty without one.")
    high: tuple[Number, ...] = Field(default=(), description="Upper end.")


class Fact(Part):
    """A property of an agent, the plant or the study, or a sentence that does not follow from rows."""

    about: str = Field(description="What it is a property of, or the section of a sentence.")
    name: str = Field(description="Its name.")
    text: str = Field(description="Its value.")
    source: str = Field(default="", description="The package that gives it; empty for Lockprobe.")


Row = Estimate | Curve | Fact
"""What a section of a report gives."""


def measured_row(quantity: str, found: Any, **columns: Any) -> Estimate:
    """The row of what statistics found: its value, interval, P value and sizes, as far as it has them."""
    return Estimate(quantity=quantity, **measured(found) | columns)


def measured(found: Any) -> dict[str, Any]:
    """The columns of what statistics found, as far as it has them."""
    own = ("value", "low", "high", "p_value", "n", "count", "clusters")
    return {name: getattr(found, name) for name in own if hasattr(found, name)}


def share_rows(quantity: str, found: Proportion, **columns: Any) -> list[Estimate]:
    """The row of a share with its interval; none if it is a share of nothing."""
    return [measured_row(quantity, found, **columns)] if found.n else []


class Condition(Part):
    """A condition of the study."""

    name: str = Field(description="Its name: its specs, or what the experimenter calls it.")
    specs: tuple[str, ...] = Field(default=(), description="What acts.")
    modality: str = Field(description="How the box is shown.")
    doses: dict[str, float] = Field(default={}, description="Its doses.")
    p: float | None = Field(default=None, description="Flip rate, if nothing but flips can act.")
    control: str = Field(default="", description="The condition that it is compared with; empty for a control.")


def who(agent: str, shown: str = "") -> str:
    """What sentences call an agent; ``shown`` is how the box was shown, where that has to be said.

    >>> who("participant"), who("llm:local", "RGB")
    ('people', 'llm:local (RGB)')
    """
    name = "people" if agent == PEOPLE else agent
    return f"{name} ({shown})" if shown else name


class Player(Part):
    """An agent in one modality."""

    agent: str = Field(description="Name of the agent, or its spec if it has none.")
    modality: str = Field(description="How the box was shown.")
    shown: str = Field(default="", description="What tells it apart in words: the modality, if it has several.")
    subject: bool = Field(default=False, description="Whether the study is about it; others are baselines.")
    blind: bool = Field(default=False, description="Whether it plays alike at every dose.")
    doses: tuple[float, ...] = Field(default=(), description="Its doses with trials, of an axis of its own, ascending.")

    @property
    def label(self) -> str:
        """What tables call it."""
        return who(self.agent, self.shown)


class DoseAxis(Part):
    """Conditions that differ in one dose alone."""

    axis: Axis = Field(description="The dose, its levels, and what else is equal in all of them.")
    players: tuple[Player, ...] = Field(default=(), description="Agents with trials on it; of flips the design's.")


class Design(Part):
    """What differs between the trials of the study."""

    conditions: tuple[Condition, ...] = Field(description="Its conditions, in the order of the settings.")
    players: tuple[Player, ...] = Field(description="The agents that have trials, each in each of its modalities.")
    axes: tuple[DoseAxis, ...] = Field(default=(), description="The doses; flip rates first.")
    contrasts: dict[str, Contrast] = Field(default={}, description="What it asks by itself; the first is primary.")
    flip_kind: str = Field(default="", description="What a false report is.")


EveryLook = Literal["", "until", "extended", "unfinished"]
"""Why numbers must hold at every look: the study stops when it is decided, was extended, or is unfinished."""


class Progress(Part):
    """How far the study has come."""

    planned: int = Field(ge=0, description="Planned trials; for people, the places to be filled.")
    finished: int = Field(ge=0, description="Of these, finished trials.")
    every_look: EveryLook = Field(
        default="", description="Why success and its differences are shown as they hold at every look; empty: at one."
    )
    not_counted: int = Field(default=0, ge=0, description="Finished trials behind an open block, in no number yet.")
    broken: dict[str, int] = Field(
        default={}, description="Agent -> its trials without a valid end, if a run has gone through all of them."
    )

    @property
    def partial(self) -> bool:
        """Whether planned trials are open: neither finished nor broken."""
        return self.finished + sum(self.broken.values()) < self.planned


MEASURES = "measures"
"""What facts about measures of packages are about; of the measure ``x`` the quantity is ``measures.x``."""

RECONSTRUCTED = "the paper's strategy"
"""What facts about agents that stand for it are about."""

_KINDS: Mapping[str, type] = {"rows": Estimate, "curves": Curve, "facts": Fact}
"""The fields that hold rows."""

_COLUMNS = frozenset(Estimate.model_fields)
"""By which rows are selected."""


class NoSuchRow(LockprobeError, LookupError):
    """No row, or more than one, has what was asked for."""


class Results(Part):
    """What a study found: the content of ``results.json``, and a table to select from."""

    schema_version: Literal[4] = Field(default=4, description="Version of this layout.")
    lockprobe: str = Field(description="Release that made it.")
    study: dict[str, Any] = Field(description="The settings, as in study.json.")
    settings_hash: str = Field(description="Hash of the settings, as lockprobe verify DIR --settings takes it.")
    results_hash: str = Field(description="Hash of settings and records, as lockprobe verify DIR --results takes it.")
    answer: str = Field(default="", description="What the study found, in one sentence.")
    progress: Progress = Field(description="How many of its planned trials are finished.")
    design: Design = Field(description="What differs between its trials.")
    rows: tuple[Estimate, ...] = Field(default=(), description="Every number, one a row.")
    curves: tuple[Curve, ...] = Field(default=(), description="Every line of a figure.")
    facts: tuple[Fact, ...] = Field(default=(), description="Properties and sentences, as text.")
    sections_left_out: tuple[LeftOutSection, ...] = Field(default=(), description="Sections that could not be made.")

    def plain(self) -> dict[str, Any]:
        """The content of ``results.json``."""
        found = ((name, getattr(self, name)) for name in type(self).model_fields)
        return {
            name: [*map(_plain, value)] if isinstance(value, tuple) else _plain(value)
            for name, value in found
            if value or name != "sections_left_out"
        }

    def __repr__(self) -> str:
        """How many rows there are; all of them would fill a screen for minutes."""
        return f"<Results of {self.study.get('name', 'a study')}: {len(self.rows)} rows; {self.answer}>"

    @property
    def measures(self) -> list[Estimate]:
        """What measures of packages found, in order."""
        return [row for row in self.rows if row.quantity.startswith(f"{MEASURES}.")]

    @cached_property
    def _rows(self) -> Mapping[str, Sequence[Estimate]]:
        return grouped(self.rows, attrgetter("quantity"))

    @cached_property
    def _selected(self) -> dict[tuple[str, ...], Mapping[tuple[str, ...], Sequence[Estimate]]]:
        """A quantity and the names of columns -> values of these columns -> rows; filled as rows are asked for."""
        return {}

    def where(self, quantity: str = "", **columns: str) -> list[Estimate]:
        """The rows of a quantity (of all if empty) that have these values, in order.

        >>> found = lockprobe.results("runs/flips")  # doctest: +SKIP
        >>> found.where("success", agent="random")  # doctest: +SKIP
        """
        if unknown := columns.keys() - _COLUMNS:
            raise NoSuchRow(
                f"no column is called {', '.join(sorted(unknown))}; columns: {', '.join(IDENTITY)}, family, …"
            )
        asked = quantity, *columns
        if asked not in self._selected:
            rows = self._rows.get(quantity, ()) if quantity else self.rows
            self._selected[asked] = grouped(rows, lambda row: tuple(getattr(row, name) for name in columns))
        return [*self._selected[asked].get(tuple(columns.values()), ())]

    def get(self, quantity: str, **columns: str) -> Estimate | None:
        """The one row of a quantity that has these values and ``of=""`` unless given; None if there is none.

        Raises:
            NoSuchRow: If there are several.
        """
        rows = self.where(quantity, **{"of": "", **columns})
        if len(rows) > 1:
            apart = [name for name in IDENTITY if len({getattr(row, name) for row in rows}) > 1]
            raise NoSuchRow(
                f"{quantity}: {len(rows)} rows have {_asked(columns)}; they differ in {', '.join(apart)}. Give one of "
                f"{', '.join(sorted({getattr(row, apart[0]) or 'empty' for row in rows})) if apart else 'them'}"
            )
        return rows[0] if rows else None

    def one(self, quantity: str, **columns: str) -> Estimate:
        """The same, which has to be there; if it is not, the message says what is."""
        found = self.get(quantity, **columns)
        if found is None:
            near = self._near(quantity, {"of": "", **columns})
            raise NoSuchRow(f"{quantity}: no row has {_asked(columns)}. {near}")
        return found

    def _near(self, quantity: str, columns: Mapping[str, str]) -> str:
        if quantity not in self._rows:
            near = difflib.get_close_matches(quantity, self._rows, 3) or sorted(self._rows)
            return f"Quantities: {', '.join(near)}"
        for name, value in columns.items():
            there = {str(getattr(row, name)) for row in self._rows[quantity]}
            if value not in there:
                return f"{name}: {', '.join(sorted(there - {''}) or ['empty'])}"
        return "Each of these values occurs, but not together"

    def curve(self, quantity: str, **columns: str) -> Curve | None:
        """The one curve of a quantity that has these values, with ``of=""`` unless given; None if there is none."""
        wanted = ({"quantity": quantity, "of": ""} | columns).items()
        found = [one for one in self.curves if all(getattr(one, of) == said for of, said in wanted)]
        if len(found) > 1:
            raise NoSuchRow(f"{quantity}: {len(found)} curves have {_asked(columns)}")
        return found[0] if found else None

    @property
    def random_play(self) -> list[Curve]:
        """Success by step of random agents, with and without immediate repeats; none if it is not known."""
        curves = (self.curve("success_by_step", agent="", of=of) for of in ("uniform", "no-repeat"))
        return [curve for curve in curves if curve]

    def frame(self) -> Any:
        """All rows as a pandas frame, a column for each field and each dose.

        Raises:
            Missing: If pandas is not installed.
        """
        try:
            pandas = import_module("pandas")
        except ImportError as error:
            raise Missing("frames need the package pandas", "pip install pandas") from error
        rows = [row.model_dump(exclude={"doses"}) | row.doses for row in self.rows]
        return pandas.DataFrame(rows, columns=list(dict.fromkeys(name for row in rows for name in row)) or None)

    def fact(self, about: str, name: str) -> str:
        """A property, or a sentence of a section; empty if there is none."""
        return next((one.text for one in self.facts if (one.about, one.name) == (about, name)), "")

    def facts_about(self, about: str) -> dict[str, str]:
        """All properties of something."""
        return {one.name: one.text for one in self.facts if one.about == about}

    @property
    def reconstructed(self) -> dict[str, str]:
        """The agents that stand for the paper's strategy, and why they do."""
        return self.facts_about(RECONSTRUCTED)

    def player(self, agent: str, modality: str) -> Player:
        """An agent in a modality."""
        known = (one for one in self.design.players if (one.agent, one.modality) == (agent, modality))
        return next(known, None) or Player(agent=agent, modality=modality)

    @property
    def boxes(self) -> list[Mapping[str, Any]]:
        """Its boxes, as in ``study.json``."""
        return list(self.study.get("boxes", ()))

    @property
    def subjects(self) -> tuple[str, ...]:
        """The agents that the study is about."""
        return tuple(dict.fromkeys(one.agent for one in self.design.players if one.subject))

    @property
    def flip_rates(self) -> tuple[float, ...]:
        """The flip rates that have trials, ascending."""
        return tuple(sorted({cell.p for cell in self.cells if cell.p is not None}))

    @property
    def several_p(self) -> bool:
        """Whether trials have several flip rates."""
        return len(self.flip_rates) > 1

    @property
    def beside_flips(self) -> bool:
        """Whether the study has conditions that are no flip rates."""
        return any(one.p is None for one in self.design.conditions)

    @property
    def main_axis(self) -> DoseAxis | None:
        """The axis that the answer is about; None for flip rates, or without any."""
        others = (one for one in self.design.axes if not one.axis.of_flips)
        return None if self.several_p else next(others, None)

    @cached_property
    def cells(self) -> tuple[Cell, ...]:
        """Every agent under every condition, in the order of the study."""
        found, rates = [], {one.name: one.p for one in self.design.conditions}
        for row in self.where("trials", of=""):
            if row.condition:
                p, player = rates[row.condition], self.player(row.agent, row.modality)
                if p is None:  # the name of its condition says how the box was shown, and what acts
                    player = player.model_copy(update={"shown": "", "blind": False})
                own = {"agent": row.agent, "condition": row.condition, "control": "", "versus": ""}
                view = {"found": self, "own": own, "condition": row.condition, "p": p, "dose": p}
                found.append(Cell.model_construct(**dict(player) | view))
        return tuple(found)

    def courses(self, axis: DoseAxis | None = None) -> list[Course]:
        """Every agent over the doses of an axis, ascending; over flip rates without one."""
        found, known = [], {(one.agent, one.condition): one for one in self.cells}
        for player in axis.players if axis else self.design.players:
            if axis:
                cells = [
                    known[player.agent, of].model_copy(update={"dose": dose})
                    for of, dose in axis.axis.doses.items()
                    if (player.agent, of) in known and dose in (player.doses or (dose,))  # what changed nothing is out
                ]
            else:
                of = player.agent, player.modality
                cells = [one for one in self.cells if (one.agent, one.modality) == of and one.p is not None]
                cells = sorted(cells, key=lambda one: one.p or 0.0)
            dose = axis.axis if axis else FLIPS
            own = {"agent": player.agent, "modality": player.modality, "axis": dose.key, "condition": "", "versus": ""}
            view = {"found": self, "own": own, "axis": dose.key, "name": dose.name, "cells": tuple(cells)}
            if cells:
                found.append(Course.model_construct(**dict(player) | view))
        return found

    def against_control(self) -> list[Estimate]:
        """Success of every condition minus that of its control: by agent, doses of an axis before other conditions."""
        agents = list(dict.fromkeys(one.agent for one in self.design.players))
        controls = {one.name: one.control for one in self.design.conditions}
        rows = self.where("success_difference", of="", versus="")
        own = [row for row in rows if row.control and (not row.axis or row.control == controls.get(row.condition))]
        return sorted(own, key=lambda row: (agents.index(row.agent), not row.axis))

    def with_rows(self, rows: Iterable[Row]) -> Results:
        """The same with these rows, each among its kind."""
        kinds = grouped(rows, type)
        return self.changed(**{name: tuple(kinds.get(kind, ())) for name, kind in _KINDS.items()})

    def changed(self, **fields: Any) -> Results:
        """The same with other values of these fields."""
        kept = {name: getattr(self, name) for name in type(self).model_fields}
        return self.model_construct(**kept | fields)  # no copy, which would keep what is cached


def _plain(value: Any) -> Any:
    if isinstance(value, LeftOutSection):
        return value._asdict()
    return value.plain() if isinstance(value, Part) else value


def _asked(columns: Mapping[str, str]) -> str:
    return ", ".join(f"{name}={value}" for name, value in columns.items()) or "all"


class _View(Player):
    """An agent of the design, and the rows of results that have the values of some columns, its own."""

    found: Results
    own: Mapping[str, str]

    def get(self, quantity: str, of: str = "") -> Estimate | None:
        """A number of it; None if it has none."""
        return self.found.get(quantity, **self.own, of=of)

    def value(self, quantity: str, of: str = "") -> float | None:
        """The value of a number of it; None if it has none."""
        row = self.get(quantity, of)
        return None if row is None else row.value

    def curve(self, quantity: str, of: str = "") -> Curve | None:
        """A curve of it; None if it has none."""
        return self.found.curve(quantity, **self.own, of=of)


class Cell(_View):
    """One agent under one condition.

    Attributes:
        p: Flip rate; None if other things than flips can act.
        dose: Its dose on the axis on which it is shown.
    """

    condition: str
    p: float | None
    dose: float | None

    @property
    def trials(self) -> int:
        """Trials that ended as solved or out of budget."""
        return int(self.value("trials") or 0)

    @property
    def points(self) -> list[tuple[Estimate, Estimate]]:
        """Success and loop rate of each repetition."""
        rows = [row for row in self.found.where("success", **self.own) if row.of.startswith("rep=")]
        pairs = ((row, self.get("loop_rate", row.of)) for row in rows)
        return [(success, loops) for success, loops in pairs if loops is not None]


class Course(_View):
    """One agent over the doses of an axis.

    Attributes:
        axis: The key of the axis, which its rows have in their column ``axis``.
        name: What sentences call the dose.
        cells: Its cells by dose, ascending.
    """

    axis: str
    name: str
    cells: tuple[Cell, ...]

    @property
    def played(self) -> tuple[Cell, ...]:
        """Its cells that have an ended trial."""
        return tuple(cell for cell in self.cells if cell.trials)

    def changes(self, of: str = "", quantity: str = "success_difference") -> list[tuple[Cell, Estimate]]:
        """A number that compares each dose with the lowest, with what the agent did at that dose."""
        found = []
        for cell in self.cells[1:]:
            place = {"condition": cell.condition, "of": of}
            rows = self.found.where(quantity, agent=self.agent, axis=self.axis, versus="", **place)
            found += [(cell, row) for row in rows if row.control]
        return found

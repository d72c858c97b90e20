"""The primary answer of a study: a line for each agent, from the rows of its results."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from lockprobe.foundation.formatting import listed
from lockprobe.report.format import beside
from lockprobe.report.rows import Course, DoseAxis, Estimate, Player, Results, clearness
from lockprobe.trial.condition import TRUTH

CONTROL = "the control"
"""Part of a share in pairs: that of the condition that is subtracted."""


DECLARED = "contrasts"
"""The family of contrasts that a study declares."""

SIDES = ("minus", "of")
"""Parts of a share in pairs: that of the conditions which a contrast subtracts, and of those from which it does."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """What a study found for one agent: two shares of one sample, and their difference with its test.

    Attributes:
        conditions: The control, and the condition that is compared.
        first: Success under the control.
        second: Success under the condition that is compared; None if none is.
        change: The second minus the first; None where it was not tested.
        control: The control in words.
        under: Under what the second is, in words: at flip rate 0.4.
        cause: The contrast that the study declares, if it is that.
        alike: Whether it plays the same trials whatever it is told, so that there is nothing to test.
        baseline: Whether the study is about others.
    """

    agent: str
    modality: str
    label: str
    conditions: tuple[str, ...]
    first: Estimate | None
    second: Estimate | None = None
    change: Estimate | None = None
    control: str = ""
    under: str = ""
    cause: str = ""
    alike: bool = False
    baseline: bool = False

    @property
    def of_first(self) -> dict[str, str]:
        """The columns of rows about it under the control."""
        return {"agent": self.agent, "modality": self.modality, "condition": self.conditions[0]}

    @property
    def verdict(self) -> str:
        """What was found, in two words."""
        if self.alike:
            return "plays alike"
        if self.change is None or self.change.value is None:
            return "not compared"
        if not self.change.detected:
            return "not detected"
        return "solves more" if self.change.value > 0 else "solves fewer"


def primary_lines(found: Results) -> list[Line]:
    """A line for each agent: those that the study is about, then baselines.

    What is compared goes by a rule: the first contrast that the study declares; else false reports of the study of
    controls (``why``); of contrasts of misreading nothing, which have a table; else flip rates, or the doses of
    the first other axis; else single conditions; else nothing. Of several doses or conditions it is the one with the
    smallest P value, of equal ones the largest difference: intervals and P values are corrected for that choice.
    """
    lines = list(_declared(found)) or list(_of_controls(found))
    if not lines and found.where("misreading_difference"):
        lines = [replace(line, second=None, change=None, under="") for _, line in _of_conditions(found)]
    if not lines:
        known = {(one.agent, one.modality): one for one in dose_lines(found, found.main_axis)}
        if not any(one.change or one.alike for one in known.values()):
            known |= {key: line for key, line in _of_conditions(found) if line.change or key not in known}
        lines = list(known.values())
    return sorted(lines, key=lambda line: line.baseline)


def dose_lines(found: Results, axis: DoseAxis | None = None) -> list[Line]:
    """A line for each agent over the doses of an axis; over flip rates without one."""
    return [_over_doses(one) for one in found.courses(axis) if one.played]


def changes_from_control(found: Results) -> dict[tuple[str, str], Estimate]:
    """Agent and condition -> the change of success from the control, as it is written beside both shares."""
    changes = {}
    for row in reversed(found.against_control()):
        of = {"agent": row.agent, "control": "", "versus": ""}
        shares = (found.get("success", **of, condition=one) for one in (row.control, row.condition))
        changes[row.agent, row.condition] = beside(row, *shares) or row
    return changes


def _line(of: Player | Course, conditions: Iterable[str], first: Estimate | None, **more: Any) -> Line:
    """The line of an agent."""
    own: dict[str, Any] = {"agent": of.agent, "modality": of.modality, "label": of.label, "baseline": not of.subject}
    change = beside(more.pop("change", None), first, more.get("second"))
    return Line(**own, conditions=tuple(conditions), first=first, change=change, **more)


def _declared(found: Results) -> Iterator[Line]:
    """A line for each agent, of the first contrast that the study declares; none without one."""
    for name, asked in list(found.design.contrasts.items())[:1]:
        for row in found.where("success_difference", family=DECLARED, of=name):
            own = {"agent": row.agent, "modality": row.modality}
            less, more = (found.get("success_in_pairs", **own, of=f"{name}, {side}") for side in SIDES)
            control, under = (
                _control(names[0]) if names == (TRUTH,) else f"under {listed(names, named=2)}"
                for names in (asked.minus, asked.of)
            )
            sides = {"second": more, "change": row, "control": control, "under": under, "cause": name}
            yield _line(found.player(**own), (asked.minus[0], asked.of[0]), less, **sides)


def _of_controls(found: Results) -> Iterator[Line]:
    """A line for each agent of the study of controls: told the truth, and under false reports."""
    for total in found.where("false_report_effect", of="total"):
        own = {"agent": total.agent, "modality": total.modality}
        arms = {row.of: row for row in found.where("success_in_arm", **own)}
        said = {"change": total, "control": "told the truth", "under": "under false reports"}
        conditions = (arms[of].condition for of in ("truth", "lie") if of in arms)
        yield _line(found.player(**own), conditions, arms.get("truth"), second=arms.get("lie"), **said)


def _over_doses(course: Course) -> Line:
    """The lowest dose against the one that differs most clearly, in the trials that both have."""
    first, none = course.played[0], (None, None)
    second, change = min(course.changes(), key=lambda pair: clearness(pair[1]), default=none)
    said: dict[str, Any] = {"control": "told the truth" if first.p == 0 else _control(first.condition)}
    if second is None:
        return _line(course, [first.condition], first.get("success"), alike=course.blind, **said)
    pairs = (course.changes(of, "success_in_pairs") for of in (CONTROL, ""))
    control, other = (next((row for cell, row in of if cell.dose == second.dose), None) for of in pairs)
    shares = (control, other) if control and other else (first.get("success"), second.get("success"))
    said |= {"second": shares[1], "change": change, "under": f"at {course.name} {second.dose:g}", "alike": course.blind}
    return _line(course, (first.condition, second.condition), shares[0], **said)


def _of_conditions(found: Results) -> Iterator[tuple[tuple[str, str], Line]]:
    """Of each agent its first condition, or the clearest effect of one against its control."""
    for player in found.design.players:
        own = [row for row in found.against_control() if row.agent == player.agent and not row.axis]
        cells = {cell.condition: cell for cell in found.cells if cell.agent == player.agent and cell.trials}
        if not cells:
            continue
        clearest = min(own, key=clearness, default=None)
        first = cells.get(clearest.control if clearest else "", next(iter(cells.values())))
        second = cells.get(clearest.condition) if clearest else None
        said: dict[str, Any] = {
            "control": _control(first.condition),
            "under": f"under {second.condition}" if second else "",
        }
        said |= {"second": second.get("success") if second else None, "change": clearest}
        conditions = (cell.condition for cell in (first, second) if cell)
        yield (player.agent, player.modality), _line(player, conditions, first.get("success"), **said)


def _control(condition: str) -> str:
    return "told the truth" if condition == TRUTH else condition

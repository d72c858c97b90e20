"""Agents compared: who of every two solves more, how soon, and whether false reports or a condition change one more.

Over all flip rates, and over all conditions beside them. Two agents that act the same in every trial play alike, and
nothing is tested.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Iterator, Mapping, Sequence
from typing import Any

from lockprobe.foundation.formatting import capital, first_three, p_cell, percent
from lockprobe.foundation.grouping import grouped
from lockprobe.report.format import beside, conclusion_of, tested
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.prose import at_lowest, condition_words
from lockprobe.report.rows import Estimate, Results, Row, measured
from lockprobe.report.section import Lines, Note, Part, Section, Table, note_at
from lockprobe.statistics.agents import CHANGE, STEPS, SUCCESS, compared
from lockprobe.statistics.contrast import acting
from lockprobe.statistics.course import Cell, Course, courses
from lockprobe.statistics.design import FLIPS
from lockprobe.statistics.differences import CLUSTERED
from lockprobe.statistics.every_look import E_PROCESS
from lockprobe.statistics.multiple_testing import holm
from lockprobe.studies.study import Study

_SHARE, _CONDITIONS = "success_in_pairs", "conditions"

_FAMILIES = ("agents", "agents and baselines")
"""The families of pairs of agents, and of agents and baselines."""

_ALIKE = "the two play alike: nothing to test"
_WORST = "holds whatever became of broken trials"


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    found = [*_over(numbers.courses, FLIPS.name, numbers.study), *_over_conditions(numbers)]
    families = [family for _, family, _ in found]
    corrected, sizes = holm([columns.get("p_value") for columns, *_ in found], families), Counter(families)
    for (columns, family, times), p in zip(found, corrected, strict=True):
        tests = {"p_value": p, "corrected_for": sizes[family] * times} if family else {}
        alike = {"p_value": None, "corrected_for": 1} if _ALIKE in columns.get("note", "") else {}
        yield Estimate(**columns | tests | alike)


def _over_conditions(numbers: OpenedStudy) -> Iterator[_Tested]:
    """Every pair over the conditions of a modality that are no flip rates, in which something was changed."""
    design, doses = numbers.design, dict[str, tuple[str, float]]()
    for modality in () if numbers.study.of_flips else design.shown:
        control = design.controls[modality]
        own = [arm.label for arm in design.shown[modality] if arm.label not in design.axis and arm.label != control]
        doses |= {label: (modality, float(i)) for i, label in enumerate((control, *own))}

    def place(cell: Cell) -> tuple[str, str, float]:
        return cell.agent, *doses[cell.condition]

    acted = [at for at in acting(numbers.by_name, design) if at[1] in doses]
    players = courses([numbers.by_name[at] for at in acted], place=place)
    yield from _over([one for one in players if len(one.by_dose) > 1], _CONDITIONS, numbers.study)


_Tested = tuple[dict[str, Any], Hashable, int]
"""The columns of a number of two agents, whose P value is not yet corrected for those of its family (Holm); that
family, None if for nothing; and for how many doses it is corrected already."""


def _over(players: Sequence[Course], axis: str, study: Study) -> Iterator[_Tested]:
    """Every pair over all doses, and how much more these change the one: at the dose with the clearest change."""
    for one in compared(players):
        of = {"agent": one.second.agent, "modality": one.second.modality, "axis": axis}
        of |= {"versus": one.first.agent, "versus_modality": one.first.modality, "family": _FAMILIES[one.baseline]}
        test, alike = E_PROCESS if one.every_look else CLUSTERED if one.people else "", one.plays_alike
        note = "; ".join(filter(None, (_WORST * (len(one.laid) > 1), _ALIKE * alike)))
        family = axis, one.baseline, one.first.modality, one.second.modality
        for quantity, unit in ((SUCCESS, "points"), (STEPS, "steps")):
            columns = {"quantity": quantity, "unit": unit, "note": note} | measured(one.mean(quantity))
            columns |= {"test": (test or "permutation within blocks") * (not alike)}
            yield of | columns, (quantity, *family), 1
        for part, solved in zip(("the other", ""), one.solved, strict=True):
            yield of | {"quantity": _SHARE, "of": part, "n": len(solved), "value": float(solved.mean())}, None, 1
        if one.changes and not alike:
            dose, clearest = min(one.changes.items(), key=lambda both: (both[1].p_value or 0.0, -abs(both[1].value)))
            low, high = (one.second.by_dose[at].condition for at in (one.doses[0], dose))
            columns = {"quantity": CHANGE, "unit": "points", "condition": high, "control": low}
            columns |= {"test": test or "sign flips of blocks", "doses": dict(study.labelled(high).doses)}
            yield of | columns | measured(clearest), (CHANGE, *family), len(one.changes)


def _pairs(found: Results) -> list[tuple[str, str, Mapping[tuple[str, str], Estimate]]]:
    """What sentences call every two agents that are compared, and their rows over an axis by quantity and part.

    Those that the study is about stand first.
    """
    by_pair: dict[tuple[str, ...], dict[tuple[str, str], Estimate]] = {}
    for quantity in (SUCCESS, STEPS, CHANGE, _SHARE):
        for row in found.where(quantity):
            if row.family in _FAMILIES:
                by_pair.setdefault((*row.pair.values(), row.axis), {})[quantity, row.of] = row
    pairs = [
        (found.player(agent, modality).label, found.player(versus, other).label, rows)
        for (agent, modality, versus, other, _), rows in by_pair.items()
    ]
    return sorted(pairs, key=lambda pair: pair[-1][SUCCESS, ""].family == _FAMILIES[1])


def _table(found: Results) -> Lines:
    head = ["agent", "compared with", "under", "trials", "success of both", "success, points", "P", "steps"]
    yield [*head, "P of steps", "conclusion"]
    for one, other, rows in _pairs(found):
        success, steps = rows[SUCCESS, ""], rows[STEPS, ""]
        own, others = (rows[_SHARE, of] for of in ("", "the other"))
        shares = f"{percent(own.value)}, {percent(others.value)}"
        under = "all flip rates" if found.several_p else at_lowest(found)
        under = "all conditions" if success.axis == _CONDITIONS else under
        said = "play alike" if _ALIKE in success.note else conclusion_of(success)
        gap, p = beside(success, others, own), p_cell(success.p_value)
        yield [one, other, under, str(success.n), shares, gap, p, steps, p_cell(steps.p_value), said]


def _effects(found: Results) -> Lines:
    yield ["agent", "compared with", "of", "effect, points", "P", "conclusion"]
    words = condition_words(found)
    for one, other, rows in _pairs(found):
        if moved := rows.get((CHANGE, "")):
            yield [one, other, words[moved.condition], *tested(moved)]


_TABLE = Table("comparisons", _table, drawn="success, points", rare=("under",))

_EFFECTS = Table("effects_compared", _effects, 3, drawn="effect, points")

_NOTE = Note(
    "Success (drawn; filled: detected), steps and effect: the first agent minus the second, over trials that both "
    "finished; an unsolved one counts with its whole budget. Effect: what a flip rate or a condition (of) changes in "
    "success, where that is clearest.",
    "The two agents swap whole blocks (permutation). Effect: signs of blocks are flipped.",
    "A trial has the same random numbers (labels, flips, draws) for every agent and condition; a block is one "
    "repetition and trial. P values are corrected for pairs, effects for flip rates or conditions too (Holm); pairs "
    "with baselines are a family of their own. Detected: the test rejects and the interval leaves out 0. Who solves "
    "nearly all trials cannot gain many points. Beside people: Student's t with a variance clustered by person and "
    "block.",
)


def _show(found: Results) -> Iterator[Part]:
    if not (pairs := _pairs(found)):
        return
    said, by_axis = [], grouped(pairs, lambda pair: pair[-1][SUCCESS, ""].axis)
    for axis, own in by_axis.items():
        rows = [(one, other, of[SUCCESS, ""]) for one, other, of in own]
        clear = [(one, other)[:: 1 if (row.value or 0) > 0 else -1] for one, other, row in rows if row.detected]
        over = "other " * (len(by_axis) > 1) + "conditions" if axis == _CONDITIONS else ""
        over = over or "flip rates" * found.several_p
        more = first_three(f"{one} solves more than {other}" for one, other in clear)
        over_all = f"{f'over all {over}, ' * bool(over)}a difference was detected for {len(clear)} of {len(rows)}"
        said.append(f"{capital(over_all)} pairs of agents{f': {more}' * bool(clear)}.")
    yield Part("Which agent is better?", " ".join(said), [_TABLE, _EFFECTS, note_at(found, _NOTE)])


SECTIONS = (Section("agents_compared", "Agents compared", _rows, _show, (_TABLE, _EFFECTS)),)

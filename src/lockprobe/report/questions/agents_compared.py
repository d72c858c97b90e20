"""Agents compared: who of every two solves more, how soon, and whether false reports or a condition change one more.

Over all flip rates, and under every condition beside them. Two agents that act the same in every trial play alike, and
nothing is tested.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Iterator, Mapping
from typing import Any

from lockprobe.foundation.formatting import capital, first_three, p_cell, percent
from lockprobe.report.format import conclusion_of
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.prose import at_lowest, condition_words, who
from lockprobe.report.rows import Estimate, Results, Row, measured
from lockprobe.report.section import Lines, Note, Part, Section, Table, note_at
from lockprobe.statistics.agents import CHANGE, STEPS, SUCCESS, AgentPair, compared
from lockprobe.statistics.contrast import acting
from lockprobe.statistics.course import Cell, courses
from lockprobe.statistics.design import FLIPS
from lockprobe.statistics.differences import CLUSTERED
from lockprobe.statistics.distributions import holm_by_family
from lockprobe.statistics.every_look import E_PROCESS

_SHARE, _ANY = "success_in_pairs", "any flip rate"

_FAMILIES = ("agents", "agents and baselines")
"""The families of pairs of agents, and of agents and baselines."""

_ALIKE = "the two play alike: nothing to test"
_WORST = "holds whatever became of broken trials"


_Tested = tuple[dict[str, Any], Hashable, int]
"""The columns of a number of two agents, whose P value is not yet corrected for those of its family (Holm); that
family, None if for nothing; and for how many doses it is corrected already."""


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    found = [*_over_flips(numbers), *_under_conditions(numbers)]
    families = [family for _, family, _ in found]
    corrected, sizes = holm_by_family(families, [columns.get("p_value") for columns, *_ in found]), Counter(families)
    for (columns, family, times), tested in zip(found, corrected, strict=True):
        tests = {"p_value": tested, "corrected_for": sizes[family] * times} if family else {}
        alike = {"p_value": None, "corrected_for": 1} if _ALIKE in columns.get("note", "") else {}
        yield Estimate(**columns | tests | alike)


def _over_flips(numbers: OpenedStudy) -> Iterator[_Tested]:
    """Every pair over all flip rates, and how much more these change the one: at the rate with the clearest change."""
    for one in compared(numbers.courses):
        over = _of(one) | {"axis": FLIPS.name}
        for quantity in (SUCCESS, STEPS):
            yield over | _difference(one, quantity), (quantity, one.family), 1
        for part, share in zip(("the other", ""), one.shares, strict=True):
            yield over | {"quantity": _SHARE, "of": part, "n": one.mean(SUCCESS).n, "value": share}, None, 1
        if one.changes and not one.plays_alike:
            dose, clearest = min(one.changes.items(), key=lambda both: (both[1].p_value or 0.0, -abs(both[1].value)))
            of = {
                "quantity": CHANGE,
                "unit": "points",
                "of": _ANY,
                "doses": {"flip.p": dose},
                "test": _test(one, CHANGE),
            }
            yield over | of | measured(clearest), (CHANGE, one.family), len(one.changes)


def _under_conditions(numbers: OpenedStudy) -> Iterator[_Tested]:
    """Every pair under each condition that is no flip rate, and how much more the condition changes the one.

    The pairs of one kind under the doses of an axis are a family, and under all other conditions of a modality another
    one. Two agents that each play a condition and its control alike are compared under the control alone.
    """
    design, every = numbers.design, numbers.by_name
    cells = acting(every, design)
    for arm in design.arms:
        label, control = arm.label, design.control(arm.label)
        if label in design.axis:
            continue
        axes = (series.axis for series in design.other_axes if label in series.doses and label != control)
        axis = next((" ".join(filter(None, (one.name, one.options, one.rest))) for one in axes), "")

        def place(cell: Cell, control: str = control if control != label else "") -> tuple[str, str, float]:
            return cell.agent, cell.modality, float(cell.condition != control)

        own = [every[at] for at in cells if at[1] in (label, control) and (at[0], label) in cells]
        players = courses(own, place=place)
        for one in compared(players):
            if 1.0 not in one.met or one.copies:
                continue
            of, family = every[one.second.agent, label].of | _of(one, axis or "conditions"), (axis, one.family)
            yield of | _difference(one, SUCCESS, 1.0), (SUCCESS, *family), 1
            yield of | _difference(one, STEPS, 1.0), None, 1
            if one.changes and not one.plays_alike:
                change = {"quantity": CHANGE, "unit": "points", "control": control, "test": _test(one, CHANGE)}
                yield of | change | measured(one.changes[1.0]), (CHANGE, *family), 1


def _of(one: AgentPair, under: str = "") -> dict[str, Any]:
    """The columns that say of whom a row is."""
    family = ", ".join(filter(None, (_FAMILIES[one.baseline], under)))
    versus = {"versus": one.first.agent, "versus_modality": one.first.modality}
    return {"agent": one.second.agent, "modality": one.second.modality, "family": family} | versus


def _difference(one: AgentPair, quantity: str, dose: float | None = None) -> dict[str, Any]:
    """The columns of a difference over all doses, or at one."""
    alike = one.plays_alike if dose is None else dose in one.alike
    note = "; ".join(filter(None, (_WORST * one.bounded, _ALIKE * alike)))
    columns = {"quantity": quantity, "unit": "steps" if quantity == STEPS else "points", "note": note}
    return columns | {"test": _test(one, quantity, dose) * (not alike)} | measured(one.mean(quantity, dose))


def _test(one: AgentPair, quantity: str, dose: float | None = None) -> str:
    if one.every_look:
        return E_PROCESS
    if one.people:
        return CLUSTERED
    if quantity == CHANGE:
        return "sign flips of blocks"
    return "McNemar" if quantity == SUCCESS and dose is not None else "permutation within blocks"


_Pair = tuple[str, str, Mapping[tuple[str, str], Estimate]]
"""What sentences call two agents, and their rows by quantity and condition; by part where over all flip rates."""


def _pairs(found: Results) -> list[_Pair]:
    """Every two agents that are compared, those that the study is about first."""
    by_pair: dict[tuple[str, ...], dict[tuple[str, str], Estimate]] = {}
    for quantity in (SUCCESS, STEPS, CHANGE, _SHARE):
        for row in found.where(quantity):
            if row.family.partition(",")[0] in _FAMILIES:
                by_pair.setdefault(tuple(row.pair.values()), {})[quantity, row.condition or row.of] = row
    pairs = []
    for (*second, versus, modality), rows in by_pair.items():
        players = ((agent, found.player(agent, shown)) for agent, shown in (second, (versus, modality)))
        one, other = (who(agent, player.shown if player else "") for agent, player in players)
        pairs.append((one, other, rows))
    return sorted(pairs, key=lambda pair: next(iter(pair[-1].values())).family.startswith(_FAMILIES[1]))


def _places(rows: Mapping[tuple[str, str], Estimate]) -> list[str]:
    """Where two agents are compared in the table: over all flip rates, or under each condition beside these."""
    places = [at for quantity, at in rows if quantity == SUCCESS]
    return [""] if "" in places else places


def _table(found: Results) -> Lines:
    head = ["agent", "compared with", "under", "trials", "success of both", "success, points", "P", "steps"]
    yield [*head, "P of steps", "effect, points", "P of effect", "conclusion"]
    words = condition_words(found)
    for one, other, rows, place in ((*pair, place) for pair in _pairs(found) for place in _places(pair[-1])):
        success, steps = rows[SUCCESS, place], rows[STEPS, place]
        moved = rows.get((CHANGE, place or _ANY))
        shares = None if place else " and ".join(percent(rows[_SHARE, of].value) for of in ("", "the other"))
        under = words[place] if place else "all flip rates" if found.several_p else at_lowest(found)
        said = "play alike" if _ALIKE in success.note else conclusion_of(success)
        p = p_cell(moved.p_value if moved else None)
        row = [one, other, under, str(success.n), shares, success, p_cell(success.p_value)]
        yield [*row, steps, p_cell(steps.p_value), moved, p, said]


_RARE = ("under", "success of both", "effect, points", "P of effect")

_TABLE = Table("comparisons", _table, drawn="success, points", rare=_RARE)

_NOTE = Note(
    "Success (drawn; filled: detected), steps and effect: the first agent minus the second, over trials that both "
    "finished; an unsolved one counts with its whole budget. Effect: what a condition changes in success, or "
    "false reports at the rate with the clearest change.",
    "Over all flip rates the two agents swap whole blocks (permutation), under one condition it is McNemar's test. "
    "Effect: signs of blocks are flipped.",
    "A trial has the same random numbers (labels, flips, draws) for every agent and condition; a block is one "
    "repetition and trial. P values are corrected for pairs and conditions (Holm), steps under one condition are not; "
    "pairs with baselines, the doses of an axis and all other conditions are families of their own. Detected: the test "
    "rejects and the interval leaves out 0. Who solves nearly all trials cannot gain many points. Beside people: "
    "Student's t with a variance clustered by person and block.",
)


def _show(found: Results) -> Iterator[Part]:
    if not (pairs := _pairs(found)):
        return
    tested = [(one, other, rows[SUCCESS, at]) for one, other, rows in pairs for at in _places(rows)]
    clear = [(one, other)[:: 1 if (row.value or 0) > 0 else -1] for one, other, row in tested if row.detected]
    more = first_three(f"more by {one} than by {other}" for one, other in clear)
    rest = f"no difference in success was detected in {len(tested) - len(clear)} of {len(tested)} comparisons"
    rest *= len(tested) > len(clear)
    said = capital("; ".join(filter(None, (f"solved {more}" * bool(clear), rest))))
    yield Part("Which agent is better?", f"{said}.", [_TABLE, note_at(found, _NOTE)])


SECTIONS = (Section("agents_compared", "Agents compared", _rows, _show, (_TABLE,)),)

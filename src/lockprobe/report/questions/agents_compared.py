"""Agents compared: who of every two solves more, how soon, and whether false reports or a condition change one more.

All flip rates together and each alone, and every condition beside them. Where success of both is at its ceiling or its
floor, what is told is how soon. Two agents that act the same in every trial play alike, and nothing is tested.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from operator import itemgetter
from typing import Any, NamedTuple

from lockprobe.foundation.formatting import (
    NONE,
    capital,
    change,
    first_three,
    minus,
    p_cell,
    p_value,
    percent,
    range_said,
)
from lockprobe.foundation.spec import PEOPLE
from lockprobe.report.every_look import note_at
from lockprobe.report.format import DETECTED, EVERY, TextTable
from lockprobe.report.prose.subject import Subject
from lockprobe.report.rows import Estimate, Results, Row
from lockprobe.report.section import Block, Detail, Note, Part, Section, Table, Text
from lockprobe.report.study_numbers import StudyNumbers, of_blocks
from lockprobe.report.table_rows import over_rates, points_cell, steps_cell
from lockprobe.statistics.agent_comparison.pairs import CHANGE, STEPS, SUCCESS, AgentPair, compared
from lockprobe.statistics.conditions.axis import FLIPS
from lockprobe.statistics.conditions.axis_trials import Place, on_axis
from lockprobe.statistics.contrast import acting
from lockprobe.statistics.distributions import holm_by_family
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.sequential.contrasts import E_PROCESS
from lockprobe.studies.study_design import design_of
from lockprobe.trial.record import Trial

_NAME = "agents_compared"
_SHARE, _ANY = "success_in_pairs", "any flip rate"

_FAMILIES = ("agents", "agents and baselines")
"""The families of pairs of agents, and of agents and baselines."""

_SAME = "the same at every flip rate"
_ALIKE = "the two play alike: nothing to test"
_WORST = "holds whatever became of broken trials"

_EDGE = 0.1
"""So near to 0 or 1 the success of two agents is at its floor or its ceiling, where it does not tell them apart."""


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    of_cell = {(cell.agent, cell.condition): cell.of for cell in numbers.cells}
    names = {
        (one.agent, one.modality): {dose: trials[0].condition for dose, trials in one.by_dose.items()}
        for one in numbers.courses
    }
    found = compared([one.trials for one in numbers.courses])
    families = [one.family for one in found]
    success = holm_by_family(families, [one.means[SUCCESS, None].p_value for one in found])
    steps = holm_by_family(families, [one.means[STEPS, None].p_value for one in found])
    changes = holm_by_family(families, [one.change_p for one in found])
    changed = Counter(one.family for one in found if one.at(CHANGE) and not one.plays_alike)
    # two that each play identically at every dose count as one test, not one for each dose
    places = [(i, dose) for i, one in enumerate(found) for dose in [*one.at(SUCCESS)][: 1 if one.copies else None]]
    of_place = [families[i] for i, _ in places]
    tested = holm_by_family(of_place, [found[i].means[SUCCESS, dose].p_value for i, dose in places])
    at_dose = dict(zip(places, tested, strict=True))
    for i, one in enumerate(found):
        agent, modality = one.second.agent, one.second.modality
        of = {"agent": agent, "modality": modality, "axis": FLIPS.name} | _versus(one)
        many = families.count(one.family)
        for name, unit, p in ((SUCCESS, "points", success[i]), (STEPS, "steps", steps[i])):
            tests = {"p_value": p, "test": _test(one, name), "corrected_for": many, "note": _WORST * one.bounded}
            tests = {"p_value": None, "note": _ALIKE} if one.plays_alike else tests
            yield Estimate(quantity=name, unit=unit, **of, **of_blocks(one.means[name, None]) | tests)
        for part, share in zip(("the other", ""), one.shares, strict=True):
            yield Estimate(quantity=_SHARE, of=part, **of, n=one.means[SUCCESS, None].pairs, value=share)
        doses, own = [*one.at(SUCCESS)], names[agent, modality]
        cells = {dose: of_cell[agent, own[dose]] | _versus(one) for dose in doses}
        note = "; ".join([_SAME] * one.copies + [_WORST] * one.bounded)
        for dose in doses:
            p = at_dose[i, doses[0] if one.copies else dose]
            yield from _at_one(one, dose, cells[dose], p, of_place.count(one.family), note)
        if (moved := one.at(CHANGE)) and not one.plays_alike:
            of |= {"quantity": CHANGE, "unit": "points"}
            yield Estimate(of="mean", **of, **of_blocks(one.means[CHANGE, None]))
            many = changed[one.family] * len(moved)
            yield Estimate(of=_ANY, **of, p_value=changes[i], corrected_for=many, test=_test(one, CHANGE))
            for dose, mean in moved.items():
                yield _change(one, dose, cells[dose], own[one.doses[0]], mean.p_value, len(moved))
    yield from _under_conditions(numbers)


def _versus(one: AgentPair) -> dict[str, Any]:
    family = _FAMILIES[one.baseline]
    return {"versus": one.first.agent, "versus_modality": one.first.modality, "family": family}


def _test(one: AgentPair, quantity: str, dose: float | None = None) -> str:
    """The test of a quantity over all doses, or at one; none at one where both play alike."""
    if one.every_look:
        return E_PROCESS
    if dose in one.alike:
        return ""
    if one.people:
        return "t, clustered by person and block" if dose is None else "permutation of people"
    if quantity == CHANGE:
        return "sign flips of blocks"
    return "McNemar" if quantity == SUCCESS and dose is not None else "permutation within blocks"


def _at_one(
    one: AgentPair, dose: float, of: Mapping[str, Any], tested: float | None, many: int, note: str = ""
) -> Iterator[Estimate]:
    """Two agents under one condition; the P value of success is corrected for so many, that of steps is not."""
    alike = dose in one.alike
    for name, unit in ((SUCCESS, "points"), (STEPS, "steps")):
        columns = of_blocks(one.means[name, dose]) | {"quantity": name, "unit": unit, "test": _test(one, name, dose)}
        columns |= {"note": "; ".join(filter(None, (note, _ALIKE * alike)))}
        columns |= {"p_value": tested, "corrected_for": many, "clusters": None} if name == SUCCESS else {}
        yield Estimate(**of, **columns | ({"p_value": None} if alike else {}))


def _change(
    one: AgentPair, dose: float, of: Mapping[str, Any], control: str, tested: float | None, many: int
) -> Estimate:
    """How much more a dose changes the success of the one than of the other."""
    tests = {"p_value": tested, "corrected_for": many, "test": _test(one, CHANGE), "control": control}
    return Estimate(quantity=CHANGE, unit="points", **of, **of_blocks(one.means[CHANGE, dose]) | tests)


def _under_conditions(numbers: StudyNumbers) -> Iterator[Estimate]:
    """Every pair under each condition that is no flip rate, and how much more the condition changes the one.

    The pairs of one kind under the doses of an axis are a family, and under all other conditions of a modality another
    one. Two agents that each play a condition and its control alike are compared under the control alone.
    """
    design, orders = design_of(numbers.study), numbers.opened.orders
    every = {(cell.agent, cell.condition): cell for cell in numbers.cells}
    cells = acting(every, design)
    found: list[tuple[str, str, str, AgentPair]] = []
    for arm in design.arms:
        label, control = arm.label, design.control(arm.label)
        if label in design.axis:
            continue
        axes = (series.axis for series in design.other_axes if label in series.doses and label != control)
        axis = next((" ".join(filter(None, (one.name, one.options, one.rest))) for one in axes), "")

        def place(trial: Trial, control: str = control if control != label else "") -> Place:
            return Place(trial.group, trial.modality, float(trial.condition != control))

        own = [cell for (agent, name), cell in cells.items() if name in (label, control) and (agent, label) in cells]
        players = on_axis([trial for cell in own for trial in cell.trials], place, orders)
        pairs = compared(players, [str(spec) for spec in arm.specs])
        found += [(label, control, axis, one) for one in pairs if 1.0 in one.at(SUCCESS) and not one.copies]
    families = [(axis, *one.family) for _, _, axis, one in found]
    success = holm_by_family(families, [one.means[SUCCESS, 1.0].p_value for *_, one in found])
    changes = holm_by_family(families, [None if one.plays_alike else one.change_p for *_, one in found])
    changed = Counter(family for family, p in zip(families, changes, strict=True) if p is not None)
    for i, (label, control, axis, one) in enumerate(found):
        family = f"{_FAMILIES[one.baseline]}, {axis or 'conditions'}"
        of = every[one.second.agent, label].of | _versus(one) | {"modality": one.second.modality, "family": family}
        yield from _at_one(one, 1.0, of, success[i], families.count(families[i]))
        if changes[i] is not None:
            yield _change(one, 1.0, of, control, changes[i], changed[families[i]])


class _Pair(NamedTuple):
    """Two agents as a page shows them.

    Attributes:
        one, other: What sentences call them.
        rows: Their rows by quantity and by condition, or by part where they are over all flip rates.
        rates: The flip rates at which they are compared, by condition, ascending; one if both play the same at all.
        others: The conditions beside these.
    """

    one: Subject
    other: Subject
    rows: Mapping[tuple[str, str], Estimate]
    rates: Mapping[str, float]
    others: Sequence[str]

    @property
    def noise_counts(self) -> bool:
        """Whether false reports change the one more: what the test of any flip rate says."""
        row = self.rows.get((CHANGE, _ANY))
        return row is not None and row.p_value is not None and row.p_value < ALPHA

    @property
    def clearest(self) -> Estimate | None:
        """How much more the success of the one changes, at the flip rate where that is clearest."""
        rows = [row for name in self.rates if (row := self.rows.get((CHANGE, name)))]
        return min(rows, key=lambda row: (row.p_value or 0.0, -abs(row.value or 0.0)), default=None)


def _pairs(found: Results) -> list[_Pair]:
    """Every two agents that are compared, those that the study is about first."""
    by_pair: dict[tuple[str, ...], dict[tuple[str, str], Estimate]] = {}
    for quantity in (SUCCESS, STEPS, CHANGE, _SHARE):
        for row in found.where(quantity):
            if row.family.partition(",")[0] in _FAMILIES:
                by_pair.setdefault(tuple(row.pair.values()), {})[quantity, row.condition or row.of] = row
    known, pairs = {one.name: one.p for one in found.design.conditions}, []
    for (agent, modality, versus, versus_modality), rows in by_pair.items():
        players = (agent, modality), (versus, versus_modality)
        one, other = (Subject.of(who[0], own.shown if (own := found.player(*who)) else "") for who in players)
        names = [place for quantity, place in rows if quantity == SUCCESS and place]
        rates = sorted(((name, p) for name in names if (p := known.get(name)) is not None), key=itemgetter(1))
        once = any(_SAME in rows[SUCCESS, name].note for name, _ in rates)
        others = [name for name in names if known.get(name) is None]
        pairs.append(_Pair(one, other, rows, dict(rates[: 1 if once else None]), others))
    return sorted(pairs, key=lambda pair: next(iter(pair.rows.values())).family.startswith(_FAMILIES[1]))


def _said(pair: _Pair) -> str:
    """Two agents in a sentence, and one more of what false reports and other conditions do."""
    return " ".join(filter(None, (_over_rates_said(pair), _change_said(pair), _others_said(pair))))


def _over_rates_said(pair: _Pair) -> str:
    one, other, rows = pair.one, pair.other, pair.rows
    if (success := rows.get((SUCCESS, ""))) is None:
        return ""
    steps, own, its = rows[STEPS, ""], rows[_SHARE, ""].value, rows[_SHARE, "the other"].value
    n, two = success.n or 0, f"{one.name} and {other.name}"
    if _ALIKE in success.note:
        return f"{one.first} and {other.name} play alike: they act the same in all {n} trials, so nothing is tested."
    less = f"{change(success.value or 0.0, success.low, success.high)}; {p_value(success.p_value)}"
    against = f"{percent(own)} against {percent(its)} of {n} trials ({less})"
    if success.detected:
        solves, often = one.form("solves", "solve"), "more" if (success.value or 0.0) > 0 else "less"
        return f"{one.first} {solves} the box {often} often than {other.name}: {against}."
    ends = range_said(steps.low, steps.high, "{:+.1f}", 1).removeprefix(", ")
    sure = f"{ends}{'; ' * bool(ends)}{p_value(steps.p_value)}"
    none = max(own or 0.0, its or 0.0) <= _EDGE
    solved = f"the success of {two} could not be told apart: {against}"
    if none or min(own or 0.0, its or 0.0) >= 1 - _EDGE:
        nearly = ("almost none" if none else "nearly all") if {own, its} - {0.0, 1.0} else "none" if none else "all"
        solved = f"both solve {nearly} of {n} trials ({percent(own)} and {percent(its)})"
        if not steps.detected:
            size = f"{minus(f'{steps.value or 0.0:+.1f}')} steps{', ' * bool(ends)}{sure}"
            return f"How soon {two} solve the box could not be told apart ({size}); {solved}."
    if not steps.detected:
        return f"{capital(solved)}."
    apart = f"{abs(steps.value or 0.0):.1f} steps {'sooner' if (steps.value or 0.0) < 0 else 'later'}"
    sooner = f"{one.first} {one.form('is', 'are')} {apart} than {other.name} ({sure})"
    return f"{sooner}; {solved.replace(two, 'both', 1)}."


def _change_said(pair: _Pair) -> str:
    if (row := pair.clearest) is None:
        return ""
    where = f"from a flip rate of {pair.rates[row.control]:g} to {pair.rates[row.condition]:g}"
    size = f"{change(row.value or 0.0, row.low, row.high)}; {p_value(pair.rows[CHANGE, _ANY].p_value)}"
    if not pair.noise_counts:
        return f"Whether false reports change one of them more could not be told ({where}: {size})."
    more = "rises more, or falls less," if (row.value or 0.0) > 0 else "rises less, or falls more,"
    return (
        f"False reports affect the two differently: {where} the success of {pair.one.name} {more} than that of "
        f"{pair.other.name} ({size})."
    )


def _others_said(pair: _Pair) -> str:
    """What was detected under conditions that are no flip rates; what was not is counted."""
    if not pair.others:
        return ""
    solves, parts = pair.one.form("solves", "solve"), []
    ways = (
        (SUCCESS, f"{solves} more trials under", f"{solves} fewer trials under"),
        (CHANGE, "gains more, or loses less, by", "gains less, or loses more, by"),
    )
    for (quantity, more, less), name in product(ways, pair.others):
        if (row := pair.rows.get((quantity, name))) and row.detected:
            parts.append(f"{more if (row.value or 0.0) > 0 else less} {name} ({points_cell(row)} points)")
    if parts:
        return f"Under other conditions, {pair.one.name} beside {pair.other.name} {first_three(parts, '; ')}."
    which = pair.others[0] if len(pair.others) == 1 else f"any of {len(pair.others)} other conditions"
    return f"No difference between {pair.one.name} and {pair.other.name} was detected under {which}."


def _table(found: Results) -> TextTable:
    table = [["agent", "compared with", "under", "trials", "success of both", "success, points", "P", "steps"]]
    table[0] += ["P of steps", "effect, points", "P of effect", "conclusion"]
    for pair, place in _places(found):
        success, steps = pair.rows[SUCCESS, place], pair.rows[STEPS, place]
        moved = pair.rows.get((CHANGE, place or "mean"))
        tested = moved if place else pair.rows.get((CHANGE, _ANY))
        under = f"flip rate {pair.rates[place]:g}" if place in pair.rates else place
        under = under or over_rates(found).removeprefix("over ")
        shares = NONE if place else " and ".join(percent(pair.rows[_SHARE, of].value) for of in ("", "the other"))
        table.append(
            [
                pair.one.name, pair.other.name, EVERY if _SAME in success.note else under, str(success.n), shares,
                points_cell(success), p_cell(success.p_value), steps_cell(steps), p_cell(steps.p_value),
                points_cell(moved), p_cell(tested.p_value if tested else None),
                "play alike" if _ALIKE in success.note else DETECTED[success.detected],
            ]
        )  # fmt: skip
    said = [i for i, column in enumerate(zip(*table, strict=True)) if {*column[1:]} - {NONE}]
    return [[row[i] for i in said] for row in table] if len(table) > 1 else []


def _places(found: Results) -> Iterator[tuple[_Pair, str]]:
    """Every pair over all flip rates, at each, and under every other condition."""
    for pair in _pairs(found):
        whole = [""] * ((SUCCESS, "") in pair.rows)
        yield from ((pair, place) for place in [*whole, *(pair.rates if found.several_p else ()), *pair.others])


_TABLE = Table(
    "comparisons", _table, 3, drawn=lambda found: [pair.rows[SUCCESS, place] for pair, place in _places(found)]
)


def _show(found: Results) -> Iterator[Part]:
    if not (pairs := _pairs(found)):
        return
    sentences = [_said(pair) for pair in pairs]
    if len(pairs) == 1:
        answer = _over_rates_said(pairs[0]) or sentences[0]
    else:
        moved = [pair for pair in pairs if (CHANGE, _ANY) in pair.rows]
        under = [pair.rows[SUCCESS, name].detected for pair in pairs for name in pair.others]
        counts = [
            f"{sum(pair.rows[quantity, ''].detected for pair in pairs if (quantity, '') in pair.rows)} in {what}"
            for quantity, what in ((SUCCESS, "success"), (STEPS, "steps"))
            if any((quantity, "") in pair.rows for pair in pairs)
        ]
        counts += [f"{sum(pair.noise_counts for pair in moved)} in what false reports do"] * bool(moved)
        counts += [f"{sum(under)} of {len(under)} under other conditions"] * bool(under)
        answer = f"Differences detected between {len(pairs)} pairs of agents: {', '.join(counts)}."
    blocks: list[Block] = [Text(said) for said in (sentences[:3] if len(pairs) > 1 else ())]
    if more := sentences[3:]:
        blocks.append(Detail(f"{len(more)} more pairs in words", [Text(said) for said in more]))
    people = (
        " Beside people: Student's t with a variance clustered by person and block; under one condition whole people "
        "are permuted."
    )
    note = Note(
        "Success (drawn; filled: detected), steps and effect: the first agent minus the second, over trials that both "
        "finished; an unsolved one counts with its whole budget. Effect: what false reports, or a condition, change in "
        "success.",
        "Over all flip rates the two agents swap whole blocks (permutation), under one condition it is McNemar's test. "
        "Effect: signs of blocks are flipped.",
        "A trial has the same random numbers (labels, flips, draws) for every agent and condition; a block is one "
        "repetition and trial. P values are corrected for pairs and conditions (Holm), steps under one condition are "
        "not; pairs with baselines, the doses of an axis and all other conditions are families of their own. Detected: "
        "the test rejects and the interval leaves out 0. Who solves nearly all trials cannot gain many points."
        + people
        * (PEOPLE in found.study["agents"]),
    )
    blocks += [_TABLE, note_at(found, note)]
    yield Part("Agents compared", answer, blocks)


SECTIONS = (Section(name=_NAME, title="Agents compared", rows=_rows, show=_show, tables=(_TABLE,)),)

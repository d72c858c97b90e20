"""Agents compared: who of every two solves more, how soon, and whether false reports or a condition change one more.

All flip rates together and each alone, and every condition beside them. Where success of both is at its ceiling or its
floor, what is told is how soon. Two agents that act the same in every trial play alike, and nothing is tested.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING, Any

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
from lockprobe.report.section import Block, Caption, Detail, Figure, Note, Part, Section, Table, Text
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.report.table_rows import over_rates, points_cell, steps_cell
from lockprobe.statistics.agent_comparison.paired import BlockMean
from lockprobe.statistics.agent_comparison.pairs import AgentComparison, Apart, compared, comparisons, untested
from lockprobe.statistics.conditions.axis import FLIPS
from lockprobe.statistics.conditions.axis_trials import Place, on_axis
from lockprobe.statistics.contrast import acting
from lockprobe.statistics.inference.holm import holm_by_family
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.sequential.contrasts import E_PROCESS
from lockprobe.studies.study_design import design_of
from lockprobe.trial.record import Trial

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

_NAME = "agents_compared"
_SUCCESS, _STEPS, _CHANGE, _SHARE = "success_difference", "steps_difference", "success_interaction", "success_in_pairs"
_ANY = "any flip rate"

_FAMILIES = {"subjects": "agents", "reference": "agents and baselines"}
"""Kind of pair -> the name of its family."""

_SAME = "the same at every flip rate"
_ALIKE = "the two play alike: nothing to test"
_WORST = "holds whatever became of broken trials"
_BY_PERSON = "t, clustered by person and block"

_EDGE = 0.1
"""So near to 0 or 1 the success of two agents is at its floor or its ceiling, where it does not tell them apart."""

_SHOWN = 30
"""Rows that a panel has room for."""


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    of_cell = {(cell.agent, cell.condition): cell.of for cell in numbers.cells}
    found = comparisons([one.trials for one in numbers.courses])
    names = {
        (one.agent, one.modality): {dose: trials[0].condition for dose, trials in one.by_dose.items()}
        for one in numbers.courses
    }
    for one in found:
        together = [other for other in found if other.family == one.family]
        cells = {dose: of_cell[one.second[0], names[one.second][dose]] for dose in one.at}
        yield from _over_rates(one, len(together))
        of = _versus(one) | {"note": "; ".join([_SAME] * one.copies + [_WORST] * one.bounded)}
        many = sum(1 if other.copies else len(other.at) for other in together)
        for dose, apart in one.at.items():
            yield from _at_one(one, apart, cells[dose] | of, many, alike=dose in one.alike)
        if one.interaction:
            control = names[one.second][one.interaction.lowest]
            yield from _changes(one, sum(other.interaction is not None for other in together))
            for dose, moved in one.interaction.at:
                of = cells[dose] | _versus(one) | {"control": control}
                yield _change(one, moved, of, moved.p_value, len(one.interaction.at))
    yield from _under_conditions(numbers)


def _versus(one: AgentComparison) -> dict[str, Any]:
    return {"versus": one.first[0], "versus_modality": one.first[1], "family": _FAMILIES[one.among]}


def _mean(found: BlockMean) -> dict[str, Any]:
    return {"value": found.value, "low": found.low, "high": found.high, "n": found.pairs, "clusters": found.blocks}


def _over_rates(one: AgentComparison, pairs: int) -> Iterator[Estimate]:
    agent, modality = one.second
    of = {"agent": agent, "modality": modality, "axis": FLIPS.name} | _versus(one)
    test = _BY_PERSON if one.people else E_PROCESS if one.every_look else "permutation within blocks"
    tested: dict[str, Any] = {"test": test, "corrected_for": pairs, "note": _WORST * one.bounded}
    tested = {"note": _ALIKE} if one.plays_alike else tested
    for quantity, unit, found in ((_SUCCESS, "points", one.success), (_STEPS, "steps", one.steps)):
        yield Estimate(quantity=quantity, unit=unit, p_value=found.p_value, **tested, **of, **_mean(found))
    for part, share in zip(("the other", ""), one.shares, strict=True):
        yield Estimate(quantity=_SHARE, of=part, **of, n=one.success.pairs, value=share)


def _at_one(
    one: AgentComparison, apart: Apart, of: Mapping[str, Any], many: int, *, alike: bool = False
) -> Iterator[Estimate]:
    """Two agents under one condition; the P value of success is corrected for so many."""
    tests = ("permutation of people",) * 2 if one.people else ("McNemar", "permutation within blocks")
    tests = (E_PROCESS,) * 2 if one.every_look else ("", "") if alike else tests
    own = dict(of) | ({"note": "; ".join(filter(None, (of.get("note"), _ALIKE)))} if alike else {})
    success = _mean(apart.success) | {"clusters": None, "p_value": apart.success.p_value, "corrected_for": many}
    yield Estimate(quantity=_SUCCESS, unit="points", test=tests[0], **own, **success)
    yield Estimate(
        quantity=_STEPS, unit="steps", test=tests[1], p_value=apart.steps.p_value, **own, **_mean(apart.steps)
    )


def _changes(one: AgentComparison, pairs: int) -> Iterator[Estimate]:
    """How much more false reports change the success of the one than of the other, over all flip rates."""
    assert one.interaction is not None
    of = _versus(one) | {"quantity": _CHANGE, "unit": "points", "axis": FLIPS.name}
    of |= {"agent": one.second[0], "modality": one.second[1]}
    yield Estimate(of="mean", **of, **_mean(one.interaction.mean))
    p_value, many = one.interaction.p_adjusted, pairs * len(one.interaction.at)
    yield Estimate(of=_ANY, **of, p_value=p_value, corrected_for=many, test=_test_of_change(one))


def _change(one: AgentComparison, found: BlockMean, of: Mapping[str, Any], tested: float | None, many: int) -> Estimate:
    columns = _mean(found) | {"p_value": tested, "corrected_for": many, "test": _test_of_change(one)}
    return Estimate(quantity=_CHANGE, unit="points", **of, **columns)


def _test_of_change(one: AgentComparison) -> str:
    return _BY_PERSON if one.people else "sign flips of blocks"


def _under_conditions(numbers: StudyNumbers) -> Iterator[Estimate]:
    """Every pair under each condition that is no flip rate, and how much more the condition changes the one.

    The pairs of one kind under the doses of an axis are a family, and under all other conditions of a modality another
    one. Two agents that each play a condition and its control alike are compared under the control alone.
    """
    design, orders = design_of(numbers.study), numbers.opened.orders
    every = {(cell.agent, cell.condition): cell for cell in numbers.cells}
    cells = acting(every, design)
    found: list[tuple[str, str, str, AgentComparison]] = []
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
        found += [(label, control, axis, one) for one in pairs if 1.0 in one.at and not one.copies]
    families = [(axis, *one.family) for _, _, axis, one in found]
    tested = holm_by_family(families, [one.at[1.0].success.p_value for *_, one in found])
    moved = [None if one.plays_alike else one.interaction for *_, one in found]
    changed = holm_by_family(families, [None if one is None else one.p_value for one in moved])
    for i, (label, control, axis, one) in enumerate(found):
        apart, alike = one.at[1.0], 1.0 in one.alike
        apart = untested(apart) if alike else apart._replace(success=replace(apart.success, p_value=tested[i]))
        family = f"{_FAMILIES[one.among]}, {axis or 'conditions'}"
        of = every[one.second[0], label].of | _versus(one) | {"modality": one.second[1], "family": family}
        yield from _at_one(one, apart, of, families.count(families[i]), alike=alike)
        if (change_ := moved[i]) is not None:
            many = sum(other is not None for other, name in zip(moved, families, strict=True) if name == families[i])
            yield _change(one, change_.at[0].change, of | {"control": control}, changed[i], many)


_Pair = dict[tuple[str, str], Estimate]
"""The rows of two agents by quantity and by condition, or by part where they are over all flip rates."""


def _pairs(found: Results) -> list[_Pair]:
    """Every two agents that are compared, those that the study is about first."""
    pairs: dict[tuple[str, ...], _Pair] = {}
    for quantity in (_SUCCESS, _STEPS, _CHANGE, _SHARE):
        for row in found.where(quantity):
            if row.family.partition(",")[0] in _FAMILIES.values():
                pairs.setdefault(tuple(row.pair.values()), {})[quantity, row.condition or row.of] = row
    return sorted(pairs.values(), key=lambda one: next(iter(one.values())).family.startswith(_FAMILIES["reference"]))


def _places(found: Results, pair: _Pair, *, rates: bool = False) -> list[str]:
    """The conditions under which two agents are compared: those that are no flip rates, or the flip rates."""
    known = {one.name: one.p for one in found.design.conditions}
    names = [place for quantity, place in pair if quantity == _SUCCESS and place]
    own = [name for name in names if (known.get(name) is not None) == rates]
    once = rates and any(_SAME in pair[_SUCCESS, name].note for name in own)
    return sorted(own[:1] if once else own, key=lambda name: known[name] or 0.0) if rates else own


def _subjects(found: Results, pair: _Pair) -> list[Subject]:
    of = next(iter(pair.values())).pair
    named = (of["agent"], of["modality"]), (of["versus"], of["versus_modality"])
    return [Subject.of(agent, one.shown if (one := found.player(agent, shown)) else "") for agent, shown in named]


def said(found: Results, pair: _Pair) -> str:
    """Two agents in a sentence, and one more of what false reports and other conditions do."""
    one, other = _subjects(found, pair)
    parts = [
        _over_rates_said(pair, one, other),
        _change_said(found, pair, one, other),
        _others_said(found, pair, one, other),
    ]
    return " ".join(filter(None, parts))


def _over_rates_said(pair: _Pair, one: Subject, other: Subject) -> str:
    if (success := pair.get((_SUCCESS, ""))) is None:
        return ""
    steps, own, its = pair[_STEPS, ""], pair[_SHARE, ""].value, pair[_SHARE, "the other"].value
    n, two = success.n or 0, f"{one.name} and {other.name}"
    if _ALIKE in success.note:
        return f"{one.first} and {other.name} play alike: they act the same in all {n} trials, so nothing is tested."
    less = f"{change(success.value or 0.0, success.low, success.high)}; {p_value(success.p_value)}"
    against = f"{percent(own)} against {percent(its)} of {n} trials ({less})"
    if success.detected:
        solves, often = one.form("solves", "solve"), "more" if (success.value or 0.0) > 0 else "less"
        return f"{one.first} {solves} the box {often} often than {other.name}: {against}."
    none = max(own or 0.0, its or 0.0) <= _EDGE
    solved = f"the success of {two} could not be told apart: {against}"
    if none or min(own or 0.0, its or 0.0) >= 1 - _EDGE:
        nearly = ("almost none" if none else "nearly all") if {own, its} - {0.0, 1.0} else "none" if none else "all"
        solved = f"both solve {nearly} of {n} trials ({percent(own)} and {percent(its)})"
        if not steps.detected:
            size = f"{minus(f'{steps.value or 0.0:+.1f}')} steps{_in_steps(steps, ', ')}"
            return f"How soon {two} solve the box could not be told apart ({size}); {solved}."
    if not steps.detected:
        return f"{capital(solved)}."
    apart = f"{abs(steps.value or 0.0):.1f} steps {'sooner' if (steps.value or 0.0) < 0 else 'later'}"
    sooner = f"{one.first} {one.form('is', 'are')} {apart} than {other.name} ({_in_steps(steps)})"
    return f"{sooner}; {solved.replace(two, 'both', 1)}."


def _in_steps(row: Estimate, before: str = "") -> str:
    said = range_said(row.low, row.high, "{:+.1f}", 1).removeprefix(", ")
    return f"{before * bool(said)}{said}{'; ' * bool(said)}{p_value(row.p_value)}"


def _clearest(found: Results, pair: _Pair) -> Estimate | None:
    """How much more the success of the one changes, at the flip rate where that is clearest."""
    names = _places(found, pair, rates=True)
    rows = [row for name in names if (row := pair.get((_CHANGE, name)))]
    return min(rows, key=lambda row: (row.p_value or 0.0, -abs(row.value or 0.0)), default=None)


def _change_said(found: Results, pair: _Pair, one: Subject, other: Subject) -> str:
    if (row := _clearest(found, pair)) is None:
        return ""
    rates = {condition.name: condition.p for condition in found.design.conditions}
    where = f"from a flip rate of {rates[row.control]:g} to {rates[row.condition]:g}"
    size = f"{change(row.value or 0.0, row.low, row.high)}; {p_value(pair[_CHANGE, _ANY].p_value)}"
    if not _noise_counts(pair):
        return f"Whether false reports change one of them more could not be told ({where}: {size})."
    more = "rises more, or falls less," if (row.value or 0.0) > 0 else "rises less, or falls more,"
    return (
        f"False reports affect the two differently: {where} the success of {one.name} {more} than that of {other.name} "
        f"({size})."
    )


def _noise_counts(pair: _Pair) -> bool:
    tested = pair[_CHANGE, _ANY].p_value
    return tested is not None and tested < ALPHA


def _others_said(found: Results, pair: _Pair, one: Subject, other: Subject) -> str:
    """What was detected under conditions that are no flip rates; what was not is counted."""
    names = _places(found, pair)
    if not names:
        return ""
    solves = one.form("solves", "solve")
    parts = [
        f"{solves} {'more' if (row.value or 0.0) > 0 else 'fewer'} trials under {name} ({points_cell(row)} points)"
        for name in names
        for row in [pair[_SUCCESS, name]]
        if row.detected
    ]
    parts += [
        f"{'gains more, or loses less,' if (row.value or 0.0) > 0 else 'gains less, or loses more,'} by {name} "
        f"({points_cell(row)} points)"
        for name in names
        for row in filter(None, [pair.get((_CHANGE, name))])
        if row.detected
    ]
    if parts:
        return f"Under other conditions, {one.name} beside {other.name} {first_three(parts, '; ')}."
    which = names[0] if len(names) == 1 else f"any of {len(names)} other conditions"
    return f"No difference between {one.name} and {other.name} was detected under {which}."


def _answer(found: Results, pairs: Sequence[_Pair]) -> str:
    if len(pairs) == 1:
        return _over_rates_said(pairs[0], *_subjects(found, pairs[0])) or said(found, pairs[0])
    counts = []
    for quantity, what in ((_SUCCESS, "in success"), (_STEPS, "in steps"), (_CHANGE, "in what false reports do")):
        rows = [(pair, pair[quantity, ""]) for pair in pairs if (quantity, "") in pair]
        detected = [row.detected for _, row in rows]
        if quantity == _CHANGE:
            detected = [_noise_counts(pair) for pair in pairs if (_CHANGE, _ANY) in pair]
        if detected:
            counts.append(f"{sum(detected)} {what}")
    under = [pair[_SUCCESS, name].detected for pair in pairs for name in _places(found, pair)]
    if under:
        counts.append(f"{sum(under)} of {len(under)} under other conditions")
    return f"Differences detected between {len(pairs)} pairs of agents: {', '.join(counts)}."


def _table(found: Results) -> TextTable:
    head = [
        "agent",
        "compared with",
        "under",
        "trials",
        "success of both",
        "success, points",
        "P",
        "steps",
        "P of steps",
    ]
    head += ["effect, points", "P of effect", "conclusion"]
    table = [head]
    rates = {one.name: one.p for one in found.design.conditions}
    for pair in _pairs(found):
        names = [one.name for one in _subjects(found, pair)]
        at_rates = _places(found, pair, rates=True) if found.several_p else []
        for place in [""] * ((_SUCCESS, "") in pair) + at_rates + _places(found, pair):
            success, steps = pair[_SUCCESS, place], pair[_STEPS, place]
            moved = pair.get((_CHANGE, place or "mean"))
            tested = moved if place else pair.get((_CHANGE, _ANY))
            rate = rates.get(place)
            under = (
                over_rates(found).removeprefix("over ")
                if not place
                else place
                if rate is None
                else f"flip rate {rate:g}"
            )
            shares = NONE if place else " and ".join(percent(pair[_SHARE, of].value) for of in ("", "the other"))
            table.append(
                [
                    *names, EVERY if _SAME in success.note else under, str(success.n), shares,
                    points_cell(success), p_cell(success.p_value), steps_cell(steps), p_cell(steps.p_value),
                    points_cell(moved), p_cell(tested.p_value if tested else None),
                    "play alike" if _ALIKE in success.note else DETECTED[success.detected],
                ]
            )  # fmt: skip
    return table if len(table) > 1 else []


_TABLE = Table("comparisons", _table, numeric_from=3)


def draw(found: Results) -> Drawing | None:
    """Every two agents: success, steps, and how much more false reports or a condition change the first."""
    from lockprobe.report.figures.differences import Panel, difference, panels_sheet
    from lockprobe.report.figures.forest import ForestRow
    from lockprobe.report.figures.frame import safe_name

    pairs = _pairs(found)
    rates = {one.name: one.p for one in found.design.conditions}
    columns: dict[tuple[str, str], list[ForestRow]] = {}
    for pair in pairs:
        names = [safe_name(one.name, 30) for one in _subjects(found, pair)]
        apart = f"{names[0]}\n\N{MINUS SIGN} {names[1]}"

        def add(quantity: str, place: str, row: Estimate | None, name: str = apart, where: str = "") -> None:
            if row is not None:
                detected = _noise_counts(pair) if where else row.detected  # noqa: B023
                made = difference(name, row, detected=detected, unit=row.unit, where=where)
                columns.setdefault((quantity, place), []).append(made)

        for quantity in (_SUCCESS, _STEPS):
            add(quantity, "", pair.get((quantity, "")))
        if row := _clearest(found, pair):
            add(_CHANGE, "", row, where=f"to {rates[row.condition]:g}: ")
        for place, quantity in product(_places(found, pair), (_SUCCESS, _STEPS, _CHANGE)):
            add(quantity, "under", pair.get((quantity, place)), f"{apart}\n{safe_name(place, 38)}")
    whole = "over all flip rates" if found.several_p else ""
    titles = {
        (_SUCCESS, ""): f"success {whole}", (_STEPS, ""): f"steps {whole}",
        (_SUCCESS, "under"): "success under other conditions", (_STEPS, "under"): "steps under other conditions",
        (_CHANGE, ""): "most that false reports change",
        (_CHANGE, "under"): "what other conditions change",
    }  # fmt: skip
    made = []
    for key, title in titles.items():
        if rows := columns.get(key):
            more = f"the first {_SHOWN} of {len(rows)}; all are in the table" if len(rows) > _SHOWN else ""
            steps = key[0] == _STEPS
            label = f"difference, {'steps' if steps else 'points'}"
            made.append(Panel.of(rows[:_SHOWN], title, more, label=label, steps=steps))
    return panels_sheet(made, min(2, len(made)) or 1)


def _caption(found: Results) -> Caption:
    each = ", each flip rate alone is in the table" * found.several_p
    bars = "of means over blocks, which hold at every look" if found.progress.every_look else "clustered by block"
    return Caption(
        f"Every two agents on the same boxes, the first minus the second; filled marks were detected{each}. "
        "Below 0 in steps the first is sooner.",
        f"Bars are 95 % intervals {bars}; those of what false reports change are corrected for the flip rates. "
        "Tests are corrected for the pairs, but those of steps under other conditions.",
    )


_FIGURE = Figure(
    "agents-compared",
    "Differences between every two agents in success, in steps and in what false reports change",
    _caption,
    draw=f"{__name__}:draw",
)


def _show(found: Results) -> Iterator[Part]:
    if pairs := _pairs(found):
        yield Part("Agents compared", _answer(found, pairs), list(_blocks(found, pairs)))


def _blocks(found: Results, pairs: Sequence[_Pair]) -> Iterator[Block]:
    sentences = [Text(said(found, pair)) for pair in pairs]
    yield from sentences[:3] if len(pairs) > 1 else ()
    yield _FIGURE
    if sentences[3:]:
        yield Detail(f"{len(sentences) - 3} more pairs in words", sentences[3:])
    people = (
        " Beside people: Student's t with a variance clustered by person and block; under one condition whole people "
        "are permuted."
    )
    note = Note(
        "Success, steps and effect: the first agent minus the second, over trials that both finished; an unsolved one "
        "counts with its whole budget. Effect: what false reports, or a condition, change in success.",
        "Over all flip rates the two agents swap whole blocks (permutation), under one condition it is McNemar's test. "
        "Effect: signs of blocks are flipped.",
        "A trial has the same random numbers (labels, flips, draws) for every agent and condition; a block is one "
        "repetition and trial. P values are corrected for pairs and conditions (Holm), steps under one condition are "
        "not; pairs with baselines, the doses of an axis and all other conditions are families of their own. Detected: "
        "the test rejects and the interval leaves out 0. Who solves nearly all trials cannot gain many points."
        + people
        * (PEOPLE in found.study["agents"]),
    )
    yield Detail("Pairs of agents, in numbers", [_TABLE, note_at(found, note)])


SECTIONS = (Section(name=_NAME, title="Agents compared", rows=_rows, show=_show, tables=(_TABLE,), figures=(_FIGURE,)),)

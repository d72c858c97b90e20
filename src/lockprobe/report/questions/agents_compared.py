"""Agents compared: every two of them on the same boxes, in success, steps and the effect of false reports."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from lockprobe.foundation.formatting import NONE, p_cell, percent
from lockprobe.foundation.spec import PEOPLE
from lockprobe.report.every_look import note_at
from lockprobe.report.format import EVERY, TextTable
from lockprobe.report.prose.agent_comparison import comparison_said
from lockprobe.report.prose.section_answers import NO_NUMBERS
from lockprobe.report.rows import Estimate, Finding, Results, Row
from lockprobe.report.section import Block, Caption, Detail, Figure, Heading, Note, Part, Section, Table, Text
from lockprobe.report.study_numbers import PlayedCell, StudyNumbers
from lockprobe.report.table_rows import over_rates, points_cell, steps_cell
from lockprobe.statistics.agent_comparison.interaction import InteractionAt
from lockprobe.statistics.agent_comparison.pair import AgentComparison, ComparisonAt
from lockprobe.statistics.agent_comparison.paired import BlockMean
from lockprobe.statistics.conditions.axis import FLIPS
from lockprobe.statistics.proportions import Paired
from lockprobe.statistics.sequential.contrasts import E_PROCESS

_SUBJECTS, _BASELINES = "agents", "agents and baselines"
FAMILIES = {"subjects": _SUBJECTS, "reference": _BASELINES}
"""Kind of pair -> the name of its family."""


_ALIKE = "the same at every flip rate"
_WORST = "holds whatever became of broken trials"
_BY_PERSON = "t, clustered by person and block"

_Cells = Mapping[tuple[str, str, float], PlayedCell]
"""Agent, modality and flip rate -> the cell."""


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    cells = {(cell.agent, cell.modality, cell.summary.dose): cell for cell in numbers.cells if cell.player}
    for one in numbers.flips.comparisons:
        together = [other for other in numbers.flips.comparisons if other.family == one.family]
        yield from _over_all(one, len(together))
        yield from _by_p(one, cells, sum(1 if other.copies else len(other.at) for other in together))
        yield from _changes(one, cells, sum(other.interaction is not None for other in together))
        (agent, modality), said = one.second, " ".join(comparison_said(one, numbers.flips))
        rests_on = ("success_difference", "success_change_difference", "steps_difference")
        yield Finding(
            section="agents_compared",
            kind=FAMILIES[one.among],
            agent=agent,
            modality=modality,
            text=said,
            rests_on=rests_on,
        )
    yield from numbers.answer("agents_compared", "success")


def _versus(one: AgentComparison) -> dict[str, Any]:
    return {"versus": one.first[0], "versus_modality": one.first[1], "family": FAMILIES[one.among]}


def _mean(found: BlockMean | Paired) -> dict[str, Any]:
    """The columns of a difference with its interval."""
    counted = {"n": found.n} if isinstance(found, Paired) else {"n": found.pairs, "clusters": found.blocks}
    return {"value": found.value, "low": found.low, "high": found.high, **counted}


def _over_all(one: AgentComparison, pairs: int) -> Iterator[Estimate]:
    """Two agents over all flip rates."""
    agent, modality = one.second
    of = {"agent": agent, "modality": modality, "axis": FLIPS.name} | _versus(one)
    test = _BY_PERSON if one.people else E_PROCESS if one.every_look else "permutation within blocks"
    for quantity, unit, found, adjusted in (
        ("success_difference", "points", one.success, one.success_adjusted),
        ("steps_difference", "steps", one.steps, one.steps_adjusted),
    ):
        for part, p_value, many in (("", adjusted, pairs), ("uncorrected", found.p_value, 1)):
            yield Estimate(
                quantity=quantity,
                of=part,
                unit=unit,
                p_value=p_value,
                corrected_for=many,
                test=test,
                note=_WORST if one.bounded else "",
                **of,
                **_mean(found),
            )
    for part, share in (("", one.second_share), ("the other", one.first_share)):
        yield Estimate(quantity="success_in_pairs", of=part, **of, n=one.success.pairs, value=share)
    yield Estimate(quantity="played_by_one_only", **of, unit="trials", value=one.alone)


def _by_p(one: AgentComparison, cells: _Cells, many: int) -> Iterator[Estimate]:
    """The same at each flip rate."""
    of = _versus(one) | {"note": "; ".join([_ALIKE] * one.copies + [_WORST] * one.bounded)}
    for at in one.at:
        yield from at_one_condition(
            at, cells[*one.second, at.dose].of | of, many, people=one.people, every_look=one.every_look
        )


def at_one_condition(
    at: ComparisonAt, of: Mapping[str, Any], many: int, *, people: bool, every_look: bool
) -> Iterator[Estimate]:
    """Two agents under one condition.

    Args:
        at: Their comparison.
        of: Columns of all rows.
        many: For how many comparisons the P value of success is corrected.
        people: Whether one of the two is people.
        every_look: Whether intervals and P values hold at every look.
    """
    found = at.success
    tests = ("permutation of people",) * 2 if people else ("McNemar", "permutation within blocks")
    tests = (E_PROCESS,) * 2 if every_look else tests
    for part, p_value, of_tests in (("", at.p_adjusted, many), ("uncorrected", found.p_value, 1)):
        tested = {"p_value": p_value, "corrected_for": of_tests, "test": tests[0]}
        yield Estimate(quantity="success_difference", of=part, unit="points", **of, **_mean(found) | tested)
    tested = {"p_value": at.steps.p_value, "test": tests[1]}
    yield Estimate(quantity="steps_difference", unit="steps", **of, **_mean(at.steps) | tested)
    for part, count in (("only", found.only_second), ("only the other", found.only_first)):
        counted: dict[str, Any] = {"value": count, "count": count, "n": found.n, "unit": "trials"}
        yield Estimate(quantity="solved_by_one_only", of=part, **of, **counted)


def _changes(one: AgentComparison, cells: _Cells, pairs: int) -> Iterator[Estimate]:
    """How much more the success of the one changes with false reports than that of the other."""
    moved = one.interaction
    if moved is None:
        return
    of = {"quantity": "success_change_difference", "unit": "points"} | _versus(one)
    over_all = of | {"agent": one.second[0], "modality": one.second[1], "axis": FLIPS.name}
    rates, test = len(moved.at), _test_of_change(people=one.people)
    yield Estimate(of="mean", **over_all, **_mean(moved.mean))
    yield Estimate(of="any flip rate", **over_all, p_value=moved.p_adjusted, corrected_for=pairs * rates, test=test)
    yield Estimate(of="any flip rate, one pair", **over_all, p_value=moved.p_value, corrected_for=rates, test=test)
    control = cells[*one.second, moved.lowest].condition
    for at in moved.at:
        own = cells[*one.second, at.dose].of | _versus(one) | {"control": control, "corrected_for": rates}
        yield change_at(at, own, at.p_adjusted, people=one.people)


def change_at(at: InteractionAt, of: Mapping[str, Any], p_value: float | None, *, people: bool) -> Estimate:
    """How much more one condition changes the one agent than the other.

    Args:
        at: The change.
        of: Columns of the row.
        p_value: Its P value, corrected as the columns say.
        people: Whether one of the two is people.
    """
    tested = {"p_value": p_value, "test": _test_of_change(people=people)}
    return Estimate(quantity="success_change_difference", unit="points", **of, **_mean(at.change) | tested)


def _test_of_change(*, people: bool) -> str:
    return _BY_PERSON if people else "sign flips of blocks"


def _pairs(found: Results) -> list[dict[str, str]]:
    """Every two agents that are compared."""
    return [row.pair for row in found.where("played_by_one_only")]


def labels(found: Results, pair: Mapping[str, str]) -> list[str]:
    """What tables call two agents that are compared."""
    return [found.label(pair["agent"], pair["modality"]), found.label(pair["versus"], pair["versus_modality"])]


def _table(found: Results) -> TextTable:
    """Every two agents over all flip rates."""
    head = ["agent", "compared with", "pairs of trials", "success", "success of the other", "difference, points"]
    table = [[*head, "P", "corrected P", "difference in steps", "P", "corrected P", "played by one only"]]
    for pair in _pairs(found):
        own = {(row.quantity, row.of): row for row in found.where(**pair, axis=FLIPS.name)}
        success, steps = own["success_difference", ""], own["steps_difference", ""]
        table.append(
            [
                *labels(found, pair),
                str(success.n),
                *(percent(own["success_in_pairs", of].value) for of in ("", "the other")),
                points_cell(success),
                *(p_cell(own["success_difference", of].p_value) for of in ("uncorrected", "")),
                steps_cell(steps),
                *(p_cell(own["steps_difference", of].p_value) for of in ("uncorrected", "")),
                f"{own['played_by_one_only', ''].value:g}",
            ]
        )
    return table


def _table_by_p(found: Results) -> TextTable:
    """The same at each flip rate; of two agents that both play alike at all of them only once."""
    rates = {one.name: one.p for one in found.design.conditions}
    head = ["agent", "compared with", "flip rate", "pairs of trials", "solved only by the first"]
    head += ["solved only by the other", "difference, points", "McNemar", "corrected P", "difference in steps"]
    table = [head]
    for pair in _pairs(found):
        own = [row for row in found.where(**pair, axis="", control="") if rates.get(row.condition) is not None]
        rows = {(row.quantity, row.condition, row.of): row for row in own}
        success = [row for (quantity, _, of), row in rows.items() if quantity == "success_difference" and not of]
        table += [
            [
                *labels(found, pair),
                EVERY if _ALIKE in one.note else f"{rates[one.condition]:g}",
                str(one.n),
                *(str(rows["solved_by_one_only", one.condition, of].count) for of in ("only", "only the other")),
                points_cell(one),
                *(p_cell(rows["success_difference", one.condition, of].p_value) for of in ("uncorrected", "")),
                steps_cell(rows["steps_difference", one.condition, ""]),
            ]
            for one in (success[:1] if _ALIKE in success[0].note else success)
        ]
    return table


def _interaction_table(found: Results) -> TextTable:
    """Differences between agents in the effect of false reports."""
    rates = {one.name: one.p for one in found.design.conditions}
    head = ["agent", "compared with", "from flip rate", "to flip rate", "difference in change, points"]
    table = [[*head, "P, corrected for flip rates", "P, corrected for pairs"]]
    for mean in found.where("success_change_difference", of="mean"):
        pair = mean.pair
        own = found.where("success_change_difference", **pair, of="")
        rows = [row for row in own if rates[row.condition] is not None]
        names = [*labels(found, pair), f"{rates[rows[0].control]:g}"]
        one_pair, corrected = (
            found.one("success_change_difference", **pair, of=of).p_value
            for of in ("any flip rate, one pair", "any flip rate")
        )
        table.append([*names, "all higher, mean", points_cell(mean), p_cell(one_pair), p_cell(corrected)])
        table += [[*names, f"{rates[row.condition]:g}", points_cell(row), p_cell(row.p_value), NONE] for row in rows]
    return table


_COMPARISONS = Table("comparisons", _table)
_BY_P = Table("comparisons-by-p", _table_by_p)
_INTERACTIONS = Table("interactions", _interaction_table, numeric_from=4)


def _caption(found: Results) -> Caption:
    shown = (
        "Differences between two agents on the same boxes, the first named minus the other; filled marks were detected."
    )
    if not found.where("success_change_difference", axis=FLIPS.name, of="mean"):
        bars = "clustered by block"
        if found.progress.every_look:
            bars = "of means over blocks, which hold at every look"
        computed = f"Bars are 95 % intervals {bars}. Tests are corrected for the number of pairs."
        return Caption(f"{shown} Compared {over_rates(found)}.", computed)
    return Caption(
        f"{shown} First: success over all flip rates; second: change of success from the lowest flip rate to the one "
        "with the clearest difference.",
        "Bars are 95 % intervals clustered by block, in the second corrected for all flip rates. Tests are corrected "
        "for the number of pairs, in the second also for all flip rates.",
    )


_SIDE_BY_SIDE = Figure(
    "side-by-side",
    "Paired differences between agents in success and in the effect of false reports",
    _caption,
    draw="lockprobe.report.figures.differences:side_by_side",
)


def _show(found: Results) -> Iterator[Part]:
    if _pairs(found):
        yield Part("Agents compared", found.answer_of("agents_compared") or NO_NUMBERS, list(_blocks(found)))


def _blocks(found: Results) -> Iterator[Block]:
    families = [row.family for row in found.where("played_by_one_only")]
    between = families.count(_SUBJECTS)
    yield Heading("Models compared" if between else "Agent and baselines")
    said = [Text(one) for one in found.said("agents_compared", _SUBJECTS)]
    if between:
        yield Heading("Pairs of agents on the same boxes")
        yield Detail("Pairs of agents, in words", said)
    yield _SIDE_BY_SIDE
    if between < len(families):
        beside = [Text(one) for one in found.said("agents_compared", _BASELINES)]
        yield Detail("Comparisons with baselines, in words", beside)
    yield Detail("Pairs of agents, in numbers", list(_numbers(found)))


def _numbers(found: Results) -> Iterator[Block]:
    people = (
        " If people are one of the two, the test is Student's t with a variance clustered by person and block; at one "
        "flip rate, whole people are permuted."
    )
    yield _COMPARISONS
    note = Note(
        "Differences: the first agent minus the second, over trials that both played without an error; an unsolved "
        "trial counts with its whole budget. A difference is detected if the test rejects and the 95 % interval "
        "excludes 0.",
        "Success and steps: permutation test of exchangeability, in which the two agents swap whole blocks. Corrected: "
        "for the number of pairs (Holm), separately for models with each other and for models with baselines.",
        "A trial uses the same random numbers (labels, flips, draws) for every agent and under every condition; a "
        "block is one repetition and trial. Agents of equal success that play differently may be rejected by the "
        f"permutation test alone.{people if PEOPLE in found.study['agents'] else ''}",
    )
    yield note_at(found, note)
    if not found.several_p:
        return
    yield _BY_P
    note = Note(
        "Differences at each flip rate.",
        "McNemar's exact test on pairs of trials. Corrected: for all pairs of agents and all flip rates (Holm); two "
        "agents that both act the same at every flip rate count once.",
    )
    yield note_at(found, note)
    if found.where("success_change_difference"):
        yield _INTERACTIONS
        yield Note(
            "Change of success from the lowest flip rate, the first agent minus the second, in points. An agent that "
            "already solves nearly all trials cannot gain many points.",
            "Sign-flip permutation test over blocks, corrected for all flip rates and for the number of pairs (Holm). "
            "Intervals are corrected for the flip rates, and the mean is not tested.",
        )


SECTIONS = (
    Section(
        name="agents_compared",
        title="Agents compared",
        rows=_rows,
        show=_show,
        tables=(_COMPARISONS, _BY_P, _INTERACTIONS),
        figures=(_SIDE_BY_SIDE,),
    ),
)

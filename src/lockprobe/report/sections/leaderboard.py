"""The leaderboard: every agent over all flip rates with its rank, and what its trials cost."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from markupsafe import Markup

from lockprobe.agents.llm.model_facts import Price
from lockprobe.foundation.formatting import NONE, bracketed, percent
from lockprobe.foundation.terminal_text import printable
from lockprobe.report.captions import share_intervals_said
from lockprobe.report.costs import cost_rows, price_asked, price_facts, price_of
from lockprobe.report.format import EVERY, TextTable
from lockprobe.report.rows import Cell, Course, Estimate, Results, Row
from lockprobe.report.section import Block, Cells, Detail, Note, Section, Table
from lockprobe.report.study_numbers import StudyNumbers, share_rows
from lockprobe.report.table_rows import over_rates, share_of_row, value_cell
from lockprobe.statistics.agent_comparison.leaderboard_row import Standing
from lockprobe.statistics.conditions.axis import FLIPS
from lockprobe.studies.costs.spending import dollars

__all__ = ["SECTIONS", "leaderboard_blocks"]


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    trials, known, prices = numbers.opened.flip_trials, numbers.opened.prices, dict[str, Price]()
    for one in numbers.flips.standings:
        own = [trial for trial in trials if (trial.group, trial.modality) == (one.agent, one.modality)]
        over_all = {"agent": one.agent, "modality": one.modality, "axis": FLIPS.name}
        yield from _standing(one, over_all)
        yield from cost_rows(own, over_all, known)
    for cell in numbers.cells:
        place = {"agent": cell.agent, "modality": cell.modality, "condition": cell.condition}
        yield from cost_rows(cell.trials, {**place, "doses": cell.doses}, known)
        if price := price_asked(cell.trials, known):
            prices[cell.agent] = price
    for agent, asked in prices.items():
        yield from price_facts(agent, asked)


def _standing(one: Standing, of: dict[str, Any]) -> Iterator[Estimate]:
    """One agent over all flip rates."""
    yield from share_rows("success", one.success, **of)
    if one.ranks:
        best, worst = one.ranks
        yield Estimate(quantity="rank", **of, unit="rank", low=best, high=worst, note="possible given the comparisons")
    if one.steps_to_80 is not None:
        yield Estimate(quantity="steps_to_80", **of, unit="steps", n=one.success.n, value=one.steps_to_80)
    if lost := one.regret:
        low, high = (None if end is None else 1 - end for end in (lost.high, lost.low))
        yield Estimate(quantity="relative_area", **of, unit="ratio", value=1 - lost.value, low=low, high=high)
    yield from share_rows("loop_rate", one.loops, **of)
    for null, chance in (("uniform", one.chance), ("no-repeat", one.chance_no_repeat)):
        if chance is not None:
            yield Estimate(quantity="loop_rate_chance", **of, of=null, value=chance)
    yield from share_rows("misread", one.misread, **of)
    if one.not_asked:
        yield Estimate(quantity="trials_not_asked", **of, unit="trials", value=one.not_asked)


_HEAD = ["trials", "success", "80 % by step", "relative area", "loops above chance", "misread"]
_MONEY = ["tokens in", "cached", "tokens out", "US$", "US$ per solved trial"]


def _ranked(found: Results) -> list[Course]:
    """Every agent, the highest success first."""
    shares = [(one, one.value("success")) for one in found.courses()]
    return [one for one, _ in sorted(shares, key=lambda pair: 2.0 if pair[1] is None else -pair[1])]


def _table(found: Results) -> TextTable:
    """Every agent over all flip rates."""
    spent = _costly(found)
    return [["rank", "agent", *_HEAD, *_MONEY * spent]] + [
        [_rank(one.get("rank")), one.label, *_measures(one), *(_money(one) if spent else [])] for one in _ranked(found)
    ]


def _table_by_p(found: Results) -> TextTable:
    """The same by flip rate; of an agent that plays the same at all of them only once."""
    spent = _costly(found)
    return [["agent", "flip rate", *_HEAD, *_MONEY * spent]] + [
        [one.label, EVERY if one.blind else f"{cell.p:g}", *_measures(cell), *(_money(cell) if spent else [])]
        for one in _ranked(found)
        for cell in (one.cells[:1] if one.blind else one.cells)
    ]


def _rank(row: Estimate | None) -> str:
    if row is None:
        return NONE
    return f"{row.low:g}" if row.low == row.high else f"{row.low:g} to {row.high:g}"


def _measures(one: Course | Cell) -> list[str]:
    success, step, loops = one.get("success"), one.value("steps_to_80"), one.value("loop_rate")
    chance = one.value("loop_rate_chance", "uniform")
    return [
        str(success.n if success else 0),
        share_of_row(success),
        "not reached" if step is None else f"{step:g}",
        value_cell(one.get("relative_area")),
        bracketed(None if loops is None or chance is None else loops - chance, None, None),
        _misread(one),
    ]


def _misread(one: Course | Cell) -> str:
    rate = one.get("misread")
    return share_of_row(rate) if rate else "not asked" if one.value("trials_not_asked") else NONE


def _money(one: Course | Cell) -> list[str]:
    least = "at least " if one.value("calls", "uncounted") else ""
    costs = (one.value("cost", of) for of in ("", "per solved trial"))
    return [
        value_cell(one.get("tokens", "input"), "{:.0f}"),
        percent(one.value("cached_share")),
        value_cell(one.get("tokens", "output"), "{:.0f}"),
        *(NONE if amount is None else least + dollars(amount) for amount in costs),
    ]


def _costly(found: Results) -> bool:
    """Whether any agent calls a model whose tokens are, or ought to be, counted."""
    return any(map(_counted, found.courses()))


def _counted(one: Course) -> bool:
    return bool(one.get("tokens", "input") or one.value("calls", "uncounted"))


_LEADERBOARD = Table("leaderboard", _table)
_BY_P = Table("leaderboard-by-p", _table_by_p)


def leaderboard_blocks(found: Results, *, ranked: bool) -> Iterator[Block]:
    """The leaderboard on the page: results, costs, and results by flip rate.

    Args:
        found: The results.
        ranked: Whether any agent has a rank.
    """
    rows, costly = _table(found), _costly(found)
    yield Cells([row[:8] for row in rows])
    rank = (
        " Rank: by success among agents that saw the box alike, from the best to the worst rank compatible with the "
        f"paired comparisons{'; baselines are not ranked' * any(not one.subject for one in found.design.players)}."
    )
    yield Note(
        f"Results {over_rates(found)}. 80 % by step: the first step by which 80 % of all trials are solved; misread: "
        "claims that contradict the report; relative area: the area under the success curve by step, 0 for a random "
        "agent, 1 for the shortest plan.",
        f"Brackets: 95 % intervals clustered by block{', for one look' * bool(found.progress.every_look)}."
        f"{rank if ranked else ''}",
        "Relative area: the area between the success curves of the agent and of a uniformly random agent, divided by "
        "the area between those of the shortest plan and of the random agent. Loops above chance: loop rate minus the "
        "loop rate of uniformly random actions in trials of the same lengths, in points.",
    )
    if costly:
        yield Cells([[row[1], *row[8:]] for row in rows], 1)
        yield Note(
            Markup(
                "Tokens as counted by the provider, for the trials of this table, broken ones too; cached: share of "
                "input tokens read from the provider's cache. <code>lockprobe status</code> gives the cost of all "
                "calls: with those of other conditions, of unfinished trials, and failed ones."
            ),
            "Costs are empty if no price is known, and exclude replies without a token count.",
            Markup(" ").join(said for one in _ranked(found) for said in _prices(found, one)),
        )
    if not found.several_p:
        return
    elsewhere = Markup("; tokens and costs are in <code>tables/leaderboard-by-p.csv</code>") if costly else ""
    by_p = Note(
        Markup("The columns of the table above at each flip rate{}.").format(elsewhere),
        f"{_intervals_of_success(found)} Those of claims are clustered by trial.",
    )
    yield Detail("Results by flip rate", [Cells([row[:8] for row in _table_by_p(found)]), by_p])


def _intervals_of_success(found: Results) -> str:
    agents = (course.agent for course in found.courses())
    return share_intervals_said(agents, "Intervals of success", every_look=bool(found.progress.every_look))


def _prices(found: Results, one: Course) -> Iterator[Markup]:
    """What a provider asks of an agent's calls, and how many of them are not counted."""
    label = printable(one.label)
    if price := price_of(found, one.agent):
        yield Markup(
            "<code>{}</code>: US$ {:g} per million input tokens, {:g} cached, {:g} output, as of {} ({})."
        ).format(label, price.input, price.cached, price.output, price.date, printable(_shortened(price.source)))
    elif _counted(one):
        yield Markup("<code>{}</code>: no price is known.").format(label)
    if uncounted := one.value("calls", "uncounted"):
        yield Markup("<code>{}</code>: {:g} of {:g} replies have no token count; their cost is not included.").format(
            label, uncounted, one.value("calls")
        )


def _shortened(source: str) -> str:
    source = source.replace("https://", "")
    return source if len(source) <= 125 else source[:117].rsplit(" ", 1)[0] + "..."


SECTIONS = (Section(name="leaderboard", title="Leaderboard", rows=_rows, tables=(_LEADERBOARD, _BY_P)),)

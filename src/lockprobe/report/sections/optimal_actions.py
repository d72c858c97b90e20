"""Optimal actions: every action beside those of two ideal observers and of a random choice."""

from __future__ import annotations

from collections.abc import Iterator

from markupsafe import Markup

from lockprobe.foundation.formatting import percent
from lockprobe.report.format import TextTable
from lockprobe.report.rows import Cell, Estimate, Results, Row
from lockprobe.report.sample_pictures import ABOUT
from lockprobe.report.section import Block, Caption, Detail, Figure, Note, Part, Section, Table, Text
from lockprobe.report.study_numbers import PlayedCell, StudyNumbers
from lockprobe.report.table_rows import distinct, flips_first, share_of_row, under, varied
from lockprobe.statistics.rationality import ACTIONS, JUDGED, OBSERVERS, Rationality

__all__ = ["SECTIONS"]

_CHANGED = "an action was not the choice, or a report was missing"
"""Why the trials of a condition are not judged, if it is not for want of a prior."""

_PRIORS = {
    "single-parent": "every joint is free or needs one other joint open",
    "chains": "the joints form a chain that ends in the target",
}


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    known = dict[str, int]()
    for cell in numbers.cells:
        for found in cell.summary.rationality:
            known[found.prior] = found.interlocks
            yield from _before(cell, found)
        if cell.summary.success.n and not cell.summary.rationality:
            why = "no prior" if all(trial.ordinary for trial in cell.trials) else _CHANGED
            yield cell.estimate("trials_not_judged", cell.summary.success.n, of=why, unit="trials")
    for prior, interlocks in known.items():
        yield Estimate(quantity="interlocks", of=prior, unit="interlocks", value=interlocks)
    yield from numbers.answer("optimal_actions", "optimal_actions", "optimal_actions_chance")


def _before(cell: PlayedCell, found: Rationality) -> Iterator[Estimate]:
    """The actions of one cell before one ideal observer; the naive one believes reports, the aware one doubts them."""
    of, lost = found.noise, found.regret
    yield from cell.share("optimal_actions", found.optimal, of=of)
    yield cell.estimate("steps_lost", lost.value, of=of, low=lost.low, high=lost.high, unit="steps", n=found.steps)
    yield from cell.share("uninformative_actions", found.uninformative, of=of)
    names = {"optimal": "optimal_actions", "regret": "steps_lost", "uninformative": "uninformative_actions"}
    for name, level in found.by_chance.items():
        quantity, unit = names.get(name, "information"), {"regret": "steps", "expected": "bits"}.get(name, "share")
        yield cell.estimate(f"{quantity}_chance", level, of=of, unit=unit)
    for name in ("gained", "expected", "best"):
        yield cell.estimate("information", getattr(found, name), of=f"{of}, {name}", unit="bits", n=found.steps)
    yield cell.estimate("entropy_left", found.entropy_left, of=of, unit="bits", n=found.trials)
    yield cell.estimate("restarts", found.restarts, of=of, unit="restarts", n=found.trials)
    if found.left_out and of == OBSERVERS[0]:
        yield cell.estimate("actions_not_judged", found.left_out, unit="actions", n=found.steps + found.left_out)
    if found.not_judged and of == OBSERVERS[0]:
        yield cell.estimate("trials_not_judged", found.not_judged, of="beyond the first", unit="trials")


def _table(found: Results) -> TextTable:
    """How rational actions were for the observer that believes reports and for the other; in brackets by chance."""
    cells = [cell for cell in flips_first(found) if cell.get("optimal_actions", "naive")]
    head = ["agent", varied(cells)]
    head += [f"{what}, reports {how}" for how in ("believed", "doubted") for what in ("optimal", "steps lost")]
    table = [[*head, "uninformative attempts", "bits, of the maximum", "bits left at the end"]]
    for cell, _ in distinct(cells):
        row = [cell.label, under(cell, cells)]
        for of in OBSERVERS:
            row += [_with_chance(cell, "optimal_actions", of), _steps_lost(cell, of)]
        expected, best = (cell.value("information", f"aware, {name}") for name in ("expected", "best"))
        row += [_with_chance(cell, "uninformative_actions", "aware"), f"{expected:.2f} of {best:.2f}"]
        table.append([*row, f"{cell.value('entropy_left', 'aware'):.1f}"])
    return table


def _with_chance(cell: Cell, quantity: str, of: str) -> str:
    return f"{share_of_row(cell.get(quantity, of))} ({percent(cell.value(f'{quantity}_chance', of), 0)})"


def _steps_lost(cell: Cell, of: str) -> str:
    return f"{cell.value('steps_lost', of):.2f} ({cell.value('steps_lost_chance', of):.2f})"


_TABLE = Table("rationality", _table)
_FIGURE = Figure(
    "rationality",
    "Share of optimal actions and steps lost by flip rate, with chance levels",
    Caption(
        "First: share of actions that are optimal for an ideal observer that believes reports (circles) and for one "
        "that doubts them (squares); second: expected steps lost per action. Dotted and dashed: random choices in the "
        "same situations.",
        "Intervals are 95 % intervals clustered by trial.",
    ),
    "lockprobe.report.figures.rationality:rationality",
    lambda found: any(
        cell.get("optimal_actions", "naive") for one in found.courses() if one.subject for cell in one.cells
    ),
)


def _show(found: Results) -> Iterator[Part]:
    if found.where("optimal_actions"):
        yield Part("Optimal actions", found.answer_of("optimal_actions"), list(_blocks(found)))
    elif missing := _not_judged(found, "no prior"):
        text = f"Not judged: there is no prior for boxes with this number of joints ({missing} trials)."
        yield Part("Optimal actions", "Not judged.", [Text(text)])


def _not_judged(found: Results, why: str) -> int:
    """How many trials under flip rates were not judged."""
    return sum(int(cell.value("trials_not_judged", why) or 0) for cell in found.cells if cell.p is not None)


def _changed(found: Results) -> str:
    """The conditions whose trials are not judged because not all of them can be."""
    names = dict.fromkeys(row.condition for row in found.where("trials_not_judged", of=_CHANGED))
    return f" Not judged under {', '.join(names)}: {_CHANGED} in some trials." if names else ""


def _broken(found: Results) -> str:
    """How many actions are not judged because an attempt broke the rules of the box."""
    rows = found.where("actions_not_judged")
    if not rows:
        return ""
    many = f"{sum(row.value or 0 for row in rows):g}"
    return (
        f"Not judged: {many} actions, which are the attempts that broke the rules of the box and all later actions of "
        "their trials. No interlock explains what the agent was told of such an attempt."
    )


def _blocks(found: Results) -> Iterator[Block]:
    prior = found.where("interlocks")[0]
    seen = any(fact.about.startswith(ABOUT) for fact in found.facts)
    pictures = (
        "; with pictures, the observers see the truth without error even if a picture was false, so misreadings count "
        "against the agent"
    )
    restarts = [cell.value("restarts", of) for cell in found.cells if cell.p == 0 for of in OBSERVERS]
    contradicted = Markup(
        " <strong>On this box true reports contradict this prior</strong>, so these numbers say little about it."
    )
    yield Note(
        "Every action is compared with two ideal observers that receive the agent's reports: one believes every "
        "report, which is correct at a flip rate of 0; the other infers how often reports are false. An action is "
        f"optimal if no other has fewer expected steps to the solution{pictures if seen else ''}.",
        Markup("Their prior is that {}: {} equally probable interlocks.{}").format(
            _PRIORS[prior.of], f"{prior.value:g}", contradicted if any(restarts) else ""
        ),
        lead=True,
    )
    for said in filter(None, (_changed(found).strip(), _broken(found))):
        yield Text(said)
    yield _FIGURE
    beyond = _not_judged(found, "beyond the first")
    left_out = f" (for computing time, the other {beyond} trials were not judged)" if beyond else ""
    note = Note(
        "Steps lost: mean extra steps expected from an action, compared with the best one; in brackets: a uniformly "
        "random choice in the same situations. The last three columns use the observer that doubts reports: "
        "uninformative attempts can neither reveal anything about the interlock nor open the box, and bits are "
        "expected information.",
        "Expected steps of the observer that believes are exact; those of the observer that doubts assume full "
        "knowledge after the next action (QMDP), so information has no value. At most the first "
        f"{JUDGED} trials and {ACTIONS} actions of a condition are judged{left_out}; intervals are clustered by trial.",
    )
    yield Detail("Table with baselines", [_TABLE, note])


SECTIONS = (
    Section(
        name="optimal_actions", title="Optimal actions", rows=_rows, show=_show, tables=(_TABLE,), figures=(_FIGURE,)
    ),
)

"""Every decision against what the agent was told: actions that an ideal observer would have chosen too, and claims.

Claims on what an action did stand beside what the agent was told (Table 1) and beside the truth.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from operator import attrgetter
from statistics import mean, stdev

from lockprobe.foundation.formatting import percent, range_of
from lockprobe.report.format import count_of, each_or_span
from lockprobe.report.opened import OpenedStudy, PlayedCell
from lockprobe.report.prose import condition_words, told_apart
from lockprobe.report.rows import Cell, Estimate, Results, Row
from lockprobe.report.section import Lines, Note, Part, Section, Table
from lockprobe.statistics.clustered import clustered_proportion
from lockprobe.statistics.design import FLIPS
from lockprobe.statistics.misinterpretation import Claim, claims
from lockprobe.statistics.modalities import spoken
from lockprobe.statistics.outcomes import ended
from lockprobe.statistics.proportions import Proportion
from lockprobe.statistics.rationality import ACTIONS, JUDGED, optimal_actions, prior_for
from lockprobe.statistics.rules import state_after

_PRIORS = {
    "single-parent": "every joint is free or needs one other joint open",
    "chains": "the joints form a chain that ends in the target",
}

_NAIVE = "naive"
"""The observer, which believes every report."""

_CONTRADICTED = "true reports contradict the prior"


def _optimal(numbers: OpenedStudy) -> Iterator[Row]:
    for cell in numbers.cells:
        if found := optimal_actions(cell.trials, numbers.rules.judged if numbers.broken_rules_said else None):
            share, contradicted = found
            truth = numbers.study.labelled(cell.condition).p == 0
            yield from cell.share("optimal_actions", share, of=_NAIVE, note=_CONTRADICTED * (truth and contradicted))


def _show_optimal(found: Results) -> Iterator[Part]:
    cells = [cell for cell in found.cells if cell.get("optimal_actions", _NAIVE)]
    if not cells:
        return
    first: dict[str, Cell] = {}
    for cell in cells:
        if cell.agent in found.subjects:
            first.setdefault(found.player(cell.agent, cell.modality).label, cell)
    over = {label: cell.value("optimal_actions", _NAIVE) or 0.0 for label, cell in first.items()}
    under = {condition_words(found)[cell.condition] for cell in first.values()}
    prior = _PRIORS[prior_for(max(len(box.get("joints", ())) for box in found.boxes)) or "chains"]
    which = "this box" if len(found.boxes) == 1 else "some of these boxes"
    doubt = f" On {which} true reports contradict this prior, so these numbers say little about it."
    note = Note(
        "An action is optimal if no other has fewer expected steps to the solution for an ideal observer that receives "
        "the agent's reports and believes them, which is correct at a flip rate of 0. Pictures count as read without "
        "error, so misreadings count against the agent.",
        f"Its prior is that {prior}.{doubt * any(row.note for row in found.where('optimal_actions'))}",
        f"At most the first {JUDGED} trials and {ACTIONS} actions of a condition are judged, and of a trial with an "
        "attempt that broke the rules of the box the actions before it. A condition is not judged where an action was "
        "not the choice, or a report was missing. Intervals are clustered by trial.",
    )
    each = [f"{percent(share)} for {label}" for label, share in over.items()]
    said = each_or_span(each, range_of(min(over.values(), default=0.0), max(over.values(), default=0.0)))
    where = under.pop() if len(under) == 1 else "under the first condition of each"
    answer = f"Share of actions that an ideal observer would have chosen too, {where}: {said}." if said else ""
    yield Part("How many actions are optimal?", answer, [note])


_ERRORS = {"misread": "misread", "false_report": "falsely_told", "false_belief": "false_belief"}
"""Errors of claims -> which claims have them."""


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    for cell in numbers.cells:
        trials = ended(cell.trials)
        outcomes = [[step.told_falsely for step in trial.steps] for trial in trials]
        positions = [
            [step.told_state != state_after(trial, step) for step in trial.steps if step.told_state is not None]
            for trial in trials
        ]
        for of, false in (("steps", outcomes), ("positions", positions)):  # whatever the agent said of them
            yield from cell.share("false_report", _by_trial(false), of=of)
        yield from _of_claims(cell, [found for trial in trials if (found := claims(trial))])


def _by_trial(wrong: Sequence[Sequence[bool]]) -> Proportion:
    """A share of what is in trials, which are its clusters."""
    return clustered_proportion(list(map(sum, wrong)), list(map(len, wrong)))


def _of_claims(cell: PlayedCell, said: Sequence[Sequence[Claim]]) -> Iterator[Estimate]:
    if not said:
        return
    for quantity, error in _ERRORS.items():
        yield from cell.share(quantity, _by_trial([list(map(attrgetter(error), one)) for one in said]))
    misread = [[claim for claim in one if claim.misread] for one in said]
    invented = [[claim.claimed == "moved" for claim in one] for one in misread]
    yield from cell.share("misread", _by_trial(invented), of="said moved")
    made, wrong, trials = list(map(len, said)), list(map(len, misread)), len(said)
    yield cell.estimate("misinterpretations", sum(wrong), unit="claims", n=sum(made))
    affected, rates = sum(map(bool, wrong)), [of / n for of, n in zip(wrong, made, strict=True)]
    yield cell.estimate("misinterpretations", affected / trials, of="trials with any", n=trials, count=affected)
    yield cell.estimate("misinterpretations", mean(rates), of="rate", n=trials)
    if trials > 1:
        yield cell.estimate("misinterpretations", stdev(rates), of="SD of rates", n=trials)


def _asked(found: Results) -> list[Cell]:
    """The agents that the study is about and that said what their actions did."""
    return [cell for cell in found.cells if cell.agent in found.subjects and cell.get("misread")]


def _table1(found: Results) -> Lines:
    """The paper's Table 1 with an interval, and a column for the trials, which the paper counts in asterisks."""
    cells = _asked(found)
    ways, rates = {one.modality for one in cells}, {one.p for one in cells}
    apart, under = told_apart(cells)
    alone = len(ways) > 1 and len(rates) == 1 and apart == FLIPS.name  # nothing but the modality differs
    apart = "modality" if alone else apart
    yield ["agent", apart, "claims", "misread", "rate per trial", "± SD", "misread in all", "in trials"]
    for cell in cells:
        names = (cell.agent, cell.shown or spoken(cell.modality)) if alone else (cell.label, under(cell))
        misread = cell.found.one("misread", **cell.own)
        shares = [percent(cell.value("misinterpretations", of), 1) for of in ("rate", "SD of rates")]
        affected = count_of(cell.get("misinterpretations", "trials with any"))
        yield [*names, str(misread.n), misread, *shares, str(misread.count), affected]


TABLE1 = Table("table1", _table1)


_NOTE = Note(
    "The paper's Table 1: claims about the last action that contradict what the agent was told, or what the pictures "
    "showed (misread). There is no claim about the last step of a trial.",
    "Misread has a 95 % interval clustered by trial; the rate is the mean over trials, with the standard deviation "
    "(n - 1).",
)


def _show(found: Results) -> Iterator[Part]:
    if not (cells := _asked(found)):
        return
    low, high = (choose(cells, key=lambda cell: cell.value("misread") or 0.0) for choose in (min, max))
    words, shares = condition_words(found), [percent(cell.value("misread")) for cell in (low, high)]
    places = ((cell.label, words[cell.condition], cell.shown) for cell in (low, high))
    first, last = (label if told == shown else f"{label}, {told}" for label, told, shown in places)
    said = f"Claims that contradict the report: {shares[0]} for {first} to {shares[1]} for {last}."
    if shares[0] == shares[1]:
        some = f"{shares[0]} of the claims contradict the report."
        said = some if high.value("misread") else "No claim contradicts the report."
    yield Part("What is misread?", said, [TABLE1, _NOTE])


SECTIONS = (
    Section("optimal_actions", "Optimal actions", _optimal, _show_optimal),
    Section("misreading", "Misreading", _rows, _show, (TABLE1,)),
)

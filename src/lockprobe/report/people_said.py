"""What a report says of people: who came to the end, and what they opened."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

from lockprobe.foundation.formatting import interval, percent, share
from lockprobe.statistics.conditions.modalities import spoken
from lockprobe.statistics.people import People

if TYPE_CHECKING:
    from lockprobe.people.progress import Flow

_SEEN = {
    "view": "reports as",
    "history": "earlier reports visible:",
    "feedback": "told whether the box was opened:",
    "design": "design",
    "words": "texts",
}
"""Facts of a trial of people, in words."""

_ROOM = 150
"""Characters of all names of conditions together that a sentence has room for; the tables have every condition."""


def flow_said(flow: Flow, analysed: int) -> Iterator[str]:
    """Who came to the end and who did not, and how questions on the instructions and checks were answered.

    ``analysed`` is the number of people with a finished box, of whom all other numbers are.
    """
    ends = {
        f"{flow.withdrawn} withdrew (their data are deleted)": flow.withdrawn,
        f"{flow.screened} {_be(flow.screened, 'was', 'were')} screened out by the questions on the instructions": (
            flow.screened
        ),
        f"{flow.left_open} left boxes unfinished or {_be(flow.left_open, 'is', 'are')} still playing": flow.left_open,
        f"{flow.finished} finished all their boxes": 1,
    }
    said = ", ".join(end for end, number in ends.items() if number)
    counted = f"{analysed} {_be(analysed, 'is', 'are')} in the analysis, with at least one finished box"
    yield f"{_people(flow.consented)} agreed to take part: {said}. {counted}. Who did not agree is not recorded."
    if flow.questioned:
        several = f"{flow.second_round} of {flow.questioned}"
        yield f"{several} needed more than one round of the questions on the instructions."
    if flow.left_open and len({(one.left_open, one.given) for one in flow.boxes}) > 1:
        each = (f"{one.left_open} of {one.given} under {one.condition}" for one in flow.boxes)
        yield f"Unfinished boxes, by condition: {', '.join(each)}."
    if flow.checks:
        yield f"Attention checks: {flow.right} of {flow.checks} answered correctly."


def opened_said(found: People) -> str:
    """How many boxes people opened over all conditions, and of their first ones."""
    every, first = found.success, found.first
    each = f"{found.fewest}" if found.fewest == found.most else f"{found.fewest} to {found.most}"
    range_ = f", {interval(every.low, every.high)}" if every.clusters > 1 else ""
    opened = f"{every.count} of {every.n} boxes ({percent(every.value)}{range_})"
    said = f"{_people(found.people)} opened {opened}, {each} each."
    if found.fewest < found.most:
        said += f" With every person counted alike it is {percent(found.alike)}; the interval holds both."
    if not first.n or found.most == 1:
        return said
    return (
        f"{said} Of their first boxes, they opened {first.count} of {first.n} ({percent(first.value)}, "
        f"{interval(first.low, first.high)}): people remember earlier boxes, models do not."
    )


def conditions_said(found: People, where: Mapping[str, str]) -> Iterator[str]:
    """The share of boxes that people opened under each condition, if there are several and a sentence can name them.

    Args:
        found: The results of people.
        where: Condition -> ``under nudge`` or ``at a flip rate of 0.4``.
    """
    if len(found.at) > 1 and _fit(where[at.condition] for at in found.at):
        shares = [(at.condition, at.success) for at in found.at]
        each = (f"{share(one.value, one.low, one.high)} {where[condition]}" for condition, one in shares)
        yield f"Boxes opened, with 95 % intervals: {', '.join(each)}."


def steps_said(found: People) -> Iterator[str]:
    """The human median of steps in each modality."""
    for over in found.over:
        shown = f" shown as {spoken(over.modality)}" if len(found.over) > 1 else ""
        if over.steps.median is None:
            yield f"They opened fewer than half of the boxes{shown}, so there is no human median of steps."
        else:
            low, high = over.steps.low, over.steps.high
            ends = f" (95 % interval {low} to {'beyond the budget' if high is None else high})"
            ends = "" if low is None and high is None else ends
            yield f"Half of the boxes{shown} were open by step {over.steps.median}{ends}, the human median."


def _fit(names: Iterable[str]) -> bool:
    return sum(map(len, names)) <= _ROOM


def limits_said(found: People) -> str:
    """What people saw, and what limits numbers of people."""
    seen = [
        f"{words} {', '.join(f'{value} ({n} trials)' if len(values) > 1 else value for value, n in values.items())}"
        for name, words in _SEEN.items()
        if (values := found.saw.get(name))
    ]
    said = f"Settings for people: {'; '.join(seen)}. " if seen else ""
    several = "" if found.most == 1 else "A person plays several boxes, so all intervals are clustered by person. "
    left = "People who left early have no trials for their unfinished boxes"
    if found.fewest < found.most:
        left += ", so a difference from people counts only if it holds by box and with every person counted alike"
    return f"{said}{several}{left}."


def _be(number: int, one: str, several: str) -> str:
    return one if number == 1 else several


def _people(number: int) -> str:
    return "One person" if number == 1 else f"{number} people"

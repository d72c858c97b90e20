"""People in the report: who played, what they solved, and how agents compare, as rows, words and tables."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from lockprobe.analysis.modalities import spoken
from lockprobe.analysis.people import People
from lockprobe.analysis.relative_steps import RelativeSteps, Steps
from lockprobe.analysis.response_times import ResponseTimes
from lockprobe.analysis.rules import together
from lockprobe.analysis.summary import StudySummary
from lockprobe.formatting import NONE, percent
from lockprobe.people.progress import Flow
from lockprobe.prose.robot import not_judged
from lockprobe.report.format import TextTable, share_cell

__all__ = [
    "PeopleResult",
    "flow_said",
    "people_row",
    "people_said",
    "people_steps_table",
    "people_table",
    "positions_table",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class PeopleResult:
    """People: how many boxes they played, what they opened, how long they took, and sentences about it.

    ``others`` boxes ended under conditions that are no flip rates; ``found`` and ``response_times`` leave them out.
    """

    planned: int
    finished: int
    owed: int
    others: int
    found: People | None
    flow: Flow | None
    response_times: Sequence[ResponseTimes]
    said: Sequence[str]


def people_row(
    summary: StudySummary,
    planned: int,
    finished: int,
    flow: Flow | None = None,
    times: Sequence[ResponseTimes] = (),
    others: int = 0,
) -> PeopleResult | None:
    """What ``results.json`` says of people; None where a study has none.

    Args:
        summary: The study.
        planned: Trials that the settings ask of people.
        finished: Those that were played, each place once.
        flow: Who came to the end, where people took part here.
        times: How long they took for a choice.
        others: Boxes that ended under conditions that are no flip rates.
    """
    found = summary.people
    if not planned and found is None:
        return None
    return PeopleResult(
        planned=planned,
        finished=finished,
        owed=planned - finished,
        others=others,
        found=found,
        flow=flow,
        response_times=times,
        said=[*(flow_said(flow) if flow else ()), *_left_out(others), *people_said(summary)],
    )


def flow_said(flow: Flow) -> Iterator[str]:
    """Who came to the end and who did not, and how attention checks were answered."""
    joined = f"{_people(flow.joined)} joined" if flow.joined else "No participants remain"
    gone = f"; {flow.withdrawn} {'more ' if flow.joined else ''}withdrew, and their data are deleted"
    ends = f": {flow.finished} finished all their boxes, {flow.left_open} left boxes unfinished or are still playing"
    ends = ends if flow.left_open else " and finished all their boxes" if flow.joined else ""
    yield f"{joined}{ends}{gone if flow.withdrawn else ''}."
    if flow.left_open and len({(one.left_open, one.given) for one in flow.boxes}) > 1:
        each = (f"{one.left_open} of {one.given} under {one.condition}" for one in flow.boxes)
        yield f"Unfinished boxes, by condition: {', '.join(each)}."
    if flow.checks:
        yield f"Attention checks: {flow.right} of {flow.checks} answered correctly."


def people_said(summary: StudySummary) -> list[str]:
    """Sentences on people and agents; none before a trial of people has ended."""
    found = summary.people
    if found is None:
        return []
    judging_nobody = not_judged(together(one.rules for one in summary.conditions))
    compared = [judging_nobody] if judging_nobody else _compared(summary, found)
    return [_solved(found), *_steps(found), *compared, _limits(found)]


def _left_out(others: int) -> Iterator[str]:
    """That the numbers of this section leave out boxes, where they do."""
    if others:
        left = "1 box" if others == 1 else f"{others} boxes"
        yield (
            f"What follows counts boxes under flip rates alone. People finished {left} under other conditions, which "
            "the sections on conditions, speed, loops and optimal actions count beside those of agents."
        )


def _solved(found: People) -> str:
    share, first = found.success, found.first
    each = f"{found.fewest}" if found.fewest == found.most else f"{found.fewest} to {found.most}"
    interval = f", 95 % interval {percent(share.low)} to {percent(share.high)}" if share.clusters > 1 else ""
    opened = f"{share.count} of {share.n} boxes ({percent(share.value)}{interval})"
    said = f"{_people(found.people)} opened {opened}, {each} each."
    if found.fewest < found.most:
        said += f" With every person counted alike it is {percent(found.alike)}; the interval holds both."
    if not first.n or found.most == 1:
        return said
    return (
        f"{said} Of their first boxes, they opened {first.count} of {first.n} ({percent(first.value)}, 95 % interval "
        f"{percent(first.low)} to {percent(first.high)}): people remember earlier boxes, models do not."
    )


def _steps(found: People) -> Iterator[str]:
    for over in found.over:
        shown = f" shown as {spoken(over.modality)}" if len(found.over) > 1 else ""
        if over.steps.median is None:
            yield f"They opened fewer than half of the boxes{shown}, so there is no human median of steps."
        else:
            yield f"Half of the boxes{shown} were open by step {_median(over.steps)}, the human median."


def _compared(summary: StudySummary, found: People) -> Iterator[str]:
    """Every agent that the study is about, over all p; the baselines if people are the only subject."""
    subjects = [agent for agent in summary.subjects if not agent.invited] or summary.agents
    names = {(agent.agent, agent.modality): agent.name for agent in subjects}
    last: dict[tuple[str, str], RelativeSteps] = {(one.agent, one.modality): one for one in found.relative}
    for name, one in last.items():
        if name not in names:
            continue
        on, less = f"on the {one.trials} trials that both played", "solved fewer than half"
        needs = f"{names[name]} needs"
        if one.ratio is not None:
            yield f"{needs} {_times(one.ratio, one)} the human median of steps {on}."
        elif one.least is not None:
            yield f"{needs} at least {_times(one.least, one)} the human median of steps {on}, since it {less}."
        elif one.most is not None:
            yield f"{needs} at most {_times(one.most, one)} the human median of steps {on}, since people {less}."
        else:
            yield f"Neither {names[name]} nor people solved half of the {one.trials} trials that both played."


def _times(value: float, one: RelativeSteps) -> str:
    return f"{value:.2f} times{_ends(one.low, one.high)}"


def _ends(low: float | None, high: float | None) -> str:
    if low is None and high is None:
        return ""
    if low is None or high is None:
        return f" (95 % interval {f'up to {high:.2f}' if low is None else f'from {low:.2f} up'})"
    return f" (95 % interval {low:.2f} to {high:.2f})"


def _limits(found: People) -> str:
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


_SEEN = {
    "view": "reports as",
    "history": "earlier reports visible:",
    "feedback": "told whether the box was opened:",
    "design": "design",
    "words": "texts",
}


def people_table(found: People, times: Sequence[ResponseTimes] = ()) -> TextTable:
    """People by condition, and over all p last; with how long they took for a choice, where that is known."""
    several = len(found.over) > 1
    took = {(row.modality, row.p): row for row in times}
    head = ["flip rate", "people", "trials", "solved", "success", "median steps", "mean steps"]
    head += ["ms per choice", "ms of first choices"] if took else []
    rows = [*found.at, *(found.over if len(found.at) > len(found.over) else [])]
    return [(["modality"] if several else []) + head] + [
        ([row.modality] if several else [])
        + [
            "all" if row.p is None else f"{row.p:g}",
            str(row.people),
            str(row.success.n),
            str(row.success.count),
            share_cell(row.success),
            _steps_cell(row.steps),
            f"{row.steps.mean:.1f}",
        ]
        + (_took(took.get((row.modality, row.p))) if took else [])
        for row in rows
    ]


def _took(row: ResponseTimes | None) -> list[str]:
    if row is None:
        return [NONE, NONE]
    first = NONE if row.first is None else f"{row.first:.0f}"
    return [f"{row.median:.0f} [{row.low:.0f}, {row.high:.0f}]", first]


def people_steps_table(found: People, names: Mapping[tuple[str, str], str]) -> TextTable:
    """Agents' steps and those of people."""
    head = ["agent", "flip rate", "common trials", "median steps", "median of people", "ratio", "ratio of mean steps"]
    return [head] + [
        [
            names.get((row.agent, row.modality), row.agent),
            "all" if row.p is None else f"{row.p:g}",
            str(row.trials),
            _beyond(row.steps),
            _beyond(row.people),
            _ratio(row),
            _bracket(row.mean_ratio, row.mean_low, row.mean_high),
        ]
        for row in found.relative
    ]


def positions_table(found: People) -> TextTable:
    """Success of first boxes, of second ones, and so on."""
    return [["position", "trials", "solved", "success"]] + [
        [str(row.position), str(row.success.n), str(row.success.count), share_cell(row.success)]
        for row in found.positions
    ]


def _ratio(row: RelativeSteps) -> str:
    for value, least in ((row.ratio, ""), (row.least, "at least "), (row.most, "at most ")):
        if value is not None:
            return least + _bracket(value, row.low, row.high)
    return NONE


def _bracket(value: float, low: float | None, high: float | None) -> str:
    if low is None and high is None:
        return f"{value:.2f}"
    return f"{value:.2f} [{'open' if low is None else f'{low:.2f}'}, {'open' if high is None else f'{high:.2f}'}]"


def _median(steps: Steps) -> str:
    if steps.low is None and steps.high is None:
        return f"{steps.median}"
    high = "beyond the budget" if steps.high is None else steps.high
    return f"{steps.median} (95 % interval {steps.low} to {high})"


def _steps_cell(steps: Steps) -> str:
    if steps.low is None and steps.high is None:
        return _beyond(steps.median)
    return f"{_beyond(steps.median)} [{_beyond(steps.low)}, {_beyond(steps.high)}]"


def _beyond(steps: int | None) -> str:
    return "beyond the budget" if steps is None else f"{steps}"


def _people(number: int) -> str:
    return "One person" if number == 1 else f"{number} people"

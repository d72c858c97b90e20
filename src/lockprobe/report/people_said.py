"""What a report says of people: who came to the end, what they opened, and how agents compare with them."""

from __future__ import annotations

from collections.abc import Iterator

from lockprobe.analysis.modalities import spoken
from lockprobe.analysis.people import People
from lockprobe.analysis.relative_steps import RelativeSteps
from lockprobe.analysis.summary import StudySummary
from lockprobe.formatting import interval, percent
from lockprobe.people.progress import Flow

__all__ = ["compared_said", "flow_said", "left_out_said", "limits_said", "opened_said", "steps_said"]

_SEEN = {
    "view": "reports as",
    "history": "earlier reports visible:",
    "feedback": "told whether the box was opened:",
    "design": "design",
    "words": "texts",
}
"""Facts of a trial of people, in words."""


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


def left_out_said(others: int) -> Iterator[str]:
    """That the numbers of this section leave out boxes, where they do."""
    if others:
        left = "1 box" if others == 1 else f"{others} boxes"
        yield (
            f"What follows counts boxes under flip rates alone. People finished {left} under other conditions, which "
            "the sections on conditions, speed, loops and optimal actions count beside those of agents."
        )


def opened_said(found: People) -> str:
    """How many boxes people opened, and of their first ones."""
    share, first = found.success, found.first
    each = f"{found.fewest}" if found.fewest == found.most else f"{found.fewest} to {found.most}"
    range_ = f", {interval(share.low, share.high)}" if share.clusters > 1 else ""
    opened = f"{share.count} of {share.n} boxes ({percent(share.value)}{range_})"
    said = f"{_people(found.people)} opened {opened}, {each} each."
    if found.fewest < found.most:
        said += f" With every person counted alike it is {percent(found.alike)}; the interval holds both."
    if not first.n or found.most == 1:
        return said
    return (
        f"{said} Of their first boxes, they opened {first.count} of {first.n} ({percent(first.value)}, "
        f"{interval(first.low, first.high)}): people remember earlier boxes, models do not."
    )


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


def compared_said(summary: StudySummary, found: People) -> Iterator[str]:
    """Every agent that the study is about, over all p; the baselines if people are the only subject."""
    subjects = [agent for agent in summary.subjects if not agent.invited] or summary.agents
    names = {(agent.agent, agent.modality): agent.name for agent in subjects}
    last = {(one.agent, one.modality): one for one in found.relative}
    for place, one in last.items():
        if place not in names:
            continue
        name, on = names[place], f"the human median of steps on the {one.trials} trials that both played"
        if one.ratio is not None:
            yield f"{name} needs {_times(one.ratio, one)} {on}."
        elif one.least is not None:
            yield f"{name} needs at least {_times(one.least, one)} {on}, since it solved fewer than half."
        elif one.most is not None:
            yield f"{name} needs at most {_times(one.most, one)} {on}, since people solved fewer than half."
        else:
            yield f"Neither {name} nor people solved half of the {one.trials} trials that both played."


def _times(value: float, one: RelativeSteps) -> str:
    low, high = one.low, one.high
    ends = "" if low is None and high is None else f"from {low:.2f} up" if high is None else f"up to {high:.2f}"
    if low is not None and high is not None:
        ends = f"{low:.2f} to {high:.2f}"
    return f"{value:.2f} times{f' (95 % interval {ends})' if ends else ''}"


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


def _people(number: int) -> str:
    return "One person" if number == 1 else f"{number} people"

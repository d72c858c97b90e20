"""The scene of a box, made of the situation that every agent gets and of the layout of the panel.

Nothing here knows the truth: positions and outcomes are the reported ones, joints have their labels.
"""

from __future__ import annotations

import base64
from typing import Literal

from lockprobe.interventions.words import TextChannel
from lockprobe.people.experiment import Experiment
from lockprobe.people.scenes import Box, BoxJoint, BoxPanel
from lockprobe.people.texts import PageWords, filled
from lockprobe.studies.modality import is_pictured, shown
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.plan import Names, Plan
from lockprobe.trial.record import Percept, Situation, Task


def view_of_modality(modality: str) -> Literal["panel", "pictures"]:
    """The view of a modality: pictures where it has them, else the drawn panel."""
    return "pictures" if is_pictured(modality) else "panel"


def box_to_show(
    plan: Plan, situation: Situation, words: PageWords, *, experiment: Experiment, number: int, of: int
) -> Box:
    """The scene of a step: box ``number`` of ``of``, from 1 and without the practice, which is 0."""
    step, budget, asked = len(situation.past) + 1, situation.task.budget, situation.briefing
    panel = panel_to_show(plan, situation, words)
    # a panel is drawn: who cannot see it hears all that was told
    drawn = panel.view == "panel" and (situation.percept.joint is not None or situation.past)
    told = (drawn and _told(plan, situation, words)) or panel.report
    spoken = (
        *told,
        asked.remark,
        asked.warning if step == 1 else "",
        filled(words.step, step=step, budget=budget) + ".",
    )
    return Box(
        practice=number == 0,
        number=number,
        of=of,
        step=step,
        budget=budget,
        ask=is_asked(situation),
        panel=panel,
        remark=asked.remark,
        warning=asked.warning,
        spoken=" ".join(filter(None, spoken)),
        history=_history(plan, situation, words) if experiment.history else (),
        history_open=experiment.history_open,
        device=experiment.device,
    )


def is_asked(situation: Situation) -> bool:
    """Whether the participant has to say what the last action did; models cannot either where no action is named."""
    return situation.task.assessment and situation.percept.joint is not None


def panel_to_show(plan: Plan, situation: Situation, words: PageWords) -> BoxPanel:
    """What the agent's channel shows now."""
    task, percept = situation.task, situation.percept
    seen = view_of_modality(plan.modality)
    kinds = [plan.box.joints[i].kind for i in Names(plan).order]
    handles = _handles(percept) if seen == "pictures" else {}
    joints = tuple(
        BoxJoint(
            label=label,
            target=label == task.target,
            kind=kinds[i] if seen == "panel" else None,
            place=task.places[i] if seen == "panel" else None,
            position=None if percept.positions is None else (1 if percept.positions[i] else 0),
            handle=handles.get(i),
        )
        for i, label in enumerate(task.joints)
    )
    return BoxPanel(
        view=seen,
        joints=joints,
        report=_report(plan, situation, words),
        last=percept.joint,
        outcome=percept.outcome,
        pictures=tuple(_url(picture) for picture in percept.pictures if picture.shown),
    )


def read_of_step(plan: Plan, situation: Situation, words: PageWords) -> str:
    """What a participant reads of the last step: the report and a remark with it."""
    return " ".join(filter(None, (*_report(plan, situation, words), situation.briefing.remark)))


def _report(plan: Plan, situation: Situation, words: PageWords) -> tuple[str, ...]:
    """What came of the last attempt, in words; what the panel shows is not said again."""
    percept, told = situation.percept, _told(plan, situation, words)
    verbatim = _is_verbatim(plan, situation.task, percept, first=not situation.past)
    if percept.joint is None and not situation.past:
        return (words.first, *told) if verbatim else (words.first,)
    if percept.pictures:
        return (filled(words.seen, label=percept.joint),)
    if verbatim or not told:
        return told or (words.no_report,)
    return told[:2] if percept.joint is not None and percept.positions is not None else told[:1]


def _told(plan: Plan, situation: Situation, words: PageWords) -> tuple[str, ...]:
    """All that is told now, in sentences; nothing where nothing was reported, and with pictures."""
    if view_of_modality(plan.modality) == "pictures":
        return ()
    return _sentences(plan, situation.task, situation.percept, words, first=not situation.past)


def _sentences(plan: Plan, task: Task, percept: Percept, words: PageWords, *, first: bool = False) -> tuple[str, ...]:
    """A report in the sentences of the page, or as it is where an intervention acts on its words.

    So it is also where a report corrects another one.
    """
    if _is_verbatim(plan, task, percept, first=first):
        return (percept.text,)
    joint, found = percept.joint, list[str]()
    ones = None
    if percept.positions is not None:
        ones = [label for label, position in zip(task.joints, percept.positions, strict=True) if position]
    if percept.outcome is not None:
        found.append(filled(words.moved if percept.outcome == "moved" else words.blocked, label=joint))
    elif ones is not None and joint is not None:
        found.append(filled(words.attempted, label=joint))
    if ones is not None:
        if joint is not None:
            found.append(filled(words.now, label=joint, position=int(joint in ones)))
        found.append(filled(words.positions, labels=", ".join(ones) or words.none))
    return tuple(found)


def _history(plan: Plan, situation: Situation, words: PageWords) -> tuple[str, ...]:
    """What was told after each step so far, oldest first."""
    after = [
        *((turn.percept, turn.remark) for turn in situation.past[1:]),
        (situation.percept, situation.briefing.remark),
    ]
    lines = []
    for turn, (percept, remark) in zip(situation.past, after, strict=False):
        said = () if percept.pictures else _sentences(plan, situation.task, percept, words)
        said = said or (filled(words.joint, label=turn.decision.joint),)
        lines.append(" ".join(filter(None, (*said, remark))))
    return tuple(lines)


def _is_verbatim(plan: Plan, task: Task, percept: Percept, *, first: bool = False) -> bool:
    """Whether the words of a report say something else than its facts do in the sentences of its modality."""
    channel = shown(plan.modality)
    return isinstance(channel, TextChannel) and percept.text != channel.written(percept, task, first=first)


def _url(picture: Picture) -> str:
    return "data:image/png;base64," + base64.b64encode(picture.png).decode("ascii")


def _handles(percept: Percept) -> dict[int, tuple[tuple[float, float], tuple[float, float]]]:
    """Where handles lie, as shares of the pictures; a place in pixels counts from the middle of the first pixel."""
    if not percept.pictures:
        return {}
    header = percept.pictures[0].png[16:24]  # of the first chunk of a PNG file
    width, height = int.from_bytes(header[:4], "big"), int.from_bytes(header[4:], "big")

    def share(place: tuple[float, float]) -> tuple[float, float]:
        return round((place[0] + 0.5) / width, 5), round((place[1] + 0.5) / height, 5)

    return {i: (share(zero), share(one)) for i, (zero, one) in enumerate(percept.handles)}

"""What a hosted model reads in each modality of a study, side by side, so that every difference is seen.

Nothing is played: the box is opened by its rules, and pictures are only counted.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from difflib import SequenceMatcher
from functools import reduce
from itertools import groupby, pairwise
from textwrap import fill
from typing import NamedTuple

from lockprobe.agents.prompt import Message, conversation, reply_schema
from lockprobe.interventions.camera import CameraChannel
from lockprobe.studies.modality import shown
from lockprobe.studies.study import Study
from lockprobe.trial.briefing import Briefing
from lockprobe.trial.pictures.picture import Picture, PictureKind
from lockprobe.trial.plan import Names, Plan
from lockprobe.trial.record import Decision, Moment, Percept, Situation, Snapshot, Turn

_PARTS = ("first message", "report after the first step", "form of the reply")

_AGENT = "llm:openai/gpt-4o"
"""Any hosted model: all read the same words."""


class Passage(NamedTuple):
    """Words of a prompt, and the modalities in which they stand there."""

    modalities: tuple[str, ...]
    text: str


def prompt_parts(study: Study) -> dict[str, dict[str, list[str]]]:
    """The prompt of a study without interventions: part -> modality -> its sentences, in order.

    The parts are the first message of the first trial, the report after its first step, in which the joint that is
    listed first is attempted, and the form of the reply. A picture stands as ``[picture: rgb]``.
    """
    found = {modality: _messages(study, modality) for modality in study.modalities}
    return {part: {modality: parts[part] for modality, parts in found.items()} for part in _PARTS}


def side_by_side(prompts: Mapping[str, Sequence[str]]) -> list[Passage]:
    """Prompts in passages: what stands in all of them once, and between two such passages what each has there.

    >>> side_by_side({"rgb": ["Look.", "Go."], "symbolic": ["Read.", "Go."]})
    [Passage(modalities=('rgb',), text='Look.'), Passage(modalities=('symbolic',), text='Read.'), \
Passage(modalities=('rgb', 'symbolic'), text='Go.')]
    """
    common = reduce(_alike, prompts.values())
    cut = {modality: _between(said, common) for modality, said in prompts.items()}
    found = list[Passage]()
    for number in range(len(common) + 1):
        found += [Passage((modality,), " ".join(parts[number])) for modality, parts in cut.items() if parts[number]]
        if number < len(common):
            found.append(Passage(tuple(prompts), common[number]))
    return [Passage(both, " ".join(one.text for one in of)) for both, of in groupby(found, lambda one: one.modalities)]


def in_words(study: Study, width: int = 118) -> str:
    """The prompts of a study in lines of so many characters: what all modalities read stands once."""
    lines = []
    for part, prompts in prompt_parts(study).items():
        lines.append(f"{part}:")
        for passage in side_by_side(prompts):
            who = "all" if len(passage.modalities) == len(prompts) else ", ".join(passage.modalities)
            lines.append(fill(f"{who}: {passage.text}", width, initial_indent="  ", subsequent_indent="    "))
    return "".join(f"{line}\n" for line in lines)


def _alike(one: Sequence[str], other: Sequence[str]) -> list[str]:
    """The sentences that two prompts have in the same order."""
    blocks = SequenceMatcher(None, one, other, autojunk=False).get_matching_blocks()
    return [said for block in blocks for said in one[block.a : block.a + block.size]]


def _between(said: Sequence[str], common: Sequence[str]) -> list[Sequence[str]]:
    """What stands before, between and after the common sentences."""
    at, ends = 0, [-1]
    for sentence in common:
        at = said.index(sentence, at)
        ends.append(at)
        at += 1
    return [said[before + 1 : after] for before, after in pairwise([*ends, len(said)])]


def _messages(study: Study, modality: str) -> dict[str, list[str]]:
    """The parts of the prompt in one modality, in sentences."""
    control = next(one for one in study.conditions if one.modality == modality)
    situation = _second_step(study.plan(_AGENT, replace(control, interventions=()), 1, 1))
    opening, _, report = conversation(situation)
    return dict(zip(_PARTS, (_split(opening), _split(report), [json.dumps(reply_schema(situation))]), strict=True))


def _split(message: Message) -> list[str]:
    pictures = [f"[picture: {picture.kind}]" for picture in message.pictures]
    return [*filter(None, re.split(r"(?<=[.:]) |\n+", message.text)), *pictures]


def _second_step(plan: Plan) -> Situation:
    """The second step of a trial under true reports, after the joint that is listed first was attempted."""
    names, opened = Names(plan), Snapshot(configuration=plan.box.initial)
    joint = names.order[0]
    after, moved = plan.box.attempt(plan.box.initial, joint)
    first = _told(plan, names, opened, ())
    attempted = Snapshot(configuration=after, joint=joint, outcome="moved" if moved else "blocked")
    then = _told(plan, names, attempted, (Moment(was=first, told=first),))
    turn = Turn(percept=first, decision=Decision(joint=names.listing[0], replies=("reply",)))
    briefing = Briefing(hypothesis=plan.hypothesis)
    return Situation(task=names.task(plan), past=(turn,), percept=then, briefing=briefing)


def _told(plan: Plan, names: Names, snapshot: Snapshot, past: tuple[Moment, ...]) -> Percept:
    """The percept of a snapshot in the modality of a plan, with empty pictures."""
    channel, percept = shown(plan.modality), names.percept(snapshot)
    if not isinstance(channel, CameraChannel):
        return channel.perceive(percept, past, names.task(plan), plan.luck.at("prompt"))
    kinds: tuple[PictureKind, ...] = ("rgb",) if channel.depth == "none" else ("rgb", "depth")
    pictures = tuple(Picture(kind=kind, png=b"") for kind in kinds)
    return Percept(joint=percept.joint, text=channel.caption(percept.joint), pictures=pictures)

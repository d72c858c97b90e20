"""The conditions that can be played by agents outside of the loop: people at the page, clients with tools.

Both keep their own memory, and see what they are told, asked and shown. What is done to a choice acts on anybody.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.catalogue import shipped
from lockprobe.interventions.conditions import interventions_in
from lockprobe.studies.modality import is_pictured
from lockprobe.trial.condition import Condition, place_of, spec_of
from lockprobe.trial.protocols import Intervention, InterventionTraits


@dataclass(frozen=True, slots=True, kw_only=True)
class Outside:
    """A kind of agent outside of the loop.

    Attributes:
        name: What messages call it.
        said: The interventions on what is asked that reach it, of those that ship.
        strangers: Whether those of other packages reach it; what they ask beyond words then breaks the trial.
        why: Why others do not reach it.
    """

    name: str
    said: tuple[str, ...]
    strangers: bool
    why: str


PERSON = Outside(
    name="a person",
    said=("nudge", "remark", "distract", "warn"),
    strangers=True,
    why="a person remembers what they saw, and the page asks for a joint and what the last action did",
)
"""Somebody at the page, which shows remarks and warnings."""

CLIENT = Outside(
    name="a client",
    said=(*PERSON.said, "prompt"),
    strangers=False,
    why="a client keeps its conversation itself",
)
"""A program with tools, which gets the instruction too; the tools have no argument for further answers."""


def check_playable(conditions: Iterable[Condition], by: Outside) -> None:
    """Refuse conditions that cannot act on an agent outside of the loop.

    Raises:
        BadValue: If a condition changes what is remembered, asks for what cannot be answered, acts on words where a
            person sees pictures alone.
        UserMistake: If an intervention is not here.
    """
    for condition in conditions:
        for one in interventions_in(condition):
            if expected := _instead(one, condition, by):
                raise BadValue("condition", spec_of(one), expected)


def _instead(one: Intervention, condition: Condition, by: Outside) -> str:
    """What can be played instead of an intervention; empty if it can itself."""
    place = place_of(type(one))
    if place == "remembered" or (place == "asked" and not _reaches(one, by)):
        return f"what is told or done, or {', '.join(by.said)}: {by.why}"
    if by is PERSON and is_pictured(condition.modality) and InterventionTraits.of(one).after_words:
        return f"a report in words with it: to {by.name}, {condition.modality} shows pictures alone"
    return ""


def _reaches(one: Intervention, by: Outside) -> bool:
    if type(one) in shipped().values():
        return InterventionTraits.of(one).name in by.said
    return by.strangers

"""The conditions that can be played by agents outside of the loop: people at the page, clients with tools.

Both keep their own memory, and see what they are told, asked and shown. What is done to a choice acts on anybody.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.conditions import interventions_in, shipped
from lockprobe.trial.condition import Condition, place_of, spec_of
from lockprobe.trial.protocols import InterventionTraits


class Outside(NamedTuple):
    """The shipped interventions on words that reach a kind of agent outside of the loop, and why no others do.

    Those of other packages reach a person; what they ask beyond words then breaks the trial.
    """

    said: tuple[str, ...]
    why: str


PERSON = Outside(
    ("nudge", "remark", "distract", "warn"),
    "a person remembers what they saw, and the page asks for a joint and what the last action did",
)
"""Somebody at the page, which shows remarks and warnings."""

CLIENT = Outside((*PERSON.said, "prompt"), "a client keeps its conversation itself")
"""A program with tools, which gets the instruction too; its tools do not change from condition to condition."""


def check_playable(conditions: Iterable[Condition], by: Outside) -> None:
    """Refuse conditions that cannot act on an agent outside of the loop.

    Raises:
        BadValue: If a condition changes what is remembered, or asks for what cannot be answered.
        UserMistake: If an intervention is not here.
    """
    known = {*shipped().values()}
    for condition in conditions:
        for one in interventions_in(condition):
            place, name = place_of(type(one)), InterventionTraits.of(one).name
            reaches = name in by.said if type(one) in known else by is PERSON
            if place == "remembered" or (place == "asked" and not reaches):
                raise BadValue("condition", spec_of(one), f"what is told or done, or {', '.join(by.said)}: {by.why}")

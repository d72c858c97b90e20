"""The conditions that a client with tools can play: interventions on reports, actions and remarks."""

from __future__ import annotations

from lockprobe.errors import BadValue
from lockprobe.interventions.catalogue import place_of, spec_of
from lockprobe.studies.modality import interventions_for
from lockprobe.studies.study import Study
from lockprobe.studies.yoking import is_yoked

__all__ = ["SAID", "check_playable"]

SAID = ("nudge", "remark", "distract", "warn", "prompt")
"""Interventions on what is asked that change only words; others need answers that the tools have no argument for."""


def check_playable(study: Study) -> None:
    """Refuse conditions that cannot act on a client, because it keeps the conversation itself.

    Raises:
        BadValue: If a condition changes what is remembered, asks for more than a joint, a claim and a hypothesis, or
            follows another trial of the agent, because a client plays each trial once.
    """
    for condition in study.conditions:
        if is_yoked(condition):
            own = "a condition without yoked?how=looping: a client plays each trial once"
            raise BadValue("condition", condition.label, own)
        for one in interventions_for(condition):
            place = place_of(type(one))
            if place == "remembered" or (place == "asked" and getattr(one, "name", "") not in SAID):
                expected = f"what is told or done, or {', '.join(SAID)}: a client keeps its conversation itself"
                raise BadValue("condition", spec_of(one), expected)

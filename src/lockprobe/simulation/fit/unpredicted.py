"""Conditions under which models of choices predict nothing, because the record does not hold what the agent knew."""

from __future__ import annotations

from collections.abc import Sequence

from lockprobe.foundation.errors import UserMistake
from lockprobe.foundation.spec import Spec
from lockprobe.interventions.catalogue import interventions_of, shipped
from lockprobe.trial.condition import place_of
from lockprobe.trial.plant_change import PLANT

__all__ = ["why_unpredicted"]


def why_unpredicted(specs: Sequence[str]) -> str:
    """Why the models predict nothing under a condition; empty if they predict every choice.

    A model remembers every report of a trial, so an agent that loses some knows less than the model. Interventions at
    the other places are no obstacle: reports, choices and attempts are on record, and models read no words.

    >>> why_unpredicted(["flip?p=0.4", "tremble?p=0.1"])
    ''
    >>> why_unpredicted(["history?last=2"])
    'history takes reports from the agent, and the record does not hold which it still has'

    Args:
        specs: The specs of its interventions.
    """
    for spec in specs:
        name = Spec.parse(spec, "intervention").full_name
        if name == PLANT:
            continue  # models read what was told of attempts, however these ended
        try:
            place = place_of(shipped().get(name) or type(interventions_of(spec)[0]))
        except UserMistake as mistake:  # what a package does that is not here is unknown
            return str(mistake)
        if place == "remembered":
            return f"{name} takes reports from the agent, and the record does not hold which it still has"
    return ""

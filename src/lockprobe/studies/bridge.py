"""The conditions of the study ``bridge``: do misreadings of pictures act as false reports in words do?"""

from __future__ import annotations

from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.conditions import read_condition
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.statistics.bridge.arms import ARMS, PICTURES, WORDS
from lockprobe.studies.modality import is_pictured
from lockprobe.studies.options.paper import Extent
from lockprobe.trial.condition import Condition
from lockprobe.trial.record import STATES

__all__ = ["AGENTS", "EXTENT", "bridge_conditions"]

AGENTS = ("viewer:human-inspired?acuity=7",)
"""The default agent, which needs no model. At seven pixels across, a number chosen by eye, it misreads a fifth of the
outcomes; with as many pixels as the pictures need it misreads hardly any, and there is nothing to account for."""

EXTENT = Extent(p=(0.0,), repetitions=1, trials=60)
"""Ours: 60 blocks, of which each holds a trial of every arm."""


def bridge_conditions(modality: str, like: OutcomeFlip) -> tuple[Condition, ...]:
    """The arms as conditions: true reports in words, pictures, and words that repeat the misreadings of the pictures.

    Args:
        modality: The pictures, as their spec.
        like: What a false report is.

    Raises:
        BadValue: If the modality shows no pictures, or a false report is none of one outcome.
    """
    if not is_pictured(modality):
        raise BadValue("modality", modality, "pictures, rgb or rgbd: the words to compare with are always played")
    if like.others == "noisy":
        raise BadValue("flip", "independent", "another kind: a misreading is of one outcome")
    plain = OutcomeFlip()
    options = {name: getattr(like, name) for name in ("inverts", "others")}
    reading = "".join(f"&{name}={value}" for name, value in options.items() if value != getattr(plain, name))
    return (
        Condition(name=WORDS),
        Condition(name=PICTURES, modality=modality),
        *(read_condition(f"{spec.format(source=PICTURES)}{reading} + {STATES}", arm) for arm, spec in ARMS.items()),
    )

"""The conditions of the study ``why``: its arms separate the content of false reports from their disturbance."""

from __future__ import annotations

from lockprobe.analysis.why_arms import ARMS
from lockprobe.errors import BadValue
from lockprobe.interventions.condition import Condition, read_condition
from lockprobe.spec import spec_name
from lockprobe.studies.paper import Extent

__all__ = ["AGENTS", "EXTENT", "arm_conditions"]

AGENTS = ("cognitive:insistent", "cognitive:perseverant", "human-inspired")
"""Default agents that need no model: lies raise the success of the first two and lower that of the third."""

EXTENT = Extent(p=(0.4,), repetitions=3, trials=50)
"""150 blocks at the rate at which the paper reports the highest success (Sec. 3.2)."""


def arm_conditions(p: float, modality: str) -> tuple[Condition, ...]:
    """The arms as conditions, true reports first.

    Args:
        p: Flip rate: the share of reports affected in every arm, (0, 1].
        modality: How the box is shown, as its spec.

    Raises:
        BadValue: If the rate is not in (0, 1], or the modality shows pictures, which cannot be corrected.
    """
    if not 0 < p <= 1:
        raise BadValue("p", p, "a rate above 0 and up to 1, at which the reports of all arms are hit")
    if spec_name(modality) != "symbolic":
        raise BadValue("modality", modality, "symbolic, with or without options: pictures cannot be corrected")
    shown = "" if modality == Condition().modality else f" + {modality}"
    return tuple(read_condition(spec.format(p=p) + shown, arm) for arm, spec in ARMS.items())

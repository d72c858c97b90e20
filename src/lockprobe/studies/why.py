"""The conditions of the study ``why``: its arms tell how reports act that say something false."""

from __future__ import annotations

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import spec_name
from lockprobe.interventions.conditions import read_condition
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.statistics.why.arms import ARMS, PARTS
from lockprobe.studies.options.paper import Extent
from lockprobe.trial.condition import Condition

AGENTS = ("cognitive:insistent", "cognitive:perseverant", "human-inspired")
"""Default agents that need no model: lies raise the success of the first two and lower that of the third."""

EXTENT = Extent(p=(0.4,), repetitions=1, trials=50, strategy_trials=150)
"""At the rate at which the paper reports the highest success (Sec. 3.2): 50 blocks of an agent that takes time or
money, which decide for an effect of the paper's size (``lockprobe power why``), and 150 of one that costs nothing."""


def arm_conditions(p: float, modality: str, like: OutcomeFlip, *, parts: bool = False) -> tuple[Condition, ...]:
    """The arms as conditions, true reports first.

    Args:
        p: Flip rate: the share of reports affected in every arm, (0, 1].
        modality: How the box is shown, as its spec.
        like: What a false report is.
        parts: Whether the parts of a false report are arms too; they need reports of outcomes and positions.

    Raises:
        BadValue: If the rate is not in (0, 1], or the modality shows pictures, which cannot be corrected.
    """
    if not 0 < p <= 1:
        raise BadValue("p", p, "a rate above 0 and up to 1, at which the reports of all arms are hit")
    if spec_name(modality) != "symbolic":
        raise BadValue("modality", modality, "symbolic, with or without options: pictures cannot be corrected")
    if like.others == "noisy":
        raise BadValue("flip", "independent", "another kind: noise on all joints is no single statement to correct")
    plain = OutcomeFlip()
    options = {name: getattr(like, name) for name in ("inverts", "others")}
    reading = "".join(f"&{name}={value}" for name, value in options.items() if value != getattr(plain, name))
    shown = "" if modality == Condition().modality else f" + {modality}"
    return tuple(
        read_condition(spec.format(p=p, reading=reading) + shown, arm)
        for arm, spec in {**ARMS, **(PARTS if parts else {})}.items()
    )

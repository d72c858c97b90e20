"""The conditions of the study ``looks``: which features of pictures make agents misread them?

The paper has one box, one camera and one light, and says so among its limitations. Here eight features of the scene
vary at once, in 16 of their 256 combinations (:func:`lockprobe.statistics.factorial.fraction`).
"""

from __future__ import annotations

from collections.abc import Mapping

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import Spec
from lockprobe.interventions.conditions import read_condition
from lockprobe.plants.catalogue import PlantSource
from lockprobe.statistics.factorial import fraction
from lockprobe.studies.modality import is_pictured
from lockprobe.studies.options.paper import Extent
from lockprobe.trial.condition import Condition
from lockprobe.trial.plant_change import PLANT

AGENTS = ("viewer", "viewer:human-inspired?acuity=10")
"""The default agents, which need no model: the first reads pictures as coarsely as they allow, the other one at ten
pixels across."""

EXTENT = Extent(p=(0.0,), repetitions=1, trials=10)
"""Ours: 10 blocks of 16 trials; every level of a factor is then seen in 80 trials."""

PLAIN = "plain scene"
"""The name of the condition in which nothing of the plant is changed; the others are numbered."""

FACTORS: Mapping[str, str] = {
    "discs": "no",
    "handle_colours": "plain",
    "labels": "no",
    "clutter": "8",
    "light": "side",
    "colours": "second",
    "viewpoint": "oblique",
    "view_jitter": "5",
}
"""Option of the plant -> its high level; the low one is that of the study's plant. The first four are of the board, the
others of light and camera."""


def looks_conditions(modality: str, plant: PlantSource) -> tuple[Condition, ...]:
    """The 16 conditions, the plain scene first.

    Args:
        modality: The pictures, as their spec.
        plant: The study's plant.

    Raises:
        BadValue: If the modality shows no pictures, the plant has no camera, or its spec sets a factor.
        UnknownName: If the plant lacks one of the factors.
    """
    if not is_pictured(modality):
        raise BadValue("modality", modality, "pictures, rgb or rgbd, whose looks vary")
    if not plant.has_camera:
        raise BadValue("plant", plant.spec, "one whose camera takes pictures: fast-twin, twin, or manual with --camera")
    own = Spec.parse(plant.spec, "plant").options
    if named := [f"{name}={own[name]}" for name in FACTORS if name in own]:
        raise BadValue("plant", plant.spec, f"one without {', '.join(named)}, which this study varies")
    conditions = []
    for number, levels in enumerate(fraction(len(FACTORS)), 1):
        high = {name: value for (name, value), level in zip(FACTORS.items(), levels, strict=True) if level > 0}
        changed = str(Spec(PLANT, options=high)) + " + " if high else ""
        conditions.append(read_condition(f"{changed}{modality}", f"scene {number}" if high else PLAIN, plant.spec))
    return tuple(conditions)

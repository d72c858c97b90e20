"""The modalities by spec: how the box is shown to an agent (paper, Sec. 2.2).

Specs: ``symbolic`` (a report in words), ``rgb`` (a picture), ``rgbd`` (a picture and a depth picture). Options follow a
question mark: ``symbolic?tell=state``, ``rgbd?blur=8``.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import Any, NoReturn, cast

from lockprobe.agents.catalogue import resolve
from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.foundation.spec import Spec, arguments_from, spec_name, with_options
from lockprobe.interventions.camera import CameraChannel
from lockprobe.interventions.conditions import MODALITIES, interventions_in
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.words import TextChannel
from lockprobe.plants.catalogue import PlantSource
from lockprobe.trial.condition import Condition
from lockprobe.trial.places import Places
from lockprobe.trial.protocols import Intervention
from lockprobe.trial.source import source_of

_DEPTH = {"rgb": False, "rgbd": True}
"""The modalities in pictures -> whether they show depth."""


def is_pictured(modality: str) -> bool:
    """Whether a modality shows pictures instead of words."""
    return spec_name(modality) in _DEPTH


def shows_places(modality: str) -> bool:
    """Whether an agent learns where joints lie on the panel: from pictures, or from reports that say it."""
    return isinstance(channel := shown(modality), CameraChannel) or channel.places


@lru_cache(maxsize=64)
def shown(modality: str) -> TextChannel | CameraChannel:
    """The channel of a modality: words or a camera.

    >>> shown("symbolic?tell=state").tell
    'state'

    Raises:
        UnknownName: If there is no such modality, or it has no such option; the message lists what exists.
        BadValue: If an option has a value that it cannot have.
    """
    spec = Spec.parse(modality, "modality")
    name = spec.full_name
    if name not in MODALITIES:
        raise UnknownName("modality", name, MODALITIES)
    if name == "symbolic":
        source_of(modality)  # an option of words that is the trial's
        return with_options(TextChannel, name, spec.without(["source"]).options)
    options: dict[str, Any] = arguments_from(CameraChannel, name, spec.options, ("depth",))
    return CameraChannel(depth=_DEPTH[name], **options)


def check_shown(conditions: Sequence[Condition], plant: PlantSource) -> None:
    """Refuse conditions that a plant cannot show or sense.

    Conditions from a settings file are checked without importing code.

    Raises:
        UnknownName: If there is no such modality, or it has no such option.
        BadValue: If pictures are shown without a camera, reports have a source that the plant lacks, or a
            modality cannot show what is flipped.
    """
    for modality in dict.fromkeys(one.modality for one in conditions):
        shown(modality)
        of = source_of(modality)
        if (is_pictured(modality) or of == "camera") and not plant.has_camera:
            raise BadValue("modality", modality, f"a plant with a camera, fast-twin or twin, not {plant.spec}")
        if of == "verdict" and not plant.has_arm and plant.ships:  # others say it by their first attempt
            raise BadValue("modality", modality, f"a plant with an arm, twin or rig, not {plant.spec}")
    for condition in conditions:
        if not condition.is_recorded:
            interventions_for(condition)


def interventions_for(condition: Condition) -> tuple[Intervention, ...]:
    """All interventions of a trial in order; the modality's channel comes last.

    A picture is false if a flip acts before the camera.

    Raises:
        UserMistake: If an intervention is not here, or what is flipped cannot be shown.
    """
    channel, acting = shown(condition.modality), interventions_in(condition)
    flips = [one for one in acting if isinstance(one, OutcomeFlip)]
    if isinstance(channel, CameraChannel):
        acting = tuple(one for one in acting if not (isinstance(one, OutcomeFlip) and one.p == 0))
    for flip in flips:
        flip.check_told(condition.modality, both=isinstance(channel, TextChannel) and channel.tell == "both")
    return *acting, channel


def places_in(condition: Condition) -> Places:
    """The places of all interventions of a condition, which it keeps: equal ones may hold other interventions."""
    kept = vars(condition)
    if (places := kept.get("places")) is None:
        places = kept["places"] = Places(interventions_for(condition))
    return cast(Places, places)


def taken_in(agent: str, modalities: Iterable[str]) -> tuple[str, ...]:
    """The modalities that an agent can play: an agent that reads reports plays no pictures."""
    modalities = tuple(modalities)
    in_words = tuple(modality for modality in modalities if not is_pictured(modality))
    return modalities if in_words == modalities or resolve(agent).sees else in_words


def refuse_blind(agent: str, modality: str) -> NoReturn:
    """Refuse pictures for an agent that reads reports."""
    expected = f"symbolic for {agent}, which reads reports and looks at no pictures"
    raise BadValue("modality", modality, f"{expected}; viewer, viewer:STRATEGY, and models that take pictures do")

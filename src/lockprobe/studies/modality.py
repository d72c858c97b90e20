"""How a box is shown: from a modality's spec to the channels of a trial (paper, Sec. 2.2).

Specs: ``symbolic`` (a report in words), ``rgb`` (a picture), ``rgbd`` (a picture, and its depth as another). What a
camera can be told stands after a question mark: ``rgbd?depth=height``.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

from lockprobe.agents.catalogue import resolve
from lockprobe.channels.camera import CameraChannel
from lockprobe.channels.noise import OutcomeFlip
from lockprobe.channels.text import TextChannel
from lockprobe.errors import BadValue, Missing, UnknownName
from lockprobe.options import read_options, with_options
from lockprobe.plan import Plan
from lockprobe.seams import Channel

__all__ = ["MODALITIES", "SYMBOLIC", "camera", "channels_for", "is_pictured", "taken_in"]

MODALITIES = ("symbolic", "rgb", "rgbd")

SYMBOLIC = ("symbolic",)
"""The modalities of a study that has no pictures."""

_DEPTH = {"rgb": "none", "rgbd": "turbo"}


def is_pictured(modality: str) -> bool:
    """Whether a modality shows pictures instead of telling."""
    return modality.partition("?")[0] in _DEPTH


@lru_cache(maxsize=64)
def camera(modality: str) -> CameraChannel | None:
    """The camera of a modality; None for reports in words.

    Raises:
        UnknownName: If there is no such modality, or its camera has no such option; the message lists what exists.
        BadValue: If an option has a value that it cannot have.
    """
    name, _, query = modality.partition("?")
    if name not in MODALITIES:
        raise UnknownName("modality", name, MODALITIES)
    if name == "symbolic":
        if query:
            raise BadValue("modality", modality, "symbolic without options")
        return None
    found = with_options(CameraChannel, name, read_options(modality, "modality")[1], {"depth": _DEPTH[name]})
    if (found.depth == "none") != (name == "rgb"):
        raise BadValue("modality", modality, "rgb without depth, or rgbd with a kind of depth")
    return found


def channels_for(plan: Plan) -> tuple[Channel, ...]:
    """What stands between the box and the agent in one trial."""
    eye = camera(plan.modality)
    return (OutcomeFlip(p=plan.p, persistence=plan.flip), TextChannel()) if eye is None else (eye,)


def taken_in(agent: str, modalities: Iterable[str]) -> tuple[str, ...]:
    """Those of some modalities that an agent plays: one that reads reports has nothing to gain from pictures.

    Raises:
        UnknownName: If there is no such agent.
    """
    modalities = tuple(modalities)
    if not any(map(is_pictured, modalities)) or _looks(agent):
        return modalities
    return tuple(modality for modality in modalities if not is_pictured(modality))


@lru_cache(maxsize=256)
def _looks(agent: str) -> bool:
    try:
        return resolve(agent).senses == "pictures"
    except Missing:  # the package of hosted models, which look; records can be read without it
        return True

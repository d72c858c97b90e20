"""How a box is shown: from a modality's spec to the channels of a trial (paper, Sec. 2.2).

Specs: ``symbolic`` (a report in words), ``rgb`` (a picture), ``rgbd`` (a picture, and its depth as another). What a
camera can be told stands after a question mark: ``rgbd?depth=height``.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

from lockprobe.agents.catalogue import resolve
from lockprobe.errors import BadValue, Missing, UnknownName
from lockprobe.interventions.camera import CameraChannel
from lockprobe.interventions.catalogue import with_words
from lockprobe.interventions.condition import MODALITIES, SYMBOLIC, Condition
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.words import TextChannel
from lockprobe.options import read_options, spec_name, with_options
from lockprobe.seams import Channel, Intervention

__all__ = ["MODALITIES", "SYMBOLIC", "camera", "check_distinct", "interventions_for", "is_pictured", "taken_in"]

_DEPTH = {"rgb": "none", "rgbd": "turbo"}

_WITHOUT_WINDOW = ("height", "packed")
"""Kinds of depth that mean the same whatever ``near`` and ``far`` are."""


def is_pictured(modality: str) -> bool:
    """Whether a modality shows pictures instead of telling."""
    return spec_name(modality) in _DEPTH


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
    if name == "rgb" and query:
        raise BadValue("modality", modality, "rgb without options: they are all of depth, which rgbd shows")
    options = read_options(modality, "modality")[1]
    found = with_options(CameraChannel, name, options, {"depth": _DEPTH[name]})
    if name == "rgbd" and found.depth == "none":
        raise BadValue("modality", modality, "rgbd with a kind of depth")
    if found.depth in _WITHOUT_WINDOW and ("near" in options or "far" in options):
        raise BadValue("modality", modality, f"depth={found.depth} without near and far, which it does not use")
    return found


def check_distinct(modalities: Iterable[str]) -> None:
    """Refuse modalities that show the same under two names, which would be compared as if they were two.

    Raises:
        UnknownName: As of :func:`camera`.
        BadValue: As of :func:`camera`, and if two are the same.
    """
    seen: dict[CameraChannel | None, str] = {}
    for modality in modalities:
        first = seen.setdefault(camera(modality), modality)
        if first != modality:
            raise BadValue("modality", modality, f"another way to show the box than {first}, which is the same")


def interventions_for(condition: Condition) -> tuple[Intervention, ...]:
    """What acts in a trial, in order; last comes how the box is shown, and what acts on the words of a report.

    Raises:
        BadValue: If it changes reports where pictures are shown.
    """
    acting, eye = condition.made(), camera(condition.modality)
    if eye is None:
        return with_words(acting, TextChannel())
    acting = tuple(one for one in acting if not (isinstance(one, OutcomeFlip) and one.p == 0))
    if any(isinstance(one, Channel) for one in acting):
        raise BadValue("condition", condition.label, f"none that changes reports: {condition.modality} has none")
    return (*acting, eye)


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

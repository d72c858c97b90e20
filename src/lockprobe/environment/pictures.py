"""What an agent is shown, as arrays: the same for one that is trained and for one that plays a study."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lockprobe.errors import ChannelFault
from lockprobe.pictures.picture import PictureKind
from lockprobe.pictures.png import from_png
from lockprobe.record import Percept

__all__ = ["FARTHEST", "Images", "colours", "distances", "images", "stacked"]

FARTHEST = 4.0
"""Metres; what is farther away has no reading."""

Images = NDArray[np.uint8] | dict[str, NDArray[np.uint8] | NDArray[np.float32]]
"""Colours, or ``{"rgb": colours, "depth": distances}``."""


def colours(percept: Percept) -> NDArray[np.uint8]:
    """The colour picture, shape (height, width, 3), 0 to 255.

    Raises:
        ChannelFault: If none is shown.
    """
    return from_png(_file(percept, "rgb")).astype(np.uint8, copy=False)


def distances(percept: Percept) -> NDArray[np.float32]:
    """Depth as it was measured, shape (height, width, 1), metres; 0 where there is no reading.

    Raises:
        ChannelFault: If none is kept.
    """
    metres = from_png(_file(percept, "depth16")).astype(np.float32)[..., None] / np.float32(1000)
    return np.where(metres <= FARTHEST, metres, np.float32(0))


def images(percept: Percept, observation: str) -> Images:
    """What is shown under an observation, ``rgb`` or ``rgbd``."""
    seen = colours(percept)
    return seen if observation == "rgb" else {"rgb": seen, "depth": distances(percept)}


def stacked(percepts: Sequence[Percept], observation: str) -> Images:
    """The same of several percepts, on a first axis of their own."""
    seen = np.stack([colours(percept) for percept in percepts])
    if observation == "rgb":
        return seen
    return {"rgb": seen, "depth": np.stack([distances(percept) for percept in percepts])}


def _file(percept: Percept, kind: PictureKind) -> bytes:
    for picture in percept.pictures:
        if picture.kind == kind:
            return picture.png
    raise ChannelFault(f"no picture of the kind {kind} reached the agent: a channel took it away")

"""Observations as arrays: reports as a short vector of whole numbers, pictures as colours and depth.

With ``n`` joints, numbered as they are
listed to the agent, the vector holds:

=========================  ============  ==================================================================
entry                      values        meaning
=========================  ============  ==================================================================
0                          0 to n - 1    the target joint
1                          0 to n        the joint just attempted, plus one; 0 before the first attempt
2                          0, 1, 2       nothing reported, reported as blocked, reported as moved; always 0 if reports
                                         tell only positions (``symbolic?tell=state``)
3 to n + 2                 0, 1 (, 2)    reported position of each joint, 2 if a report is missing; absent if no report
                                         tells positions
last                       0 to budget   steps left; absent unless asked for
=========================  ============  ==================================================================
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import ChannelFault
from lockprobe.trial.pictures.picture import PictureKind
from lockprobe.trial.pictures.png import from_png
from lockprobe.trial.record import Percept, Task

Vector = NDArray[np.int64]

BLOCKED, MOVED = 1, 2
"""Entry 2 of the vector."""

UNTOLD = 2
"""Position of a joint if a report is missing."""

FARTHEST = 4.0
"""Largest depth with a reading, metres."""

Images = NDArray[np.uint8] | dict[str, NDArray[np.uint8] | NDArray[np.float32]]
"""Colours, or ``{"rgb": colours, "depth": distances}``."""


def sizes(
    joints: int, *, positions: bool, budget: int | None, outcomes: bool = True, gaps: bool = False
) -> tuple[int, ...]:
    """The number of values of each entry of the vector.

    Args:
        joints: Number of joints.
        positions: Whether positions are told.
        outcomes: Whether outcomes are told.
        gaps: Whether a report can be missing.
        budget: Steps of a trial; None if the vector does not hold the steps left.
    """
    told = (2 + gaps,) * joints * positions
    return (joints, joints + 1, 3 if outcomes else 1, *told, *(() if budget is None else (budget + 1,)))


def vector(task: Task, percept: Percept, steps_left: int | None = None, *, positions: bool) -> Vector:
    """One percept as a vector, shape (entries,).

    Args:
        task: The agent's task.
        percept: The report.
        steps_left: Steps left; None if the vector does not hold them.
        positions: Whether reports of this trial tell positions, as the first report does.
    """
    joint = 0 if percept.joint is None else task.joints.index(percept.joint) + 1
    outcome = 0 if percept.outcome is None else MOVED if percept.outcome == "moved" else BLOCKED
    told = (percept.positions or (UNTOLD,) * len(task.joints)) if positions else ()
    return laid_out(task.joints.index(task.target), joint, outcome, told, steps_left)


def laid_out(target: int, joint: int, outcome: int, positions: Sequence[int], steps_left: int | None) -> Vector:
    """The vector of these entries; empty positions and None are left out."""
    last = () if steps_left is None else (steps_left,)
    return np.array((target, joint, outcome, *positions, *last), dtype=np.int64)


def colours(percept: Percept) -> NDArray[np.uint8]:
    """The colour picture, shape (height, width, 3), 0 to 255.

    Raises:
        ChannelFault: If the percept has none.
    """
    return from_png(_file(percept, "rgb")).astype(np.uint8, copy=False)


def distances(percept: Percept) -> NDArray[np.float32]:
    """Measured depth, shape (height, width, 1), metres; 0 where there is no reading.

    Raises:
        ChannelFault: If the percept has none.
    """
    metres = from_png(_file(percept, "depth16")).astype(np.float32)[..., None] / np.float32(1000)
    return np.where(metres <= FARTHEST, metres, np.float32(0))


def images(percept: Percept, observation: str) -> Images:
    """The pictures of an observation, ``rgb`` or ``rgbd``."""
    seen = colours(percept)
    return seen if observation == "rgb" else {"rgb": seen, "depth": distances(percept)}


def _file(percept: Percept, kind: PictureKind) -> bytes:
    for picture in percept.pictures:
        if picture.kind == kind:
            return picture.png
    raise ChannelFault(f"no picture of the kind {kind} reached the agent: a channel removed it")

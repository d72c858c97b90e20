"""What an agent is told, as a short vector of whole numbers.

It is the same for an agent that is trained and for one that plays a study; nothing here needs Gymnasium. With ``n``
joints, numbered as they are listed to the agent:

=========================  ============  ==================================================================
entry                      values        meaning
=========================  ============  ==================================================================
0                          0 to n - 1    the target joint
1                          0 to n        the joint just attempted, plus one; 0 before the first attempt
2                          0, 1, 2       nothing reported yet, reported as blocked, reported as moved
3 to n + 2                 0, 1          position of each joint as reported; absent where none are told
last                       0 to budget   steps left; absent unless asked for
=========================  ============  ==================================================================
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lockprobe.record import Percept, Situation, Task

__all__ = ["BLOCKED", "MOVED", "Vector", "sizes", "so_far", "vector"]

Vector = NDArray[np.int64]

BLOCKED, MOVED = 1, 2
"""Entry 2 of the vector."""


def sizes(joints: int, *, positions: bool, budget: int | None) -> tuple[int, ...]:
    """How many values each entry of the vector can take.

    Args:
        joints: Number of joints.
        positions: Whether positions are told.
        budget: Steps of a trial; None if the vector does not hold the steps left.
    """
    return (joints, joints + 1, 3, *(2,) * joints * positions, *(() if budget is None else (budget + 1,)))


def vector(task: Task, percept: Percept, steps_left: int | None = None) -> Vector:
    """One percept as a vector, shape (entries,)."""
    joint = 0 if percept.joint is None else task.joints.index(percept.joint) + 1
    outcome = 0 if percept.outcome is None else MOVED if percept.outcome == "moved" else BLOCKED
    last = () if steps_left is None else (steps_left,)
    return np.array([task.joints.index(task.target), joint, outcome, *(percept.positions or ()), *last], dtype=np.int64)


def so_far(situation: Situation, *, steps_left: bool = False) -> Vector:
    """All that an agent was told in a trial, shape (1 + steps played, entries), the newest last."""
    percepts = [*(turn.percept for turn in situation.past), situation.percept]
    budget = situation.task.budget
    return np.stack(
        [vector(situation.task, percept, budget - i if steps_left else None) for i, percept in enumerate(percepts)]
    )

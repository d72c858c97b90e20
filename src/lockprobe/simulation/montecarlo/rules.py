"""NumPy record types of boxes, agents and memories for compiled code.

Joints are indices in panel order. Configurations and sets of joints are numbers with bit j for joint j; in a
configuration a 1 means away from the start. Compiled code is cached until the file of its functions changes, so a
change of these fields has to change :mod:`lockprobe.simulation.montecarlo.compiled_choices` too.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import MAX_JOINTS
from lockprobe.simulation.montecarlo.plain import LONGEST

Integers = NDArray[np.int64]
Numbers = NDArray[np.float64]
Scene: TypeAlias = Any
Rule: TypeAlias = Any
Memory: TypeAlias = Any

_CONFIGURATIONS = 2**MAX_JOINTS

SCENE = np.dtype(
    [
        ("joints", np.int64),
        ("target", np.int64),
        ("outcome", np.int64),
        ("kept", np.int64),
        ("noisy", np.int64),
        ("outcomes_true", np.int64),
        ("positions_true", np.int64),
        ("positions", np.int64),
        ("budget", np.int64),
        ("states_only", np.int64),
        ("p", np.float64),
        ("movable", np.int64, (_CONFIGURATIONS,)),
        ("far", np.float64, (MAX_JOINTS, MAX_JOINTS)),
    ]
)
"""A box and what is told of it: :class:`lockprobe.simulation.montecarlo.plain.BoxWorld`.

``outcome`` (outcomes are inverted), ``kept`` (all false positions survive), ``noisy`` (positions of all joints are
inverted), ``outcomes_true`` and ``positions_true`` (told outcomes or positions never are), ``positions`` (are told) and
``states_only`` are 0 or 1; ``movable`` the joints that may move in each configuration; ``far`` the squared distance of
every two joints on the panel.
"""

RULE = np.dtype(
    [
        ("kind", np.int64),
        ("when", np.int64),
        ("memory", np.int64),
        ("spare", np.int64),
        ("nearest", np.int64),
        ("avoid", np.int64),
        ("window", np.int64),
        ("lapse", np.float64),
        ("pulls", np.float64, (8,)),
    ]
)
"""An agent: its family and the settings of that family, words by their place among the choices.

``when`` is the human-inspired strategy's ``target``; ``memory``, ``spare`` and ``nearest`` are its own; ``avoid`` and
``window`` are the random map's; ``lapse`` is of either; ``pulls`` are the fields of the softmax in their order.
"""

MEMORY = np.dtype(
    [
        ("steps", np.int64),
        ("used", np.int64),
        ("failed", np.int64),
        ("opened", np.int64),
        ("moved", np.int64),
        ("last", np.int64),
        ("won", np.int64),
        ("recent", np.int64),
        ("met", np.int64),
        ("traces", np.float64, (MAX_JOINTS,)),
        ("chances", np.float64, (MAX_JOINTS,)),
        ("seen", np.int64, (_CONFIGURATIONS,)),
        ("states", np.int64, (LONGEST,)),
        ("firsts", np.int64, (LONGEST,)),
    ]
)
"""What an agent remembers in one trial.

Steps made; numbers used up; joints that failed since the last move; joints believed away from their start; the joint
that moved last and the one attempted last, -1 where there is none; whether that one moved; the window of the map; how
many states the map has met. The failure trace of each joint; room for the chances of each; the joints tried in each
configuration; the states that the map has met, and what it did there first.
"""


def record(kind: np.dtype[np.void], values: Mapping[str, object] | None = None) -> Any:
    """A record of one of these types; fields that are not given are 0."""
    made = np.recarray((1,), kind)
    made[:] = np.zeros(1, kind)
    for name, value in (values or {}).items():
        made[name][0] = value
    return made[0]

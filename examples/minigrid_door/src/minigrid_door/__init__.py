"""MiniGrid's locked door, with what a player is told of it.

A player fetches the key, opens the door and goes to the goal. What ``toggle`` does to the door is named here; a toggle
of an open door closes it.
"""

import minigrid  # noqa: F401  registers the environments
from minigrid.core.actions import Actions
from minigrid.core.constants import OBJECT_TO_IDX, STATE_TO_IDX

NAME = "MiniGrid-DoorKey-5x5-v0"
OPENED, NOT_OPENED = "the door opened", "the door did not open"
AHEAD = (3, 5)
"""The cell before the player in its view of 7 x 7 cells."""


def outcome(before, action, after):
    """What a toggle did to the door ahead, and the opposite; None for all other actions."""
    if action != Actions.toggle or before["image"][AHEAD][0] != OBJECT_TO_IDX["door"]:
        return None
    opened = after["image"][AHEAD][2] == STATE_TO_IDX["open"]
    return (OPENED, NOT_OPENED) if opened else (NOT_OPENED, OPENED)

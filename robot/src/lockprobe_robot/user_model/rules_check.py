"""Checks a user's model against the rules of its box by pushing every joint in all reachable configurations.

The model is only pushed, never set to a configuration. So parts without a name in the box (bolts, gears) have the
positions that an agent's attempts give them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from lockprobe.boxes.box import Configuration, Lockbox, bits
from lockprobe.boxes.observed_moves import Push
from lockprobe.foundation.errors import BadFile, PlantFault
from lockprobe_robot.user_model.model_joints import ModelJoints

__all__ = ["MOST_CONFIGURATIONS", "check_rules", "push_everything"]

MOST_CONFIGURATIONS = 64
"""Configurations in which joints are pushed before a study; if trials can reach more, a sample with a fixed seed."""


def check_rules(
    joints: ModelJoints,
    box: Lockbox,
    path: Path,
    *,
    most: int | None = None,
    push: Callable[[int], object] | None = None,
    hint: str = "",
) -> int:
    """Push every joint in the configurations that are reachable before the target moves, up to a number of them.

    Args:
        joints: The joints of the model.
        box: The rules.
        path: The model's file, for messages.
        most: The most configurations; None for :data:`MOST_CONFIGURATIONS`.
        push: What pushes a joint; None for the generalised force.
        hint: Added to the message.

    Returns:
        The number of configurations.

    Raises:
        BadFile: If a joint moves against the rules, does not move although the rules allow it, stops between its ends
            or moves another joint; the message names the configuration and the joint.
    """
    checked = set()
    for made in push_everything(joints, box, path, most=MOST_CONFIGURATIONS if most is None else most, push=push):
        checked.add(made.configuration)
        if made.disagreement:
            where = f"in configuration {bits(made.configuration)} ({', '.join(box.names)})"
            raise BadFile(path, f"{where}, {box.names[made.joint]} was pushed: {made.disagreement}{hint}")
    return len(checked)


def push_everything(
    joints: ModelJoints,
    box: Lockbox,
    path: Path,
    *,
    most: int | None = None,
    push: Callable[[int], object] | None = None,
) -> Iterator[Push]:
    """Push every joint in every configuration that the model reaches before the target moves.

    Args:
        joints: The joints of the model.
        box: The rules.
        path: The model's file, for messages.
        most: The most configurations; None for all.
        push: As for :func:`check_rules`.

    Raises:
        BadFile: If the model does not rest in the initial configuration.
    """
    try:
        joints.start(box.initial)
    except PlantFault as fault:
        raise BadFile(path, str(fault)) from None
    rng = np.random.default_rng(0)
    frontier = [(box.initial, joints.saved())]
    known = {box.initial}
    while frontier and most != 0:
        configuration, state = frontier.pop(int(rng.integers(len(frontier))))
        most = None if most is None else most - 1
        for joint, name in enumerate(box.names):
            joints.restore(state)
            made = _push(joints, box, configuration, joint, push or joints.push)
            yield made
            after = joints.configuration()
            if made.moved and name != box.target and after not in known:
                known.add(after)
                frontier.append((after, joints.saved()))


def _push(joints: ModelJoints, box: Lockbox, before: Configuration, joint: int, push: Callable[[int], object]) -> Push:
    """Push a joint, and compare the model's motion with the rules."""
    name, allowed = box.names[joint], box.may_move(before, joint)
    moved, why = None, ""
    try:
        push(joint)
    except PlantFault as fault:
        why = str(fault)
    else:
        after = joints.configuration()
        rules = f"the rules {'let it move' if allowed else 'lock it'}"
        others = [other for i, other in enumerate(box.names) if i != joint and after[i] != before[i]]
        if others:
            why = f"{rules}, and the model moved {', '.join(others)} as well ({joints.where()})"
        elif not joints.resting():
            why = f"{rules}, and the model left a joint between its ends ({joints.where()})"
        else:
            moved = after[joint] != before[joint]
            if moved != allowed:
                why = f"{rules}, and the model {'moved' if moved else 'held'} {name} ({joints.where()})"
    return Push(configuration=before, joint=joint, allowed=allowed, moved=moved, disagreement=why)

"""Checks a user's model against the rules of its box by pushing every joint in all reachable configurations.

The model is only pushed, never set to a configuration. So parts without a name in the box (bolts, gears) have the
positions that an agent's attempts give them.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from lockprobe.boxes.box import Configuration, Lockbox, bits
from lockprobe.foundation.errors import BadFile, PlantFault
from lockprobe_robot.user_model.model_joints import ModelJoints

__all__ = ["MOST_CONFIGURATIONS", "check_rules"]

MOST_CONFIGURATIONS = 64
"""Configurations in which joints are pushed; if trials can reach more, a sample with a fixed seed."""


def check_rules(joints: ModelJoints, box: Lockbox, path: Path) -> int:
    """Push every joint in every configuration that is reachable before the target moves.

    Args:
        joints: The joints of the model.
        box: The rules.
        path: The model's file, for messages.

    Returns:
        The number of configurations.

    Raises:
        BadFile: If a joint moves against the rules, does not move although the rules allow it, stops between its ends
            or moves another joint; the message names the configuration and the joint.
    """
    try:
        joints.start(box.initial)
    except PlantFault as fault:
        raise BadFile(path, str(fault)) from None
    rng = np.random.default_rng(0)
    frontier = [(box.initial, joints.saved())]
    known = {box.initial}
    checked = 0
    while frontier and checked < MOST_CONFIGURATIONS:
        configuration, state = frontier.pop(int(rng.integers(len(frontier))))
        checked += 1
        for joint, name in enumerate(box.names):
            joints.restore(state)
            try:
                joints.push(joint)
            except PlantFault as fault:
                raise BadFile(path, f"{_where(box, configuration)}, {name} was pushed: {fault}") from None
            after, _ = box.attempt(configuration, joint)
            if why := _disagreement(joints, box, configuration, joint):
                raise BadFile(path, f"{_where(box, configuration)}, {name} was pushed: {why}")
            if name != box.target and after not in known:
                known.add(after)
                frontier.append((after, joints.saved()))
    return checked


def _disagreement(joints: ModelJoints, box: Lockbox, before: Configuration, joint: int) -> str:
    """The disagreement between the rules and the model's motion, in words; empty if they agree."""
    name, free, after = box.names[joint], box.may_move(before, joint), joints.configuration()
    rules = f"the rules {'let it move' if free else 'lock it'}"
    others = [other for i, other in enumerate(box.names) if i != joint and after[i] != before[i]]
    if others:
        return f"{rules}, and the model moved {', '.join(others)} as well ({joints.where()})"
    if not joints.resting():
        return f"{rules}, and the model left a joint between its ends ({joints.where()})"
    if (after[joint] != before[joint]) != free:
        return f"{rules}, and the model {'held' if free else 'moved'} {name} ({joints.where()})"
    return ""


def _where(box: Lockbox, configuration: Configuration) -> str:
    return f"in configuration {bits(configuration)} ({', '.join(box.names)})"

"""Checks a user's model against the rules of its box by pushing every joint in all reachable configurations.

The model is only pushed, never set to a configuration. So parts without a name in the box (bolts, gears) have the
positions that an agent's attempts give them.
"""

from __future__ import annotations

import numpy as np

from lockprobe.boxes.box import Configuration, Lockbox, bits
from lockprobe.foundation.errors import BadFile, PlantFault
from lockprobe_robot.box_model.joints import RESTING
from lockprobe_robot.twin_settings import UserModelSettings
from lockprobe_robot.user_model.model_joints import ModelJoints
from lockprobe_robot.user_model.user_model import joints_of

MOST_CONFIGURATIONS = 64
"""Configurations in which joints are pushed before a study; if trials can reach more, a sample with a fixed seed."""


def check_model(box: Lockbox, settings: UserModelSettings) -> int:
    """Push every joint in the configurations that are reachable before the target moves, up to a number of them.

    Returns:
        The number of configurations.

    Raises:
        BadFile: If the model cannot be read or lacks a joint; if it does not rest in the initial configuration; if a
            joint moves against the rules, does not move although the rules allow it, stops between its ends or moves
            another joint. The message names the configuration and the joint.
    """
    joints = joints_of(box, settings)
    try:
        joints.start(box.initial)
    except PlantFault as fault:
        raise BadFile(settings.model, str(fault)) from None
    rng = np.random.default_rng(0)
    frontier = [(box.initial, joints.saved())]
    known, checked = {box.initial}, 0
    while frontier and checked < MOST_CONFIGURATIONS:
        configuration, state = frontier.pop(int(rng.integers(len(frontier))))
        checked += 1
        for joint, name in enumerate(box.names):
            joints.restore(state)
            if why := _disagreement(joints, box, configuration, joint):
                where = f"in configuration {bits(configuration)} ({', '.join(box.names)})"
                raise BadFile(settings.model, f"{where}, {name} was pushed: {why}")
            after = joints.configuration()
            if name != box.target and after not in known:
                known.add(after)
                frontier.append((after, joints.saved()))
    return checked


def _disagreement(joints: ModelJoints, box: Lockbox, before: Configuration, joint: int) -> str:
    """Push a joint; how the model's motion differs from the rules, in words, or nothing."""
    allowed = box.may_move(before, joint)
    try:
        joints.push(joint)
    except PlantFault as fault:
        return str(fault)
    after = joints.configuration()
    rules = f"the rules {'let it move' if allowed else 'lock it'}"
    others = [other for i, other in enumerate(box.names) if i != joint and after[i] != before[i]]
    if others:
        return f"{rules}, and the model moved {', '.join(others)} as well ({joints.where()})"
    if not joints.resting():
        return (
            f"{rules}, and the model left a joint more than {RESTING:.0%} of its travel from its ends "
            f"({joints.where()}): give it less friction (frictionloss, damping) or a spring, or push with more force"
        )
    if (moved := after[joint] != before[joint]) != allowed:
        return f"{rules}, and the model {'moved' if moved else 'held'} {box.names[joint]} ({joints.where()})"
    return ""

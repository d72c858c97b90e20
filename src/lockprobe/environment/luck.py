"""What chance decides in one trial, drawn at once and equal to what :func:`lockprobe.trial.play` draws step by step."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lockprobe.trial import Plan

__all__ = ["listing", "numbers"]


def listing(plan: Plan) -> NDArray[np.int64]:
    """For each joint as it is listed to the agent, its place in panel order; shape (joints,)."""
    joints = len(plan.box.joints)
    if not plan.shuffle:
        return np.arange(joints)
    rng = plan.stream("labels")
    rng.permutation(joints)  # the labels, which are no part of an observation in numbers
    return rng.permutation(joints)


def numbers(plan: Plan, channel: int) -> NDArray[np.float64]:
    """The numbers in [0, 1) of a channel that draws one per attempt; shape (budget,).

    Args:
        plan: The trial.
        channel: The channel's place in the chain, from 0.
    """
    return plan.stream(f"channel-{channel}").random(plan.budget)

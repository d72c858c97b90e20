"""Plays one trial of a policy in plain Python: the reference implementation for the compiled loop.

It is the loop of :mod:`lockprobe.trial.loop` for a policy, a box and an outcome flip, without records. The policy's
memory is a value that the loop passes on. Configurations are numbers with bit j for joint j in panel order, 1 if away
from start.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from lockprobe.agents.catalogue import resolve
from lockprobe.agents.cognitive import LoopBreaker, RandomMap, SoftmaxMemory
from lockprobe.agents.human_inspired import HumanInspired
from lockprobe.agents.ideal_observer import IdealObserver
from lockprobe.agents.policy import Policy, Told, View
from lockprobe.agents.strategies import RandomAgent, RandomNoRepeat
from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.families import find_box
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.plugins import allow
from lockprobe.foundation.validation import check_whole
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.second_draw import survival
from lockprobe.interventions.words import Tell

LONGEST = 10_000


@dataclass(frozen=True, slots=True, kw_only=True)
class BoxWorld:
    """A box and its reports, as numbers.

    Attributes:
        name: Name of the box.
        target: Index of the target in panel order.
        movable: The joints that may move in each configuration, one bit each, shape (2 ** joints,).
        places: Position of each joint on the panel, shape (joints, 2).
        flip: The outcome flip: its rate, and what a false report is.
        budget: Budget in steps.
        tell: Whether positions are told, outcomes, or both.
    """

    name: str
    target: int
    movable: tuple[int, ...]
    places: tuple[tuple[float, float], ...]
    flip: OutcomeFlip
    budget: int
    tell: Tell = "both"

    @property
    def states_only(self) -> bool:
        """Whether positions are told and no outcomes."""
        return self.tell == "state"

    def view(self, order: tuple[int, ...]) -> View:
        """A policy's view of the task, given the order in which joints (by index in panel order) are listed."""
        return View(
            joints=len(order), target=order.index(self.target), places=tuple(self.places[joint] for joint in order)
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class PlainTrial:
    """One trial: joints attempted, by index in panel order, whether each moved, and the reported outcomes."""

    joints: list[int]
    moved: list[bool]
    told_moved: list[bool]
    solved: bool


def play_plainly(
    policy: Policy[Any],
    world: BoxWorld,
    order: tuple[int, ...],
    channel: np.random.Generator,
    agent: np.random.Generator,
) -> PlainTrial:
    """Play one trial with the joints (by index in panel order) listed to the agent in this order.

    ``channel`` is the random stream of the outcome flip, which draws one number per step; ``agent`` that of the agent.
    """
    view = world.view(order)
    memory: Hashable = policy.begin(view)
    configuration = shown = 0
    flip, partly, noisy = world.flip, 0 < world.flip.keep < 1, world.flip.others == "noisy"
    joints: list[int] = []
    moves: list[bool] = []
    reports: list[bool] = []
    for _ in range(world.budget):
        place = policy.choose(view, memory, agent)
        joint = order[place]
        moved = bool(world.movable[configuration] >> joint & 1)
        drawn = channel.random()
        flipped = drawn < flip.p
        wrong = configuration ^ shown
        others = below(drawn, order, flip.p if noisy else flip.keep) if noisy or partly else -int(flip.keep)
        last, wrong = shown, reported(flip, wrong, joint, others if noisy else others & wrong, flipped=flipped)
        configuration ^= moved << joint
        shown = configuration ^ wrong
        said = (
            bool((shown ^ last) >> joint & 1) if world.states_only else moved != (flipped and flip.part != "position")
        )
        joints.append(joint)
        moves.append(moved)
        reports.append(said)
        if moved and joint == world.target:
            return PlainTrial(joints=joints, moved=moves, told_moved=reports, solved=True)
        shifted = None if world.tell == "outcome" else listed(shown, order)
        told = Told(joint=place, moved=said, shifted=shifted, states_only=world.states_only)
        memory = policy.remember(view, memory, told)
    return PlainTrial(joints=joints, moved=moves, told_moved=reports, solved=False)


def reported(flip: OutcomeFlip, wrong: int, joint: int, others: int, *, flipped: bool) -> int:
    """The joints whose position is false in a report of :class:`OutcomeFlip`, one bit each.

    Args:
        flip: What a false report is.
        wrong: The joints whose position was false in the last report.
        joint: The joint attempted.
        others: The joints whose position is false in this report unless they are the one attempted.
        flipped: Whether the report is inverted.
    """
    if flip.part == "outcome":
        return 0
    attempted = flipped << joint ^ (wrong if flip.inverts == "outcome" else 0)
    return others & ~(1 << joint) | attempted & 1 << joint


def below(drawn: float, order: tuple[int, ...], chance: float) -> int:
    """The joints whose second number is below a chance, one bit each.

    These are the joints whose false positions survive a report (``keep``), or whose positions it inverts (``noisy``).

    Args:
        drawn: The number that the report drew.
        order: The joints in the order of the listing.
        chance: The chance.
    """
    return sum((survival(drawn, place) < chance) << joint for place, joint in enumerate(order))


@lru_cache(maxsize=4096)
def listed(configuration: int, order: tuple[int, ...]) -> int:
    """A configuration with its bits in the order of the listing."""
    return sum((configuration >> joint & 1) << place for place, joint in enumerate(order))


def world_of(box: str | Path | Lockbox, *, flip: OutcomeFlip, max_steps: int, tell: Tell = "both") -> BoxWorld:
    """The world of a box, given by name, path or value; every report can be inverted by the flip.

    Raises:
        UserMistake: If there is no such box, a value is out of range, or reports have no such part as the flip inverts.
    """
    flip.check_told(f"symbolic?tell={tell}", outcomes=tell != "state", positions=tell != "outcome")
    lockbox = find_box(box)
    check_whole("max_steps", max_steps, 1, LONGEST)
    joints = range(len(lockbox.joints))
    movable = []
    for shifted in range(1 << len(joints)):
        configuration = tuple(position ^ bool(shifted >> j & 1) for j, position in enumerate(lockbox.initial))
        movable.append(sum(lockbox.may_move(configuration, j) << j for j in joints))
    return BoxWorld(
        name=lockbox.name,
        target=lockbox.target_index,
        movable=tuple(movable),
        places=tuple(joint.place for joint in lockbox.joints),
        flip=flip,
        budget=max_steps,
        tell=tell,
    )


def policy_of(agent: str | Policy[Any]) -> Policy[Any]:
    """The policy with a spec.

    Raises:
        UserMistake: If there is no such agent, or its memory is not one value.
    """
    if isinstance(agent, str):
        allow(agent)
    found = resolve(agent).make() if isinstance(agent, str) else agent
    if not isinstance(found, Policy):
        raise BadValue("agent", agent, "one whose whole memory is one value: a strategy or a cognitive model")
    return found


def heeds_order(policy: Policy[Any]) -> bool:
    """Whether the order of the listing can matter to a policy; True for unknown policies."""
    if type(policy) is SoftmaxMemory:
        return policy.position != 0
    return type(policy) not in _HEEDLESS


_HEEDLESS = (RandomAgent, RandomNoRepeat, HumanInspired, RandomMap, IdealObserver, LoopBreaker)
"""Policies to which the order of the listing does not matter."""

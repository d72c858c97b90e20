"""How hard a box is, in exact numbers (docs/boxes.md has examples)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lockprobe.lockbox.box import Lockbox
from lockprobe.lockbox.solve import optimal_plans, plan_moves
from lockprobe.lockbox.state_space import Space, orders, space_of

__all__ = ["Difficulty", "cycle_success", "depths", "difficulty", "undone"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Difficulty:
    """How hard a box is. Numbers that an unsolvable box lacks are None.

    Attributes:
        optimum: The fewest steps that move the target.
        optimal_plans: The number of plans with that many steps.
        depth: How many joints deep the interlock is: the layer of the target in :func:`depths`. Never more than the
            optimum; less where several joints are needed side by side, or where moves have to be undone.
        undone: The fewest moves of an optimal plan that put a joint back where it started. Where clauses only ask for
            open joints and all start closed, it is 0.
        distractors: Joints that no optimal plan moves, in panel order.
        free: Joints that may move at the start.
        reachable: Configurations that can be reached before the target moves; at most 2**(joints - 1).
        dead_ends: From how many of them the target can no longer be moved. Every move can be taken back, so that is
            none, or, if nothing opens the box, all.
        random_steps: The expected steps of a uniformly random agent without a budget; infinite where nothing moves the
            target.
        random_blocked: The share of that agent's attempts that are blocked: expected blocked attempts over expected
            steps.
        cycle_success: The share of all fixed orders of the joints that, repeated, move the target within 20 steps.
            Where it is 1, looping is not failing.
    """

    optimum: int | None
    optimal_plans: int
    depth: int | None
    undone: int | None
    distractors: tuple[str, ...]
    free: int
    reachable: int
    dead_ends: int
    random_steps: float
    random_blocked: float | None
    cycle_success: float


def difficulty(box: Lockbox) -> Difficulty:
    """All measures of difficulty, exactly."""
    space = space_of(box)
    plans = optimal_plans(box, limit=0)
    steps, blocked = _random_walk(space)
    moved = {space.target, *(j for _, j, _ in plan_moves(space))}
    reachable = len(space.reachable)
    return Difficulty(
        optimum=space.optimum,
        optimal_plans=plans.count,
        depth=depths(box)[box.target],
        undone=_undone(space),
        distractors=tuple(name for j, name in enumerate(box.names) if j not in moved) if plans.count else (),
        free=int(space.may_move[space.start].sum()),
        reachable=reachable,
        dead_ends=0 if space.optimum is not None else reachable,
        random_steps=steps,
        random_blocked=blocked,
        cycle_success=_cycle_success(space, 20),
    )


def depths(box: Lockbox) -> Mapping[str, int | None]:
    """The layer of each joint: the first round in which it may move, if no position once reached were ever lost.

    A joint that is free at the start has layer 1; any other comes one layer after the last of the joints that its
    easiest clause needs moved. This is the planners' delete relaxation: the layer of the target is the admissible
    estimate h_max (Bonet and Geffner, Artificial Intelligence 129, 2001).

    Returns:
        Joint -> layer, from 1; None for a joint that cannot move even so.
    """
    start = dict(zip(box.names, box.initial, strict=True))
    layers: dict[str, int | None] = dict.fromkeys(box.names)
    for layer in range(1, len(box.names) + 1):
        known = {name for name, found in layers.items() if found is not None}
        for name in box.names:
            clauses = box.interlock.get(name, ({},))
            met = any(all(start[o] == position or o in known for o, position in clause.items()) for clause in clauses)
            if met and name not in known:
                layers[name] = layer
    return layers


def cycle_success(box: Lockbox, budget: int = 20) -> float:
    """The share of all fixed orders of the joints that, repeated, move the target within the budget (in steps).

    It is what round-robin reaches when the order of its list is shuffled.
    """
    return _cycle_success(space_of(box), budget)


def _cycle_success(space: Space, budget: int) -> float:
    cycles = orders(space.joints)
    configurations = np.full(len(cycles), space.start)
    solved = np.zeros(len(cycles), bool)
    for step in range(budget):
        joint = cycles[:, step % space.joints]
        moved = space.may_move[configurations, joint]
        solved |= moved & (joint == space.target)
        configurations ^= np.where(moved, 1 << joint, 0)
    return float(solved.mean())


def _random_walk(space: Space) -> tuple[float, float | None]:
    """Expected steps of a random agent, and the share of them that are blocked, from the expected visits."""
    if space.optimum is None:
        return float("inf"), None
    reachable = space.reachable
    row = np.full(len(space.steps), -1)
    row[reachable] = np.arange(reachable.size)
    flow = np.eye(reachable.size)
    for j in range(space.joints):
        moved = space.may_move[reachable, j]
        after = np.where(moved, reachable ^ (1 << j), reachable)
        stays = ~moved if j == space.target else np.ones_like(moved)
        np.subtract.at(flow, (row[after[stays]], np.flatnonzero(stays)), 1 / space.joints)
    visits = np.linalg.solve(flow, np.eye(reachable.size)[0])
    blocked = 1 - space.may_move[reachable].mean(axis=1)
    return float(visits.sum()), float(visits @ blocked / visits.sum())


def undone(box: Lockbox) -> int | None:
    """The fewest moves of an optimal plan that put a joint back where it started; None if nothing opens the box."""
    return _undone(space_of(box))


def _undone(space: Space) -> int | None:
    """A plan of n moves that leaves k joints elsewhere has put (n - k) / 2 moves back."""
    if space.optimum is None:
        return None
    moved = max((int(end) ^ space.start ^ (1 << space.target)).bit_count() for end in space.last)
    return (space.optimum - moved) // 2

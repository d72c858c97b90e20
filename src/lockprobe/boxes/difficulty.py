"""Exact measures of a box's difficulty (docs/boxes.md has examples)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.solve import optimal_plans, plan_moves
from lockprobe.boxes.state_space import Space, orders, space_of


@dataclass(frozen=True, slots=True, kw_only=True)
class Difficulty:
    """The difficulty of a box. For an unsolvable box, undefined numbers are None.

    Attributes:
        optimum: The fewest steps that move the target.
        optimal_plans: The number of plans with that many steps.
        depth: Depth of the interlock in joints: the layer of the target in :func:`depths`. At most the optimum; less if
            a clause needs several joints, or moves have to be undone.
        undone: The fewest moves of an optimal plan that return a joint to its start.
        distractors: Joints that no optimal plan moves, in panel order.
        free: Number of joints that may move at the start.
        reachable: Number of configurations before the target moves; at most 2**(joints - 1).
        dead_ends: Number of reachable configurations from which the target cannot be moved. Every move can be undone,
            so it is 0, or all of them for an unsolvable box.
        random_steps: Expected steps of a uniformly random agent without a budget; infinite for an unsolvable box.
        random_blocked: Expected blocked attempts of that agent, as a share of its expected steps.
        cycle_success: Share of all fixed orders of the joints that, repeated, move the target within 20 steps. At 1, a
            looping agent never fails.
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
        undone=undone(space),
        distractors=tuple(name for j, name in enumerate(box.names) if j not in moved) if plans.count else (),
        free=int(space.may_move[space.start].sum()),
        reachable=reachable,
        dead_ends=0 if space.optimum is not None else reachable,
        random_steps=steps,
        random_blocked=blocked,
        cycle_success=cycle_success(space),
    )


def depths(box: Lockbox) -> Mapping[str, int | None]:
    """The layer of each joint in the relaxed problem, in which every position once reached stays available.

    This is the delete relaxation of planning: the layer of the target is the admissible heuristic h_max (Bonet and
    Geffner, Artificial Intelligence 129, 2001).

    Returns:
        Joint -> layer, from 1 (free at the start); None for a joint that cannot move.
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


def cycle_success(space: Space, budget: int = 20) -> float:
    """The share of fixed orders of the joints that, repeated, move the target within the budget (in steps).

    This is the success of round-robin if the order of its list is shuffled.
    """
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
    """Expected steps of a random agent and their blocked share, from expected visits of the Markov chain."""
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


def undone(space: Space) -> int | None:
    """The fewest moves of an optimal plan that return a joint to its start; None for an unsolvable box.

    A plan of n moves that leaves k joints changed has returned (n - k) / 2 moves.
    """
    if space.optimum is None:
        return None
    moved = max((int(end) ^ space.start ^ (1 << space.target)).bit_count() for end in space.last)
    return (space.optimum - moved) // 2

"""What a box takes, exactly: all optimal plans, success curves of random agents, and measures of difficulty.

docs/boxes.md has examples.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import islice

import numpy as np

from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.state_space import Space, orders, space_of


@dataclass(frozen=True, slots=True)
class Plans:
    """The optimal plans, the shortest sequences of attempts that move the target: their exact number, and the first.

    Each is a tuple of joint names that ends with the target; they are in panel order.
    """

    count: int
    listed: tuple[tuple[str, ...], ...]


def optimum(box: Lockbox) -> int | None:
    """The fewest steps that move the target; None for an unsolvable box."""
    return space_of(box).optimum


def optimal_plans(box: Lockbox, limit: int | None = 1000) -> Plans:
    """The optimal plans of a box, of which at most ``limit`` are listed; none for an unsolvable box."""
    space, names = space_of(box), box.names
    ways = Counter({int(end): 1 for end in space.last})
    for before, _, after in plan_moves(space):
        ways[before] += ways[after]
    plans = (tuple(names[j] for j in plan) for plan in _plans(space, ways))
    return Plans(count=ways[space.start], listed=tuple(islice(plans, limit)))


def plan_moves(space: Space) -> list[tuple[int, int, int]]:
    """The moves of all optimal plans except the last ones: configuration, joint, next configuration; last first."""
    found: list[tuple[int, int, int]] = []
    level = set(map(int, space.last))
    while level and space.start not in level:
        ways_in = [
            (after ^ (1 << int(j)), int(j), after)  # the move undone
            for after in sorted(level)
            for j in np.flatnonzero(space.may_move[after])
            if j != space.target and space.steps[after ^ (1 << int(j))] == space.steps[after] - 1
        ]
        found += ways_in
        level = {before for before, _, _ in ways_in}
    return found


def _plans(space: Space, ways: Mapping[int, int]) -> Iterator[tuple[int, ...]]:
    """All plans through these configurations, depth first in panel order, without recursion."""
    ends = set(map(int, space.last))
    stack: list[tuple[int, tuple[int, ...]]] = [(space.start, ())] if ways else []
    while stack:
        configuration, plan = stack.pop()
        if configuration in ends:
            yield (*plan, space.target)
            continue
        for j in reversed(range(space.joints)):
            after = configuration ^ (1 << j)
            onward = j != space.target and after in ways and space.steps[after] == space.steps[configuration] + 1
            if onward and space.may_move[configuration, j]:
                stack.append((after, (*plan, j)))


def random_success(box: Lockbox, budget: int = 20) -> float:
    """The exact probability that a uniformly random agent solves the box within the budget (in steps)."""
    return random_curve(box, budget)[-1]


def random_no_repeat_success(box: Lockbox, budget: int = 20) -> float:
    """As :func:`random_success`, for an agent that never attempts the same joint twice in a row."""
    return random_curve(box, budget, repeats=False)[-1]


def random_curve(box: Lockbox, budget: int = 20, *, repeats: bool = True) -> tuple[float, ...]:
    """The exact probability that a uniformly random agent has solved the box by step 0, 1, ... up to the budget.

    Without ``repeats`` it never attempts the same joint twice in a row.
    """
    space = space_of(box)
    n, numbers = space.joints, np.arange(2**space.joints)
    afterwards = np.where(space.may_move, numbers[:, None] ^ (1 << np.arange(n)), numbers[:, None])
    opens = space.may_move[:, space.target]
    # of unsolved trials, by configuration and last joint; the last column: no attempt yet
    mass = np.zeros((numbers.size, n + 1))
    mass[space.start, n] = 1.0
    others = np.array([n if repeats else max(n - 1, 1)] * n + [n])  # number of joints to choose from
    curve = [0.0]
    for _ in range(budget):
        each = mass / others
        chosen = each.sum(axis=1)[:, None] - (0.0 if repeats else each[:, :n])  # the probability of each joint
        chosen = np.broadcast_to(chosen, (numbers.size, n)).copy()
        curve.append(curve[-1] + float(chosen[opens, space.target].sum()))
        chosen[opens, space.target] = 0.0
        mass = np.zeros_like(mass)
        mass[afterwards, np.arange(n)] = chosen  # moves can be undone: no two configurations lead to the same one
    return tuple(curve)


@dataclass(frozen=True, slots=True, kw_only=True)
class Difficulty:
    """The difficulty of a box. For an unsolvable box, undefined numbers are None.

    Attributes:
        optimum: The fewest steps that move the target, and the number of plans with that many (``optimal_plans``).
        depth: Depth of the interlock in joints: the layer of the target in :func:`depths`. At most the optimum; less if
            a clause needs several joints, or moves have to be undone.
        undone: The fewest moves of an optimal plan that return a joint to its start.
        distractors: Joints that no optimal plan moves, in panel order.
        free: Number of joints that may move at the start.
        reachable: Number of configurations before the target moves; at most 2**(joints - 1).
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
    random_steps: float
    random_blocked: float | None
    cycle_success: float


def difficulty(box: Lockbox) -> Difficulty:
    """All measures of difficulty, exactly."""
    space = space_of(box)
    plans = optimal_plans(box, limit=0)
    steps, blocked = _random_walk(space)
    moved = {space.target, *(j for _, j, _ in plan_moves(space))}
    return Difficulty(
        optimum=space.optimum,
        optimal_plans=plans.count,
        depth=depths(box)[box.target],
        undone=undone(space),
        distractors=tuple(name for j, name in enumerate(box.names) if j not in moved) if plans.count else (),
        free=int(space.may_move[space.start].sum()),
        reachable=len(space.reachable),
        random_steps=steps,
        random_blocked=blocked,
        cycle_success=cycle_success(space),
    )


def depths(box: Lockbox) -> Mapping[str, int | None]:
    """The layer of each joint in the relaxed problem, in which every position once reached stays available.

    This is the delete relaxation of planning: the layer of the target is the admissible heuristic h_max (Bonet and
    Geffner, Artificial Intelligence 129, 2001). Layers are from 1 (free at the start); a joint that cannot move has
    none.
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

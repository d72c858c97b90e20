"""Exact solutions of a box: the optimum, all optimal plans, and success curves of random agents."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import islice

import numpy as np

from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.state_space import Space, space_of


@dataclass(frozen=True, slots=True, kw_only=True)
class Plans:
    """The optimal plans: the shortest sequences of attempts that move the target.

    Attributes:
        count: Their exact number.
        listed: The first ones in panel order, each a tuple of joint names that ends with the target.
    """

    count: int
    listed: tuple[tuple[str, ...], ...]


def optimum(box: Lockbox) -> int | None:
    """The fewest steps that move the target; None for an unsolvable box."""
    return space_of(box).optimum


def optimal_plans(box: Lockbox, limit: int | None = 1000) -> Plans:
    """The optimal plans of a box; none for an unsolvable box.

    Args:
        box: The box.
        limit: Largest number of listed plans; None lists all.
    """
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

    Args:
        box: The box.
        budget: Steps.
        repeats: Whether the agent may attempt the same joint twice in a row.
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

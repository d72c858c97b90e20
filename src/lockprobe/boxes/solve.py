"""What a box takes, exactly: all optimal plans, success curves of random agents, and measures of difficulty.

docs/boxes.md has examples.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice

import numpy as np

from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.state_space import orders, space_of


@dataclass(frozen=True, slots=True)
class Plans:
    """The optimal plans, the shortest sequences of attempts that move the target: their exact number, and the first.

    Each is a tuple of joint names that ends with the target; they are in panel order. ``distractors`` are the joints
    that none of them moves, in panel order; none for an unsolvable box.
    """

    count: int
    listed: tuple[tuple[str, ...], ...]
    distractors: tuple[str, ...]


def optimum(box: Lockbox) -> int | None:
    """The fewest steps that move the target; None for an unsolvable box."""
    return space_of(box).optimum


def optimal_plans(box: Lockbox, limit: int | None = 1000) -> Plans:
    """The optimal plans of a box, of which at most ``limit`` are listed; none for an unsolvable box."""
    space, names = space_of(box), box.names
    ends = set(map(int, space.last))
    ways, onward, level = Counter(dict.fromkeys(ends, 1)), dict[int, list[tuple[int, int]]](), ends
    while level and space.start not in level:  # from the end, one move back at a time
        before = set[int]()
        for after in sorted(level):
            for j in map(int, np.flatnonzero(space.may_move[after])):
                undone = after ^ (1 << j)
                if j != space.target and space.steps[undone] == space.steps[after] - 1:
                    ways[undone] += ways[after]
                    onward.setdefault(undone, []).append((j, after))
                    before.add(undone)
        level = before

    def plans(configuration: int, plan: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
        if configuration in ends:
            yield (*plan, space.target)
        for j, after in sorted(onward.get(configuration, [])):
            yield from plans(after, (*plan, j))

    moved = {space.target, *(j for moves in onward.values() for j, _ in moves)}
    return Plans(
        count=ways[space.start],
        listed=tuple(tuple(names[j] for j in plan) for plan in islice(plans(space.start, ()), limit)),
        distractors=tuple(name for j, name in enumerate(names) if j not in moved) if ends else (),
    )


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
    """The difficulty of a box, exactly.

    Attributes:
        optimum: The fewest steps that move the target; None for an unsolvable box.
        optimal_plans: The number of plans with that many.
        distractors: Joints that no optimal plan moves, in panel order.
        random_success: Probability that a uniformly random agent solves the box within 20 steps.
        random_no_repeat_success: The same of an agent that never attempts a joint twice in a row.
        cycle_success: Share of all fixed orders of the joints that, repeated, move the target within 20 steps: the
            success of round-robin if its list is shuffled. At 1, a looping agent never fails.
    """

    optimum: int | None
    optimal_plans: int
    distractors: tuple[str, ...]
    random_success: float
    random_no_repeat_success: float
    cycle_success: float


_BUDGET = 20
"""Steps of a trial."""


def difficulty(box: Lockbox) -> Difficulty:
    """All measures of difficulty."""
    space, plans = space_of(box), optimal_plans(box, limit=0)
    cycles = orders(space.joints)
    configurations, solved = np.full(len(cycles), space.start), np.zeros(len(cycles), bool)
    for step in range(_BUDGET):
        joint = cycles[:, step % space.joints]
        moved = space.may_move[configurations, joint]
        solved |= moved & (joint == space.target)
        configurations ^= np.where(moved, 1 << joint, 0)
    return Difficulty(
        optimum=space.optimum,
        optimal_plans=plans.count,
        distractors=plans.distractors,
        random_success=random_curve(box, _BUDGET)[-1],
        random_no_repeat_success=random_curve(box, _BUDGET, repeats=False)[-1],
        cycle_success=float(solved.mean()),
    )

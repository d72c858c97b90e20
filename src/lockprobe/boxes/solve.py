"""What a box takes, exactly: its state space, whether it can be played, its optimal plans, curves of random agents.

Configurations are numbers whose bit j is the position of joint j in panel order. docs/boxes.md has examples.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import islice, permutations

import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Clause, Lockbox


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Space:
    """Possible moves in every configuration, and the configurations reachable before the target moves.

    A clause names other joints only, so every move can be undone at once, and all reachable configurations can be
    reached from each other.

    ``target`` is an index in panel order, ``start`` the initial configuration.

    Attributes:
        may_move: Whether the interlock lets a joint move in a configuration, shape (2**n, n).
        steps: The fewest moves from the start to a configuration without the target, shape (2**n,); -1 if it cannot be
            reached.
    """

    joints: int
    target: int
    start: int
    may_move: NDArray[np.bool_]
    steps: NDArray[np.int64]

    @property
    def reachable(self) -> NDArray[np.int64]:
        """The reachable configurations."""
        return np.flatnonzero(self.steps >= 0)

    @property
    def last(self) -> NDArray[np.int64]:
        """The configurations from which optimal plans move the target; none for an unsolvable box."""
        ends = np.flatnonzero((self.steps >= 0) & self.may_move[:, self.target])
        return ends[self.steps[ends] == self.steps[ends].min()] if ends.size else ends

    @property
    def optimum(self) -> int | None:
        """The fewest steps that move the target; None for an unsolvable box."""
        return int(self.steps[self.last[0]]) + 1 if self.last.size else None


def space_of(box: Lockbox) -> Space:
    """All configurations of a box."""
    numbers, joints, target = np.arange(2 ** len(box.joints)), len(box.joints), box.target_index
    may_move = np.zeros((numbers.size, joints), bool)
    for j, name in enumerate(box.names):
        for clause in box.interlock.get(name, ({},)):
            may_move[:, j] |= holds(box, clause, numbers)
    start = sum(1 << j for j, position in enumerate(box.initial) if position)
    steps = np.full(numbers.size, -1)
    steps[start] = 0
    others = may_move.copy()
    others[:, target] = False
    front = np.array([start])
    while front.size:  # breadth first, one whole frontier at a time
        rows, moved = np.nonzero(others[front])
        after = front[rows] ^ (1 << moved)
        next_step = steps[front[0]] + 1
        steps[after[steps[after] < 0]] = next_step
        front = np.flatnonzero(steps == next_step)
    return Space(joints=joints, target=target, start=start, may_move=may_move, steps=steps)


def holds(box: Lockbox, clause: Clause, configurations: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether a clause holds entirely in each configuration; the same shape as ``configurations``."""
    bit = {name: 1 << j for j, name in enumerate(box.names)}
    named = sum(bit[other] for other in clause)
    found: NDArray[np.bool_] = (configurations & named) == sum(bit[o] for o, position in clause.items() if position)
    return found


def fault_of(box: Lockbox, shortest: int = 1) -> str | None:
    """Why a box cannot be played, in one line whose first words are the kind of the fault; None if it can be played.

    It is *unsolvable* if no sequence of attempts moves the target, *contradictory* if an alternative of the target
    holds in no reachable configuration, *too short* if the optimum has fewer than ``shortest`` steps.
    """
    space = space_of(box)
    if not space.may_move[space.start].any():
        return "unsolvable: nothing moves, every joint is locked at the start"
    if space.optimum is None:
        return f"unsolvable: no sequence of attempts moves {box.target}"
    for clause in box.interlock.get(box.target, ()):
        if not holds(box, clause, space.reachable).any():
            words = ", ".join(f"{other} = {int(position)}" for other, position in clause.items())
            return f"contradictory: {{{words}}} of target {box.target} holds in no configuration that can be reached"
    if space.optimum < shortest:
        return f"too short: solved in {space.optimum} of at least {shortest} steps"
    return None


@cache
def orders(joints: int) -> NDArray[np.int64]:
    """Every order of this many joints, shape (joints!, joints)."""
    return np.array(list(permutations(range(joints))))


def optimum(box: Lockbox) -> int | None:
    """The fewest steps that move the target; None for an unsolvable box."""
    return space_of(box).optimum


def random_curve(box: Lockbox, budget: int = 20, *, repeats: bool = True) -> tuple[float, ...]:
    """The exact probability that a uniformly random agent has solved the box by step 0, 1, ... up to the budget.

    Without ``repeats`` it never attempts the same joint twice in a row.
    """
    space = space_of(box)
    n, numbers = space.joints, np.arange(2**space.joints)
    afterwards = numbers[:, None] ^ (space.may_move << np.arange(n))
    opens = space.may_move[:, space.target]
    # of unsolved trials, by configuration and last joint; the last column: no attempt yet
    mass = np.zeros((numbers.size, n + 1))
    mass[space.start, n] = 1.0
    others = np.array([n if repeats else max(n - 1, 1)] * n + [n])  # number of joints to choose from
    curve = [0.0]
    for _ in range(budget):
        each = mass / others
        chosen = each.sum(axis=1)[:, None] - each[:, :n] * (not repeats)  # the probability of each joint
        curve.append(curve[-1] + float(chosen[opens, space.target].sum()))
        chosen[opens, space.target] = 0.0
        mass = np.zeros_like(mass)
        mass[afterwards, np.arange(n)] = chosen  # moves can be undone: no two configurations lead to the same one
    return tuple(curve)


@dataclass(frozen=True)
class Difficulty:
    """The difficulty of a box, exactly.

    Attributes:
        optimum: The fewest steps that move the target; None for an unsolvable box.
        optimal_plans: The number of plans with that many: sequences of attempts that move the target.
        plans: The first of them in panel order, as many as were asked for, each as names of joints.
        distractors: Joints that no optimal plan moves, in panel order; none of an unsolvable box.
        random_success: Probability that a uniformly random agent solves the box within 20 steps.
        random_no_repeat_success: The same of an agent that never attempts a joint twice in a row.
        cycle_success: Share of all fixed orders of the joints that, repeated, move the target within 20 steps: the
            success of round-robin if its list is shuffled. At 1, a looping agent never fails.
    """

    optimum: int | None
    optimal_plans: int
    plans: tuple[tuple[str, ...], ...]
    distractors: tuple[str, ...]
    random_success: float
    random_no_repeat_success: float
    cycle_success: float


_BUDGET = 20
"""Steps of a trial."""


def difficulty(box: Lockbox, listed: int | None = 0) -> Difficulty:
    """All measures of difficulty, with at most this many optimal plans; None lists them all."""
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

    def plans(configuration: int, plan: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
        if configuration in ends:
            yield (*plan, box.target)
        for j, after in sorted(onward.get(configuration, [])):
            yield from plans(after, (*plan, names[j]))

    moved = {space.target, *(j for moves in onward.values() for j, _ in moves)}
    cycles = orders(space.joints)
    configurations, solved = np.full(len(cycles), space.start), np.zeros(len(cycles), bool)
    for step in range(_BUDGET):
        joint = cycles[:, step % space.joints]
        moves = space.may_move[configurations, joint]
        solved |= moves & (joint == space.target)
        configurations ^= np.where(moves, 1 << joint, 0)
    return Difficulty(
        optimum=space.optimum,
        optimal_plans=ways[space.start],
        plans=tuple(islice(plans(space.start, ()), listed)),
        distractors=tuple(name for j, name in enumerate(names) if j not in moved) if ends else (),
        random_success=random_curve(box, _BUDGET)[-1],
        random_no_repeat_success=random_curve(box, _BUDGET, repeats=False)[-1],
        cycle_success=float(solved.mean()),
    )

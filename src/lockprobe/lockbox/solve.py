"""Exact facts about a box: the optimum, and what blind agents reach on it, step by step."""

from __future__ import annotations

from collections import deque

import numpy as np

from lockprobe.lockbox.box import Configuration, Lockbox

__all__ = ["optimum", "random_curve", "random_no_repeat_curve", "random_no_repeat_success", "random_success"]


def optimum(box: Lockbox) -> int | None:
    """The fewest steps that move the target, by breadth-first search; None if nothing does."""
    queue = deque([(box.initial, 0)])
    seen = {box.initial}
    while queue:
        configuration, steps = queue.popleft()
        if box.may_move(configuration, box.target_index):
            return steps + 1
        for joint in range(len(box.joints)):
            after, moved = box.attempt(configuration, joint)
            if moved and after not in seen:
                seen.add(after)
                queue.append((after, steps + 1))
    return None


def random_success(box: Lockbox, budget: int = 20) -> float:
    """The exact probability that a uniformly random agent solves the box within the budget (in steps)."""
    return random_curve(box, budget)[-1]


def random_no_repeat_success(box: Lockbox, budget: int = 20) -> float:
    """As :func:`random_success`, for an agent that never attempts the same joint twice in a row."""
    return random_no_repeat_curve(box, budget)[-1]


def random_curve(box: Lockbox, budget: int = 20) -> tuple[float, ...]:
    """The exact probability that a uniformly random agent has solved the box by step 0, 1, ... up to the budget."""
    return _blind_curve(box, budget, repeats=True)


def random_no_repeat_curve(box: Lockbox, budget: int = 20) -> tuple[float, ...]:
    """As :func:`random_curve`, for an agent that never attempts the same joint twice in a row."""
    return _blind_curve(box, budget, repeats=False)


def _blind_curve(box: Lockbox, budget: int, *, repeats: bool) -> tuple[float, ...]:
    """Propagates the distribution over (configuration, last joint) step by step; all that is solved is one place."""
    solved: tuple[Configuration, int] = ((), -1)
    start = (box.initial, -1)
    places, queue = {solved: 0, start: 1}, deque([start])
    ways = [(0, 0, 1.0)]
    while queue:
        configuration, last = before = queue.popleft()
        choices = [j for j in range(len(box.joints)) if repeats or j != last]
        for joint in choices:
            new, moved = box.attempt(configuration, joint)
            after = solved if moved and joint == box.target_index else (new, -1 if repeats else joint)
            if after not in places:
                places[after] = len(places)
                queue.append(after)
            ways.append((places[before], places[after], 1 / len(choices)))
    sources, goals, chances = map(np.array, zip(*ways, strict=True))
    mass = np.eye(len(places))[1]
    curve = [0.0]
    for _ in range(budget):
        mass = np.bincount(goals, weights=mass[sources] * chances, minlength=len(places))
        curve.append(float(mass[0]))
    return tuple(curve)

"""The policies as array code that numba can compile: equal to :mod:`lockprobe.agents`, choice by choice.

Each choice draws as many random numbers as the policy draws. All functions that are compiled together are in this file,
because numba caches compiled code until the file changes.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from lockprobe.simulation.montecarlo.rules import Integers, Memory, Numbers, Rule, Scene

RANDOM, NO_REPEAT, ROUND_ROBIN, HUMAN, SOFTMAX, MAP = range(6)
FIRST, LATER = 0, 1
BY_CONFIGURATION = 1
SPARE_OPENED, SPARE_MOVED = 0, 1
AVOID_LAST, AVOID_FAILED = 1, 2
NOT_TOLD = -1


def play_trials(
    scene: Scene,
    rule: Rule,
    memory: Memory,
    orders: Integers,
    flips: Numbers,
    lasting: Integers,
    draws: Numbers,
    steps: NDArray[np.int32],
    solved: NDArray[np.bool_],
    actions: NDArray[np.int8],
    moves: NDArray[np.bool_],
    reports: NDArray[np.bool_],
) -> None:
    """Play trials of one agent; the results are written to the last five arguments.

    Args:
        scene: The box, and which reports are given.
        rule: The agent.
        memory: Storage for the agent's memory.
        orders: The joints as they are listed in each trial, shape (trials, joints).
        flips: Random numbers of the outcome flip, shape (trials, budget); zero columns without flips.
        lasting: The joints whose false positions survive each report, one bit each; zero columns if all or none do.
            With noise, the joints whose positions each report inverts.
        draws: Random numbers of the agent, shape (trials, most that it can use).
        steps: Output: steps played, shape (trials,).
        solved: Output: whether the box was solved, shape (trials,).
        actions: Output: joints attempted, shape (trials, budget); zero columns if not recorded.
        moves: Output: whether each joint moved, the same shape.
        reports: Output: the reported outcomes, the same shape.
    """
    recorded, noisy, partly = actions.shape[1] > 0, flips.shape[1] > 0, lasting.shape[1] > 0
    for trial in range(len(steps)):
        forget(rule, memory)
        configuration = shown = 0
        steps[trial], solved[trial] = scene.budget, False
        order, numbers = orders[trial], draws[trial]
        for step in range(scene.budget):
            joint = choose(scene, rule, memory, order, numbers)
            moved = scene.movable[configuration] >> joint & 1
            flipped = 1 if noisy and flips[trial, step] < scene.p else 0
            last, wrong = shown, shown ^ configuration
            kept = lasting[trial, step] if partly else -scene.kept
            others = kept if scene.noisy else wrong & kept
            attempted = flipped << joint ^ wrong * scene.outcome
            configuration ^= moved << joint
            shown = configuration
            if not scene.positions_true:
                shown = configuration ^ (others & ~(1 << joint) | attempted & 1 << joint)
            heard = moved if scene.outcomes_true else moved ^ flipped
            said = (shown ^ last) >> joint & 1 if scene.states_only else heard
            if recorded:
                actions[trial, step], moves[trial, step], reports[trial, step] = joint, moved, said
            if moved and joint == scene.target:
                steps[trial], solved[trial] = step + 1, True
                break
            told = shown if scene.positions else NOT_TOLD
            remember(scene, rule, memory, joint, said, told)


def forget(rule: Rule, memory: Memory) -> None:
    """The memory before the first step."""
    memory.steps = memory.used = memory.failed = memory.opened = memory.won = memory.recent = memory.met = 0
    memory.moved = memory.last = -1
    if rule.kind == SOFTMAX:
        memory.traces[:] = 0
    if rule.kind == HUMAN and rule.memory == BY_CONFIGURATION:
        memory.seen[:] = 0


def choose(scene: Scene, rule: Rule, memory: Memory, order: Integers, numbers: Numbers) -> int:
    """The next joint, given the order in which joints are listed and the agent's random numbers."""
    everything = (1 << scene.joints) - 1
    if rule.kind == ROUND_ROBIN:
        return int(order[memory.steps % scene.joints])
    if rule.kind == HUMAN:
        return _human(scene, rule, memory, order, numbers)
    if rule.kind == SOFTMAX:
        _softmax_chances(scene, rule, memory, order)
        return _draw(order, memory.chances, _next(memory, numbers))
    if rule.kind == MAP:
        _map_chances(scene, rule, memory, order)
        return _draw(order, memory.chances, _next(memory, numbers))
    if rule.kind == NO_REPEAT and memory.last >= 0:
        everything &= ~(1 << memory.last)
    return _pick(order, everything, _next(memory, numbers))


def remember(scene: Scene, rule: Rule, memory: Memory, joint: int, moved: int, shown: int) -> None:
    """Update the memory after a report; ``shown`` is the told configuration, -1 if positions are not told."""
    memory.steps += 1
    if rule.kind == MAP:
        _store_first_choice(memory, joint)
        memory.recent = (memory.recent << 5 | 2 * joint + moved + 1) & ((1 << 5 * rule.window) - 1)
        memory.opened = 0 if shown == NOT_TOLD else shown
        memory.failed = memory.failed | 1 << joint if not moved and rule.avoid == AVOID_FAILED else 0
        memory.last = joint
        return
    if rule.kind == SOFTMAX:
        _update_traces(scene, rule, memory, joint, moved)
    memory.seen[memory.opened] |= 1 << joint
    memory.failed = 0 if moved else memory.failed | 1 << joint
    memory.opened = memory.opened ^ moved << joint if shown == NOT_TOLD else shown
    memory.last, memory.won = joint, moved
    if moved:
        memory.moved = joint


def _next(memory: Memory, numbers: Numbers) -> float:
    """The next random number of the agent's stream."""
    used = memory.used
    memory.used = used + 1
    return float(numbers[used])


def _pick(order: Integers, allowed: int, number: float) -> int:
    """One of several equally likely joints, as :func:`lockprobe.agents.policy.pick` does."""
    count = 0
    for joint in order:
        count += allowed >> joint & 1
    skipped = int(number * count)
    for joint in order:
        if allowed >> joint & 1:
            if not skipped:
                return int(joint)
            skipped -= 1
    return -1


def _draw(order: Integers, chances: Numbers, number: float) -> int:
    """A joint drawn by probability, as :func:`lockprobe.agents.policy.draw` does; in the order of the listing."""
    total, last = 0.0, 0
    for place in range(len(order)):
        total += chances[place]
        if number < total:
            return int(order[place])
        if chances[place] > 0:
            last = place
    return int(order[last])


def _human(scene: Scene, rule: Rule, memory: Memory, order: Integers, numbers: Numbers) -> int:
    """The choice of the human-inspired strategy."""
    target = 1 << scene.target
    everything = (1 << scene.joints) - 1
    if rule.lapse > 0 and _next(memory, numbers) < rule.lapse:
        return _pick(order, everything, _next(memory, numbers))
    ruled_out = memory.failed if rule.memory == 0 else 0
    if rule.memory == BY_CONFIGURATION:
        ruled_out = memory.seen[memory.opened]
    if rule.when == FIRST and not ruled_out & target:
        return int(scene.target)
    spared = memory.opened if rule.spare == SPARE_OPENED else 0
    if rule.spare == SPARE_MOVED and memory.moved >= 0:
        spared = 1 << memory.moved
    untried = everything & ~ruled_out
    fresh = untried & ~spared
    if rule.when == LATER and untried & target:
        fresh = fresh & ~target or target
    if rule.nearest and memory.moved >= 0:
        fresh = _nearest(scene, memory.moved, fresh)
    return _pick(order, fresh or untried or everything, _next(memory, numbers))


def _nearest(scene: Scene, moved: int, joints: int) -> int:
    """The subset of joints nearest on the panel to the joint that moved last."""
    found, least = 0, math.inf
    for joint in range(scene.joints):
        if joints >> joint & 1:
            if scene.far[moved, joint] < least:
                found, least = 0, scene.far[moved, joint]
            if scene.far[moved, joint] == least:
                found |= 1 << joint
    return found


def _softmax_chances(scene: Scene, rule: Rule, memory: Memory, order: Integers) -> None:
    """Write the choice probabilities of the softmax."""
    target, closed, failure, _, _, recent, stay, position = rule.pulls
    greatest, total = -math.inf, 0.0
    for place in range(scene.joints):
        joint = order[place]
        pull = -failure * memory.traces[joint] - position * place / max(scene.joints - 1, 1)
        if joint == scene.target:
            pull += target
        if not memory.opened >> joint & 1:
            pull += closed
        if joint == memory.last:
            pull += recent + stay * memory.won
        memory.chances[place] = pull
        greatest = max(greatest, pull)
    for place in range(scene.joints):
        memory.chances[place] = math.exp(memory.chances[place] - greatest)
        total += memory.chances[place]
    for place in range(scene.joints):
        memory.chances[place] /= total


def _update_traces(scene: Scene, rule: Rule, memory: Memory, joint: int, moved: int) -> None:
    """Update the failure traces of the softmax after a report."""
    decay, reset = rule.pulls[3], rule.pulls[4]
    kept = decay * (1 - reset) if moved else decay
    for other in range(scene.joints):
        memory.traces[other] *= kept
    if not moved:
        memory.traces[joint] = 1.0


def _map_state(memory: Memory) -> int:
    """The state of the random map, as one number."""
    return int((memory.recent << 8 | memory.opened) << 8 | memory.failed)


def _find_state(memory: Memory) -> int:
    """The index of the current state among the states that the random map has met; -1 if it is new."""
    state = _map_state(memory)
    for met in range(memory.met):
        if memory.states[met] == state:
            return met
    return -1


def _store_first_choice(memory: Memory, joint: int) -> None:
    """Store the first choice of the random map in this state."""
    if _find_state(memory) < 0:
        met = memory.met
        memory.states[met], memory.firsts[met] = _map_state(memory), joint
        memory.met = met + 1


def _map_chances(scene: Scene, rule: Rule, memory: Memory, order: Integers) -> None:
    """Write the choice probabilities of the random map."""
    met, barred, everything = _find_state(memory), memory.failed, (1 << scene.joints) - 1
    if rule.avoid == AVOID_LAST and memory.last >= 0:
        barred |= 1 << memory.last
    meant, count = 1 << memory.firsts[met] if met >= 0 else everything & ~barred or everything, 0
    for joint in order:
        count += meant >> joint & 1
    for place in range(scene.joints):
        share = (1 - rule.lapse) * (meant >> order[place] & 1) / count
        memory.chances[place] = rule.lapse / scene.joints + share


PARTS = (
    choose,
    remember,
    forget,
    _next,
    _pick,
    _draw,
    _human,
    _nearest,
    _softmax_chances,
    _update_traces,
    _map_state,
    _find_state,
    _store_first_choice,
    _map_chances,
)
"""The functions that have to be compiled together with their callers."""

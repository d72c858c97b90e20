"""Plays many trials in one compiled call; the only importer of numba in this package.

Importing numba and compiling take seconds the first time, and one or two seconds later. So nothing is imported or
compiled for a small number of trials. The functions are plain Python on arrays; the loop is that of
:func:`lockprobe.simulation.montecarlo.plain.play_plainly`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import astuple
from importlib.util import find_spec
from typing import Any, ParamSpec, TypeVar, get_args, get_type_hints

import numpy as np
from numpy.typing import NDArray

from lockprobe.agents.cognitive import RandomMap, SoftmaxMemory
from lockprobe.agents.human_inspired import HumanInspired
from lockprobe.agents.policy import Policy
from lockprobe.agents.strategies import RandomAgent, RandomNoRepeat, RoundRobin
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.second_draw import survival
from lockprobe.simulation.montecarlo.compiled_choices import HUMAN, MAP, NO_REPEAT, PARTS, RANDOM, ROUND_ROBIN, SOFTMAX
from lockprobe.simulation.montecarlo.plain import BoxWorld
from lockprobe.simulation.montecarlo.rules import RULE, SCENE, Integers, Numbers, Rule, Scene, record

Given = ParamSpec("Given")
Made = TypeVar("Made")

WORTH_COMPILING = 500_000
"""Steps in one process above which compiling pays: in plain Python they take about two seconds."""

SPAN = 1 << 17
"""Random numbers reserved for each trial."""

_GAMMA, _ONE, _TWO = map(np.uint64, (0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB))
_11, _12, _27, _30, _31, _52 = map(np.uint64, (11, 12, 27, 30, 31, 52))

_COMPILED: dict[str, Callable[..., Any]] = {}
_ASKED = Counter[str]()


def pays(steps: int) -> bool:
    """Whether compiling pays for this many steps, added to all earlier ones; never without numba."""
    _ASKED["steps"] += steps
    return _ASKED["steps"] >= WORTH_COMPILING and find_spec("numba") is not None


def compiled(function: Callable[Given, Made]) -> Callable[Given, Made]:
    """The compiled function, cached. Thread-safe."""
    name = function.__name__
    if name not in _COMPILED:
        from numba import njit
        from numba.extending import register_jitable

        if not _COMPILED:
            for part in (*PARTS, mixed, uniform, below):
                register_jitable(part)
        try:
            _COMPILED[name] = njit(cache=True, nogil=True)(function)
        except RuntimeError:  # nowhere to keep what is compiled
            _COMPILED[name] = njit(nogil=True)(function)
    return _COMPILED[name]


def mixed(key: Any, index: Any) -> Any:
    """Output ``index`` of the generator SplitMix64 (Steele, Lea and Flood 2014) begun at ``key``, both of 64 bits."""
    bits = key + index * _GAMMA
    bits = (bits ^ (bits >> _30)) * _ONE
    bits = (bits ^ (bits >> _27)) * _TWO
    return bits ^ (bits >> _31)


def uniform(key: Any, index: Any) -> Any:
    """The output as a number in [0, 1), a multiple of 2**-53."""
    return (mixed(key, index) >> _11) * 2.0**-53


def below(key: Any, index: Any, limit: Any) -> Any:
    """The output as a whole number below ``limit``, which is at most 2**12.

    The probabilities deviate from uniform by at most 2**-52, and not at all if ``limit`` is a power of two.
    """
    return ((mixed(key, index) >> _12) * limit) >> _52


def fill(key: np.uint64, first: int, offset: int, out: Numbers) -> None:
    """Write numbers ``offset``, ``offset`` + 1, ... of the trials from ``first`` on, one trial per row."""
    for trial in range(out.shape[0]):
        start = (first + trial) * SPAN + offset
        for i in range(out.shape[1]):
            out[trial, i] = uniform(key, np.uint64(start + i))


def joints_in(joints: int, depth: int) -> Integers:
    """Every sequence of ``depth`` joints, by its number, shape (joints ** depth, depth)."""
    return np.arange(joints**depth)[:, None] // joints ** np.arange(depth) % joints


def deepest(joints: int) -> int:
    """The most steps per random number whose tables still fit in the processor's cache."""
    return max(depth for depth in range(1, 13) if joints**depth <= min(2**12, 2 ** (15 - joints)))


def jumps(scene: Scene, depth: int) -> NDArray[np.uint16]:
    """Transition table: (configuration, sequence of joints) -> next configuration, or 256 plus the solving step.

    Shape (2 ** joints, joints ** depth).
    """
    sequences = joints_in(scene.joints, depth)
    after = np.repeat(np.arange(1 << scene.joints)[:, None], len(sequences), axis=1)
    for step in range(depth):
        joint = np.broadcast_to(sequences[:, step], after.shape)
        moved = scene.movable[after & 255] >> joint & (after < 256)
        after = np.where((moved > 0) & (joint == scene.target), 256 + step + 1, after ^ moved << joint)
    return after.astype(np.uint16)


def play_blind(
    key: np.uint64,
    first: int,
    budget: int,
    jump: NDArray[np.uint16],
    depth: int,
    steps: NDArray[np.int32],
    solved: NDArray[np.bool_],
) -> None:
    """Play trials, from ``first`` on, of the uniformly random agent, with one random number for ``depth`` steps.

    ``key`` is the key of the random numbers, ``jump`` the table of :func:`jumps`. The outputs are the steps played and
    whether the box was solved, both of shape (trials,).
    """
    limit = np.uint64(jump.shape[1])
    for trial in range(len(steps)):
        start, configuration, begun = (first + trial) * SPAN, 0, 0
        while configuration < 256 and begun < budget:
            configuration = int(jump[configuration, int(below(key, np.uint64(start), limit))])
            start, begun = start + 1, begun + depth
        end = begun - depth + configuration - 256
        solved[trial] = configuration >= 256 and end <= budget
        steps[trial] = end if solved[trial] else budget


def rule_of(policy: Policy[Any]) -> Rule | None:
    """A policy as a record of numbers; None if it cannot be compiled."""
    if type(policy) in _PLAIN:
        return record(RULE, {"kind": _PLAIN[type(policy)]})
    if type(policy) is HumanInspired:
        words = {"when": "target", "memory": "memory", "spare": "spare"}
        choices = {name: _place(HumanInspired, field, getattr(policy, field)) for name, field in words.items()}
        return record(RULE, {"kind": HUMAN, "nearest": policy.nearest, "lapse": policy.lapse, **choices})
    if type(policy) is SoftmaxMemory:
        return record(RULE, {"kind": SOFTMAX, "pulls": astuple(policy)})
    if type(policy) is RandomMap:
        avoid = _place(RandomMap, "avoid", policy.avoid)
        return record(RULE, {"kind": MAP, "avoid": avoid, "window": policy.window, "lapse": policy.lapse})
    return None


_PLAIN: dict[type[Policy[Any]], int] = {RandomAgent: RANDOM, RandomNoRepeat: NO_REPEAT, RoundRobin: ROUND_ROBIN}


def _place(kind: type[Policy[Any]], field: str, choice: str) -> int:
    choices: tuple[str, ...] = get_args(get_type_hints(kind)[field])
    return choices.index(choice)


def numbers_a_step(rule: Rule) -> int:
    """The most random numbers that an agent uses in a step."""
    if rule.kind == ROUND_ROBIN:
        return 0
    return 2 if rule.kind == HUMAN and rule.lapse else 1


def scene_of(world: BoxWorld) -> Scene:
    """A world as a record of numbers. Distances are rounded as in the human-inspired strategy."""
    scene = record(SCENE, {"p": world.flip.p, "budget": world.budget, "kept": int(world.flip.keep)})
    scene.joints, scene.target, scene.states_only = len(world.places), world.target, world.states_only
    scene.outcome, scene.positions = world.flip.inverts == "outcome", world.tell != "outcome"
    scene.noisy, scene.outcomes_true = world.flip.others == "noisy", world.flip.part == "position"
    scene.positions_true = world.flip.part == "outcome"
    scene.movable[: len(world.movable)] = world.movable
    for j, (x, y) in enumerate(world.places):
        for k, (u, v) in enumerate(world.places):
            scene.far[j, k] = round((u - x) ** 2 + (v - y) ** 2, 9)
    return scene


def lasting_in(flips: Numbers, orders: Integers, flip: OutcomeFlip) -> Integers:
    """The joints whose false positions survive each report, or which it inverts, one bit each: shape (trials, budget).

    Args:
        flips: The numbers that reports draw, shape (trials, budget).
        orders: The joints as they are listed in each trial, shape (trials, joints).
        flip: What a false report is; if all or no positions survive, the result has no columns.
    """
    noisy = flip.others == "noisy"
    if flip.keep in (0, 1) and not noisy:
        return np.zeros((len(flips), 0), np.int64)
    chance = flip.p if noisy else flip.keep
    survive = [(survival(flips, place) < chance) << orders[:, place, None] for place in range(orders.shape[1])]
    return np.asarray(np.sum(survive, axis=0), np.int64)

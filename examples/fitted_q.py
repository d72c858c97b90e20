"""Fitted Q iteration (Ernst, Geurts and Wehenkel 2005) on a lockbox: an agent that is trained in seconds.

    uv run python examples/fitted_q.py --box chain-4 --p 0.2

It explores at random, fits extremely randomised trees to the value of each joint in each situation that it was told
of, then to what that value promises one step earlier, and so on. It plays the joint of highest value by its last
observation alone. ``FittedQ`` is the same as an agent for studies: ``--agent python:fitted_q:FittedQ``.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import gymnasium
import numpy as np
from numpy.typing import NDArray
from sklearn.ensemble import ExtraTreesRegressor

import lockprobe.interfaces.gymnasium  # registers lockprobe/Lockbox-v0
from lockprobe import box as named_box
from lockprobe.boxes.solve import optimum, random_success
from lockprobe.interfaces.gymnasium.learned_agent import LearnedAgent

Array = NDArray[np.float64]
Envs = gymnasium.vector.VectorEnv[Any, Any, Any]
Policy = Callable[[NDArray[np.int64]], NDArray[np.int64]]
"""From observations, shape (any, entries), to joints, shape (any,)."""

DISCOUNT = 0.9
"""What a solution one step later is worth."""


def boxes(count: int, box: str = "chain-4", p: float = 0.0, *, shuffle: str = "never") -> Envs:
    """Many boxes at once, reports inverted with probability ``p``."""
    name = lockprobe.interfaces.gymnasium.ENVIRONMENT
    return gymnasium.make_vec(name, num_envs=count, box=box, p=p, shuffle=shuffle)


def explore(envs: Envs, steps: int, seed: int) -> Array:
    """Random play; one row a step: observation, joint, observation after, reward, whether the box was solved."""
    rng, rows = np.random.default_rng(seed), []
    told, _ = envs.reset(seed=seed)
    over = np.zeros(envs.num_envs, dtype=bool)
    for _ in range(steps):
        joints = rng.integers(envs.single_action_space.n, size=envs.num_envs)
        after, reward, solved, spent, _ = envs.step(joints)
        rows.append(np.column_stack([told, joints, after, reward, solved])[~over])  # the step after an end is a reset
        told, over = after, solved | spent
    return np.concatenate(rows)


def train(envs: Envs, seed: int = 1, rounds: int = 15) -> Policy:
    """A policy for these boxes."""
    joints, entries = int(envs.single_action_space.n), envs.single_observation_space.shape[0]
    rows, counts = np.unique(explore(envs, 200, seed), axis=0, return_counts=True)
    before, after, reward, solved = np.split(rows, [entries + 1, -2, -1], axis=1)
    value = np.zeros((len(rows), joints))
    for round_ in range(rounds):
        worth = reward[:, 0] + DISCOUNT * (1 - solved[:, 0]) * value.max(axis=1)
        trees = ExtraTreesRegressor(n_estimators=20, random_state=seed + round_).fit(before, worth, counts)
        value = values(trees, after, joints)
    return lambda told: values(trees, told, joints).argmax(axis=1)


def values(trees: ExtraTreesRegressor, told: NDArray[Any], joints: int) -> Array:
    """The value of every joint in every situation, shape (situations, joints)."""
    each = [trees.predict(np.column_stack([told, np.full(len(told), joint)])) for joint in range(joints)]
    return np.column_stack(each)


def play(policy: Policy, envs: Envs, seed: int = 1001) -> Array:
    """Steps to the solution in fresh trials, infinite where the budget was spent; shape (num_envs,)."""
    told, _ = envs.reset(seed=seed)
    steps, over = np.full(envs.num_envs, np.inf), np.zeros(envs.num_envs, dtype=bool)
    for step in range(1, 21):
        told, _, solved, spent, _ = envs.step(policy(told))
        steps[solved & ~over] = step
        over |= solved | spent
    return steps


class FittedQ(LearnedAgent):
    """The trained agent in a study of chain-4; it knows the order of joints, so play it with ``--shuffle never``."""

    facts: ClassVar[Mapping[str, str | float]] = {"algorithm": "fitted Q iteration", "trained at p": 0.2, "seed": 1}

    def __init__(self) -> None:
        self._policy = train(boxes(500, p=0.2), seed=1)

    def act(self, observations: NDArray[np.int64], rng: np.random.Generator) -> int:
        """The joint of highest value, by the last observation."""
        return int(self._policy(observations[-1:])[0])


def main() -> None:
    """Train, and print how the agent plays before and after."""
    parser = argparse.ArgumentParser(description="Fitted Q iteration on a lockbox.")
    parser.add_argument("--box", default="chain-4", help="name of a box")
    parser.add_argument("--p", type=float, default=0.0, help="flip probability in training")
    parser.add_argument("--played", type=float, help="flip probability in play, if it is another")
    parser.add_argument("--shuffle", action="store_true", help="list the joints in a new order in every trial")
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    shuffle = "trial" if asked.shuffle else "never"
    trained = train(boxes(500, asked.box, asked.p, shuffle=shuffle), asked.seed)
    untrained: Policy = lambda told: np.zeros(len(told), dtype=np.int64)  # noqa: E731
    played = asked.p if asked.played is None else asked.played
    rates = f"trained at a flip rate of {asked.p:g}, played at {played:g}"
    print(f"{asked.box}, {rates}, 500 trials of 20 steps")
    for name, policy in (("before training", untrained), ("after training", trained)):
        steps = play(policy, boxes(500, asked.box, played, shuffle=shuffle))
        solved = steps[np.isfinite(steps)]
        pace = f", in {solved.mean():.2f} steps on average" if solved.size else ""
        print(f"{name:>15}: {solved.size / steps.size:6.1%} solved{pace}")
    print(f"{'random agent':>15}: {random_success(named_box(asked.box)):6.1%} solved (exact)")
    print(f"{'optimum':>15}: {optimum(named_box(asked.box))} steps")


if __name__ == "__main__":
    main()

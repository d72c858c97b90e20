"""Time of a step of the Gymnasium environment, one box and many at once, against toy environments of Gymnasium.

    uv run python benchmarks/gymnasium_steps.py [--seconds 2]

CPU time of one process, random actions that are drawn before, new episodes included. One box is compared with
FrozenLake through the same ``gymnasium.make``, and many at once with as many of CartPole: FrozenLake has no environment
of its own for many at once. Every row is measured in turn with its reference, five times, and the quickest of both
count.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np

from lockprobe.interfaces.gymnasium import ENVIRONMENT

OURS: dict[str, dict[str, Any]] = {
    "lockbox, the truth": {},
    "lockbox, flips": {"p": 0.2},
    "lockbox, independent flips": {"p": 0.2, "flip": "independent"},
    "lockbox, flips, shuffled": {"p": 0.2, "shuffle": "trial"},
    "lockbox, flips and a trembling hand": {"condition": "flip?p=0.2 + tremble?p=0.1"},
}
"""The last one is not played at once in numpy, and one box plays it through the trial loop."""

TIMES = 5


def one(name: str, **asked: Any) -> Callable[[], int]:
    """Takes 1000 steps in one environment, and begins an episode where one has ended; returns their number."""
    env = gymnasium.make(name, **asked)
    env.reset(seed=1)
    actions = np.random.default_rng(0).integers(env.action_space.n, size=1000)

    def play() -> int:
        for action in actions:
            _, _, terminated, truncated, _ = env.step(action)
            if terminated or truncated:
                env.reset()
        return len(actions)

    return play


def many(name: str, count: int, **asked: Any) -> Callable[[], int]:
    """Takes 64 steps in so many environments, which begin episodes by themselves; returns the number of all steps."""
    envs = gymnasium.make_vec(name, num_envs=count, **asked)
    envs.reset(seed=1)
    actions = np.random.default_rng(0).integers(envs.single_action_space.n, size=(64, count))

    def play() -> int:
        for each in actions:
            envs.step(each)
        return actions.size

    return play


def seconds_a_step(play: Callable[[], int], seconds: float) -> float:
    """CPU time of a step, played for so long."""
    steps, began = 0, time.process_time()
    while (taken := time.process_time() - began) < seconds:
        steps += play()
    return taken / steps


def row(what: str, count: int, played: Callable[[], int], toy: str, reference: Callable[[], int], part: float) -> None:
    """One line of the table: the ratio is to the reference."""
    measured = [(seconds_a_step(played, part), seconds_a_step(reference, part)) for _ in range(TIMES)]
    ours, theirs = map(min, zip(*measured, strict=True))
    print(f"| {what} | {count:,} | {ours * 1e6:.2f} | {toy} | {theirs * 1e6:.2f} | {ours / theirs:.1f} |", flush=True)


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=2.0, help="time for each row and for its reference")
    part = parser.parse_args().seconds / TIMES
    print("| environment | environments | µs a step | against | µs a step | ratio |\n|---|---|---|---|---|---|")
    lake = one("FrozenLake-v1")
    for what, asked in OURS.items():
        row(what, 1, one(ENVIRONMENT, **asked), "FrozenLake-v1", lake, part)
    for count in (10, 100, 1000, 10_000):
        pole = many("CartPole-v1", count)
        for what, asked in list(OURS.items())[:-1]:
            row(what, count, many(ENVIRONMENT, count, **asked), "CartPole-v1", pole, part)


if __name__ == "__main__":
    main()

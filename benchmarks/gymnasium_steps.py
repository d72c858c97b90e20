"""Steps per second of the Gymnasium environment: many boxes at once against one after the other, in one run.

    uv run python benchmarks/gymnasium_steps.py [--seconds 2]

CPU time of one process, random actions that are drawn before. FrozenLake and CartPole of Gymnasium itself stand beside
ours; FrozenLake has no environment of its own for many at once, CartPole has.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import gymnasium
import numpy as np

from lockprobe.interfaces.gymnasium import ENVIRONMENT

OURS: dict[str, dict[str, Any]] = {
    "lockbox, the truth": {},
    "lockbox, flips": {"p": 0.2},
    "lockbox, flips, shuffled": {"p": 0.2, "shuffle": "trial"},
}


def seconds_a_step(name: str, count: int, mode: str | None, seconds: float, **asked: Any) -> float:
    """CPU time of one step of one environment of so many: the quickest of five measurements."""
    envs = gymnasium.make_vec(name, num_envs=count, vectorization_mode=mode, **asked)
    envs.reset(seed=1)
    actions = np.random.default_rng(0).integers(envs.single_action_space.n, size=(64, count))
    for one in actions[:4]:
        envs.step(one)
    quickest = float("inf")
    for _ in range(5):
        steps, began = 0, time.process_time()
        while (taken := time.process_time() - began) < seconds / 5:
            for one in actions:
                envs.step(one)
            steps += len(actions)
        quickest = min(quickest, taken / (steps * count))
    envs.close()
    return quickest


def row(what: str, way: str, count: int, each: float, reference: float) -> None:
    """One line of the table."""
    print(f"| {what} | {way} | {count:,} | {each * 1e6:.2f} | {1 / each:,.0f} | {reference / each:,.1f} |")


def main() -> None:
    """Prints the table; the ratio is to the same environment one after the other."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=2.0, help="time for each row")
    asked = parser.parse_args()
    print("| environment | way | environments | µs a step | steps a second | ratio |\n|---|---|---|---|---|---|")
    for what, settings in OURS.items():
        reference = seconds_a_step(ENVIRONMENT, 100, "sync", asked.seconds, **settings)
        row(what, "one after the other", 100, reference, reference)
        for count in (1, 100, 1000, 10_000):
            row(what, "at once", count, seconds_a_step(ENVIRONMENT, count, None, asked.seconds, **settings), reference)
    lake = seconds_a_step("FrozenLake-v1", 100, "sync", asked.seconds)
    row("FrozenLake-v1", "one after the other", 100, lake, lake)
    reference = seconds_a_step("CartPole-v1", 100, "sync", asked.seconds)
    row("CartPole-v1", "one after the other", 100, reference, reference)
    for count in (100, 1000, 10_000):
        row("CartPole-v1", "at once", count, seconds_a_step("CartPole-v1", count, None, asked.seconds), reference)


if __name__ == "__main__":
    main()

"""What a step and a reset cost in environments that are looked at: random actions, in one process.

    uv run python benchmarks/gymnasium_pictures.py [--seconds 20] [--plant fast-twin]

Prints a Markdown table. Processor time is that of all threads of the process, so that other work on the machine weighs
little; steps a second are by the clock, resets included.
"""

from __future__ import annotations

import argparse
import os
import time

from lockprobe.interfaces.gymnasium.single import LockboxEnv

SIZES = ((64, 64), (160, 120), (640, 480))


class Clock:
    """Time by the clock and of the processors, over the parts of a run that it is asked for."""

    def __init__(self) -> None:
        self.wall = self.processor = 0.0

    def __enter__(self) -> None:
        self._began = time.perf_counter(), time.process_time()

    def __exit__(self, *error: object) -> None:
        self.wall += time.perf_counter() - self._began[0]
        self.processor += time.process_time() - self._began[1]


def row(plant: str, observation: str, size: str, seconds: float) -> str:
    """One line of the table; returns the renderer."""
    env = LockboxEnv(observation=observation, plant=plant)
    env.action_space.seed(1)
    env.reset(seed=1)  # finds out which renderer works
    stepping, resetting, steps, resets = Clock(), Clock(), 0, 0
    while stepping.wall + resetting.wall < seconds:
        with resetting:
            env.reset()
        resets += 1
        over = False
        with stepping:
            while not over:
                *_, terminated, truncated, _ = env.step(env.action_space.sample())
                over = terminated or truncated
                steps += 1
    env.close()
    step, reset = 1000 * stepping.processor / steps, 1000 * resetting.processor / resets
    rate = steps / (stepping.wall + resetting.wall)
    print(f"| `{observation}` | {size} | {step:.1f} | {reset:.0f} | {rate:.1f} |", flush=True)
    assert env.trial is not None
    return str(env.trial.plant.get("renderer"))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=20.0, help="for each row")
    parser.add_argument("--plant", default="fast-twin", help="its spec without options")
    asked = parser.parse_args()
    print(f"{asked.plant}, load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores\n")
    print("| observation | pictures | CPU ms a step | CPU ms a reset | steps a second |\n|---|---|---|---|---|")
    row(asked.plant, "symbolic", "none", asked.seconds)
    for width, height in SIZES:
        for observation in ("rgb", "rgbd"):
            spec = f"{asked.plant}?width={width}&height={height}"
            renderer = row(spec, observation, f"{width} x {height}", asked.seconds)
    print(f"\n{renderer}")


if __name__ == "__main__":
    main()

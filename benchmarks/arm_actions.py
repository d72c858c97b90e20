"""Attempts of the arm from random configurations: is every verdict right, and what does one cost beside plain physics.

    uv run --extra twin python benchmarks/arm_actions.py [--actions 200] [--box chain-4] [--only NAME]

"As the rules" counts attempts after which the joints stand as the box's rules have it, "right" those of which the robot
also says what the rules say, of joints that are free and of joints that are locked. CPU time of one thread; plain
``mj_step`` is that of the same scene with the arm held at home, touching nothing.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import mujoco
import numpy as np
from lockprobe_robot.twin import Twin
from lockprobe_robot.twin_settings import TwinSettings

from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue, PlantFault

CONDITIONS = {
    "as it is": {},
    "4 mm, 0.3 N": {"pose_error": 0.004, "force_noise": 0.3},
    "7 mm, 0.5 N": {"pose_error": 0.007, "force_noise": 0.5},
    "twice the friction": {"friction": 2.0},
    "varied looks": {"looks": "varied"},
    "tilt 0": {"tilt": 0.0},
    "tilt 30": {"tilt": 30.0},
    "tilt 45": {"tilt": 45.0},
    "tilt 60": {"tilt": 60.0},
    "tilt 75": {"tilt": 75.0},
}
STEPS, TOGETHER = 500, 10


def main() -> None:
    """Print one row per condition."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--actions", type=int, default=200)
    parser.add_argument("--box", default="chain-4")
    parser.add_argument("--only", choices=CONDITIONS)
    arguments = parser.parse_args()
    puzzle = box(arguments.box)
    print("| condition | right | free | locked | as the rules | broken | simulated s | CPU s (most) |", end="")
    print(" x real time | x plain mj_step | peak N free, mean (most) | peak N locked, mean (least) |")
    print("|---|---|---|---|---|---|---|---|---|---|---|---|")
    for name in [arguments.only] if arguments.only else CONDITIONS:
        try:
            print(row(name, *attempts(puzzle, TwinSettings(**CONDITIONS[name]), arguments.actions)), flush=True)
        except BadValue as refusal:
            print(f"| {name} | refused: {refusal} |", flush=True)


def attempts(puzzle: Lockbox, settings: TwinSettings, count: int) -> tuple[list[dict[str, Any]], list[float], int]:
    """Attempt random joints in random configurations, and time plain steps now and then meanwhile.

    Returned is what came of each attempt, the seconds of plain steps, and how many attempts broke.
    """
    made, plain, broken = [], [], 0
    rng, twin = np.random.default_rng(7), fresh(puzzle, settings, 0)
    for number in range(count):
        configuration = tuple(bool(bit) for bit in rng.integers(0, 2, len(puzzle.joints)))
        joint = int(rng.integers(len(puzzle.joints)))
        if settings.looks == "varied" and number % 10 == 0:
            twin = fresh(puzzle, settings, number)
        twin.put(configuration)
        if number % 10 == 0:
            plain.append(plain_step(twin))
        after, moves = puzzle.attempt(configuration, joint)
        began = time.process_time()
        try:
            snapshot = twin.attempt(joint)
        except PlantFault:
            broken += 1
            twin = fresh(puzzle, settings, number)
            continue
        as_ruled = {"rule": "moved" if moves else "blocked", "as_ruled": snapshot.configuration == after}
        made.append({**snapshot.sensed, **as_ruled, "spent": time.process_time() - began})
    return made, plain, broken


def fresh(puzzle: Lockbox, settings: TwinSettings, seed: int) -> Twin:
    """A twin in its initial configuration."""
    labels = tuple("ABCDEFGH"[: len(puzzle.joints)])
    return Twin(puzzle, labels=labels, settings=settings, rng=np.random.default_rng(seed))


def plain_step(twin: Twin) -> float:
    """CPU seconds of ``mj_step`` of the same scene, the arm at home under the torques that keep it there.

    They are not corrected meanwhile, so that it is put back every few steps; otherwise it falls onto the panel.
    """
    model, data = twin.joints.model, mujoco.MjData(twin.joints.model)
    everything = mujoco.mjtState.mjSTATE_INTEGRATION
    home = np.empty(mujoco.mj_stateSize(model, everything))
    mujoco.mj_getState(model, twin.joints.data, home, everything)
    spent = 0.0
    for _ in range(STEPS // TOGETHER):
        mujoco.mj_setState(model, data, home, everything)
        began = time.process_time()
        for _ in range(TOGETHER):
            mujoco.mj_step(model, data)
        spent += time.process_time() - began
    return spent / STEPS


def row(name: str, made: list[dict[str, Any]], plain: list[float], broken: int) -> str:
    """One line of the table."""
    spent, simulated = ([one[what] for one in made] for what in ("spent", "seconds"))
    free, locked = ([one for one in made if one["rule"] == rule] for rule in ("moved", "blocked"))
    right = [f"{sum(one['verdict'] == one['rule'] for one in of)}/{len(of)}" for of in (made, free, locked)]
    moved, blocked = ([one["peak_force"] for one in of] for of in (free, locked))
    cells = [
        name,
        *right,
        f"{sum(one['as_ruled'] for one in made)}/{len(made)}",
        str(broken),
        f"{np.mean(simulated):.2f}",
        f"{np.mean(spent):.3f} ({np.max(spent):.3f})",
        f"{np.sum(simulated) / np.sum(spent):.0f}",
        f"{np.mean(spent) / (np.median(plain) * np.mean(simulated) / 0.002):.1f}",
        f"{np.mean(moved):.1f} ({np.max(moved):.1f})",
        f"{np.mean(blocked):.1f} ({np.min(blocked):.1f})",
    ]
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    main()

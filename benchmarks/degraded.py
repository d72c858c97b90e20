"""How often the viewer misreads degraded pictures: ``python benchmarks/degraded.py [--acuity 24] [--trials 10]``.

The random agent plays on ``fast-twin``, and the same pictures are degraded by every dose, with the luck that the camera
has in these trials. Printed is the share of actions whose outcome is misread, which is what Table 1 counts, for colours
alone and for colours with depth.
"""

from __future__ import annotations

import argparse
import asyncio
from dataclasses import replace

import numpy as np

from lockprobe.agents.strategies import RandomAgent
from lockprobe.agents.viewer import Sight, Viewer
from lockprobe.lockbox.families import box
from lockprobe.pictures.frame import Frame
from lockprobe.plan import Names, Plan
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.record import Moment, Percept, Task, Trial
from lockprobe.studies.modality import shown
from lockprobe.trial import play, stream_names

DOSES = {
    "blur": (0, 4, 8, 12, 16, 24, 32),
    "noise": (0, 0.5, 1, 2, 4, 8),
    "occlude": (0, 0.1, 0.2, 0.4, 0.6, 0.8),
}


class Photographer:
    """Keeps what the camera sees, and shows nothing."""

    def __init__(self) -> None:
        self.seen: list[tuple[Percept, Frame]] = []

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept as it is."""
        assert percept.look is not None
        self.seen.append((percept, percept.look()))
        return percept


def photographed(trial: int) -> tuple[Trial, Plan, list[tuple[Percept, Frame]]]:
    """A trial at random, and what the camera saw before each of its steps and after the last."""
    plan = Plan(
        key="", study="", agent="random", box=box(), modality="rgbd", p=0, flip="transient", repetition=1, trial=trial,
        seed=1, plant="fast-twin",
    )  # fmt: skip
    made = resolve_plant(plan.plant).make(plan.box, Names(plan).labels, plan.stream("plant"))
    photographer = Photographer()
    try:
        played = asyncio.run(play(plan, plant=made, interventions=[photographer], agent=RandomAgent()))
    finally:
        made.close()
    return played, plan, photographer.seen


def misread(trial: Trial, plan: Plan, seen: list[tuple[Percept, Frame]], spec: str, acuity: int) -> list[bool]:
    """Which actions' outcomes are misread, in the pictures of a modality."""
    channel, task = shown(spec), Names(plan).task(plan)
    rng = plan.stream(stream_names([channel])[0])
    percepts = [
        channel.perceive(replace(percept, look=lambda positions, frame=frame: frame), (), task, rng)
        for percept, frame in seen
    ]
    reports = Viewer(strategy=RandomAgent(), name="random", sight=Sight(acuity=acuity)).reports(task, percepts)
    return [(report.outcome == "moved") != step.moved for report, step in zip(reports[1:], trial.steps, strict=True)]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--acuity", type=int, default=24)
    parser.add_argument("--trials", type=int, default=10)
    asked = parser.parse_args()
    trials = [photographed(trial) for trial in range(1, asked.trials + 1)]
    print(f"acuity={asked.acuity}: {asked.trials} trials, {sum(len(trial.steps) for trial, _, _ in trials)} actions")
    for option, doses in DOSES.items():
        for dose in doses:
            shares = [
                np.mean(
                    [wrong for found in trials for wrong in misread(*found, f"{name}?{option}={dose}", asked.acuity)]
                )
                for name in ("rgb", "rgbd")
            ]
            print(f"{option:8} {dose:5g}  rgb {100 * shares[0]:5.1f} %  rgbd {100 * shares[1]:5.1f} %", flush=True)


if __name__ == "__main__":
    main()

"""How often the viewer misreads degraded pictures: ``python benchmarks/degraded.py [--modality rgbd]``.

The random agent plays on ``fast-twin``, and the same pictures are degraded by every dose, with the luck that the camera
has in these trials. Printed is the share of actions whose outcome is misread, which is what Table 1 counts.
"""

from __future__ import annotations

import argparse
import asyncio
from dataclasses import replace

import numpy as np

from lockprobe.agents.strategies import RandomAgent
from lockprobe.agents.viewer import Eyesight, Viewer
from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.families import box
from lockprobe.interventions.conditions import flips
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.modality import shown
from lockprobe.trial.loop import play, streams_of
from lockprobe.trial.pictures.frame import Frame
from lockprobe.trial.plan import Names, Plan
from lockprobe.trial.record import Look, Moment, Percept, Task, Trial

DOSES = {
    "blur": (0, 32, 48, 64, 96),
    "noise": (0, 1, 2, 4, 8),
    "occlude": (0, 0.1, 0.2, 0.4, 0.8),
    "exposure": (0, -10, -12, 6, 8),
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


def photographed(
    trial: int, plant: str = "fast-twin", played_box: Lockbox | None = None
) -> tuple[Trial, Plan, list[tuple[Percept, Frame]]]:
    """A trial at random, and what the camera saw before each of its steps and after the last."""
    plan = Plan(
        study="", agent="random", box=played_box or box(), condition=flips((0,), modalities=("rgbd",))[0],
        repetition=1, trial=trial, seed=1, plant=plant,
    )  # fmt: skip
    made = resolve_plant(plan.plant).make(plan.box, Names(plan).labels, plan.stream("plant"))
    photographer = Photographer()
    try:
        played = asyncio.run(play(plan, plant=made, interventions=[photographer], agent=RandomAgent()))
    finally:
        made.close()
    return played, plan, photographer.seen


def _photograph(frame: Frame) -> Look:
    """A way to look that shows this picture."""

    def look(positions: tuple[bool, ...] | None = None, /) -> Frame:
        return frame

    return look


def percepts_of(plan: Plan, seen: list[tuple[Percept, Frame]], spec: str) -> list[Percept]:
    """What is seen in a modality."""
    channel, task = shown(spec), Names(plan).task(plan)
    (rng,) = streams_of(plan, [channel])
    return [channel.perceive(replace(percept, look=_photograph(frame)), (), task, rng) for percept, frame in seen]


def misread(trial: Trial, plan: Plan, seen: list[tuple[Percept, Frame]], spec: str, acuity: int | None) -> list[bool]:
    """Which actions' outcomes are misread, in the pictures of a modality."""
    viewer = Viewer(strategy=RandomAgent(), name="random", sight=Eyesight(acuity=acuity))
    reports = viewer.reports(Names(plan).task(plan), percepts_of(plan, seen, spec))
    return [(report.outcome == "moved") != step.moved for report, step in zip(reports[1:], trial.steps, strict=True)]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--acuity", type=int, default=24)
    parser.add_argument("--trials", type=int, default=5)
    parser.add_argument("--modality", default="rgb", choices=["rgb", "rgbd"])
    asked = parser.parse_args()
    trials = [photographed(trial) for trial in range(1, asked.trials + 1)]
    actions = sum(len(trial.steps) for trial, _, _ in trials)
    print(f"{asked.modality}, acuity={asked.acuity}: {asked.trials} trials, {actions} actions")
    for option, doses in DOSES.items():
        for dose in doses:
            spec = f"{asked.modality}?{option}={dose}"
            wrong = sum(sum(misread(*found, spec, asked.acuity)) for found in trials)
            print(f"{option:8} {dose:5g}  {wrong:4} misread, {100 * wrong / actions:5.1f} %", flush=True)


if __name__ == "__main__":
    main()

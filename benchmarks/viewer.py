"""How often the viewer misreads, by how finely it sees: ``python benchmarks/viewer.py [--looks varied] [--trials 10]``.

The random agent plays on ``fast-twin``, and viewers of every acuity read the same pictures. Two shares are printed for
colours alone, and for colours with depth: of joints whose position is misread, over all pictures, and of actions whose
outcome is misread, which is what Table 1 counts.
"""

from __future__ import annotations

import argparse
import asyncio
from dataclasses import replace
from functools import partial

import numpy as np

from lockprobe.agents.strategies import RandomAgent
from lockprobe.agents.viewer import Viewer
from lockprobe.boxes.families import box
from lockprobe.interventions.camera import CameraChannel
from lockprobe.interventions.conditions import flips
from lockprobe.plants.catalogue import plant_of
from lockprobe.trial.loop import play
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Decision, Percept, Situation, Trial

ACUITIES = (8, 9, 10, 11, 12, 14, 16, 20, 24, 32, 64)


class Watcher(RandomAgent):
    """Acts at random and keeps what it was shown."""

    def __init__(self) -> None:
        self.shown: list[Percept] = []

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Any joint."""
        self.shown.append(situation.percept)
        return await super().decide(situation, rng)


def watched(plant: str, trial: int) -> tuple[Trial, Plan, list[Percept]]:
    """A trial at random, and what was seen before each of its steps."""
    plan = Plan(
        study="",
        agent="random",
        box=box(),
        condition=flips((0,), modalities=("rgbd",))[0],
        repetition=1,
        trial=trial,
        seed=1,
        plant=plant,
    )
    watcher, channels = Watcher(), [CameraChannel(depth=True)]
    played = asyncio.run(play(plan, plant=partial(plant_of, plan), interventions=channels, agent=watcher))
    return played, plan, watcher.shown


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--looks", default="plain", choices=["plain", "varied"])
    parser.add_argument("--trials", type=int, default=10)
    asked = parser.parse_args()
    wrong: dict[tuple[int, bool], list[np.ndarray]] = {}
    missed: dict[tuple[int, bool], list[bool]] = {}
    for trial in range(1, asked.trials + 1):
        played, plan, shown = watched(f"fast-twin?looks={asked.looks}", trial)
        truth = np.array([[int(step.state[i]) for i in plan.names.order] for step in played.steps])
        for acuity in ACUITIES:
            viewer = Viewer(strategy=RandomAgent(), name="random", acuity=acuity)
            for depth in (False, True):
                kinds = ("rgb", "depth") if depth else ("rgb",)
                seen = [replace(p, pictures=tuple(x for x in p.pictures if x.kind in kinds)) for p in shown]
                reports = viewer.reports(plan.names.task, seen)
                wrong.setdefault((acuity, depth), []).append(np.array([r.positions for r in reports]) != truth)
                missed.setdefault((acuity, depth), []).extend(
                    (report.outcome == "moved") != step.moved
                    for report, step in zip(reports[1:], played.steps, strict=False)
                )
    pictures = sum(len(found) for found in wrong[ACUITIES[0], False])
    print(f"looks={asked.looks}: {asked.trials} trials, {pictures} pictures")
    print(f"{'acuity':>6}  {'joints, rgb':>12} {'rgbd':>6}  {'outcomes, rgb':>14} {'rgbd':>6}")
    for acuity in ACUITIES:
        joints = [float(np.concatenate(wrong[acuity, depth]).mean()) for depth in (False, True)]
        outcomes = [float(np.mean(missed[acuity, depth])) for depth in (False, True)]
        print(f"{acuity:6}  {joints[0]:12.3f} {joints[1]:6.3f}  {outcomes[0]:14.3f} {outcomes[1]:6.3f}")


if __name__ == "__main__":
    main()

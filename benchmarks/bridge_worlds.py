"""How often the study ``bridge`` says what is true of agents whose misreadings of pictures are known.

    OMP_NUM_THREADS=1 python benchmarks/bridge_worlds.py [--studies 200] [--blocks 60] [--workers 2]

Every study is played in full, each from a seed of its own, on pictures that the program paints. The true share of an
arm is that of the mean steps of all studies together.
"""

from __future__ import annotations

import argparse
import asyncio
import math
from collections import Counter
from dataclasses import dataclass
from functools import partial

import numpy as np
from known_viewers import WORLDS, KnownViewer, PaintedBox

from lockprobe.foundation.parallel import Processes
from lockprobe.statistics.bridge.arms import ARMS, PICTURES, WORDS
from lockprobe.statistics.bridge.bridge import Bridge, bridge
from lockprobe.studies.modality import interventions_for
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running.followers import Followers
from lockprobe.trial.loop import play
from lockprobe.trial.record import Trial

_ARMS = {arm: arm for arm in (WORDS, PICTURES, *ARMS)}


@dataclass(frozen=True, slots=True)
class Job:
    """Studies of one world, from successive seeds."""

    world: str
    seeds: tuple[int, ...]
    blocks: int


def played(world: str, seed: int, blocks: int) -> Bridge:
    """One study of a world, played and analysed."""
    asked = study("bridge", trials=blocks, layout="fixed", seed=seed)
    agent, trials = KnownViewer(world=WORLDS[world]), dict[str, Trial]()
    for arm in _ARMS:
        followers = Followers(asked, dict(trials))
        for number in range(1, blocks + 1):
            plan = followers.bound(asked.plan(asked.agents[0], asked.labelled(arm), 1, number))
            assert plan is not None
            acting = interventions_for(plan.condition)
            trial = asyncio.run(play(plan, plant=PaintedBox(plan.box), interventions=acting, agent=agent))
            assert trial.error is None, trial.error
            trials[trial.key] = trial
    own = {arm: [one for one in trials.values() if one.condition == arm] for arm in _ARMS}
    found = bridge(own, _ARMS)
    assert found is not None
    return found


def studies_of(job: Job) -> list[Bridge]:
    """The studies of a job."""
    return [played(job.world, seed, job.blocks) for seed in job.seeds]


def rows(world: str, found: list[Bridge]) -> list[str]:
    """What the studies of a world said of each arm, and how often its interval held the true share."""
    means = {arm: float(np.mean([one.arm(arm).steps for one in found])) for arm in _ARMS}
    change = means[PICTURES] - means[WORDS]
    misread = sum(one.misread.misread for one in found) / max(1, sum(one.misread.claims for one in found))
    steps = ", ".join(f"{arm} {mean:.2f}" for arm, mean in means.items())
    lines = [f"{world}: {100 * misread:.1f} % of outcomes misread; mean steps: {steps}"]
    for arm in ARMS:
        said = Counter(one.verdict(arm) for one in found)
        shares = [share for one in found if (share := one.arm(arm).share) is not None]
        truth = (means[arm] - means[WORDS]) / change if change else math.nan
        held = sum(one.low <= truth <= one.high for one in shares if one.low is not None and one.high is not None)
        verdicts = ", ".join(f"{verdict} {count}" for verdict, count in said.most_common())
        lines.append(f"| {arm} | {truth:.2f} | {held} of {len(shares)} | {verdicts} |")
    return lines


def main() -> None:
    """Print the rows of every world."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for option, default in (("studies", 200), ("blocks", 60), ("workers", 2)):
        parser.add_argument(f"--{option}", type=int, default=default)
    asked = parser.parse_args()
    job = partial(Job, blocks=asked.blocks)
    parts = [
        (
            world,
            [
                job(world, tuple(range(first, asked.studies + 1, asked.workers)))
                for first in range(1, asked.workers + 1)
            ],
        )
        for world in WORLDS
    ]
    for world, jobs in parts:
        found = [one for part in Processes(asked.workers).map(studies_of, jobs) for one in part]
        print("\n".join(rows(world, found)), flush=True)


if __name__ == "__main__":
    main()

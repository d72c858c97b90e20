"""How often modalities are told apart, where nothing is and where something is.

``python benchmarks/modality_rates.py [--studies 1500] [--lapses 0.12 0.2 0.3]``

Trials of an agent on ``chain-4``, really played, are dealt to RGB, RGB-D and ground truth without regard to which is
which, and the study is analysed as any other. Trials of equal number share their luck: with ``--shared 0.5`` every
second one, on average, is the same trial in all three modalities, and the others are independent. Printed is the share
of studies in which the trend over fidelity is found at .05, with its 95 % Wilson interval; beside it of studies in
which any pair of modalities is told apart (Holm).

With ``--lapses`` the agent lapses at another rate in RGB, RGB-D and ground truth. Lapses of 0.12, 0.2 and 0.3 have the
human-inspired strategy solve 80 % of its trials by steps 11, 13 and 15; the paper has 11 for RGB, 15 for ground truth,
and RGB-D in between (Sec. 3.1).
"""

from __future__ import annotations

import argparse
import asyncio
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from lockprobe.agents.catalogue import resolve
from lockprobe.boxes.families import box
from lockprobe.interventions.conditions import flips
from lockprobe.statistics.course import cells_of, courses
from lockprobe.statistics.how_soon import ModalityEffect, modality_effects
from lockprobe.statistics.proportions import ALPHA, proportion
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial

MODALITIES = ("rgb", "rgbd", "symbolic")


def played(agent: str, trials: int) -> list[Trial]:
    """Trials of an agent that is told the truth, all of different luck."""
    study = Study(name="flips", agents=(agent,), boxes=(box(),), conditions=flips((0.0,)), repetitions=1, trials=trials)

    async def play_all() -> list[Trial]:
        return [(await play_timed(plan, resolve(agent).make()))[0] for plan in study.plans(agent)]

    return asyncio.run(play_all())


def dealt(pools: Sequence[Sequence[Trial]], trials: int, shared: float, rng: np.random.Generator) -> list[Trial]:
    """The trials of a study.

    Args:
        pools: Trials to deal from, with replacement, for each modality; all equal where no modality differs.
        trials: For each modality.
        shared: Chance that a trial is the same in all modalities, [0, 1].
        rng: Deals.
    """
    chosen = rng.integers(len(pools[0]), size=(len(MODALITIES), trials))
    same = rng.random(trials) < shared
    chosen[:, same] = chosen[0, same]
    return [
        replace(pool[place], modality=modality, trial=number)
        for modality, places, pool in zip(MODALITIES, chosen, pools, strict=True)
        for number, place in enumerate(places, 1)
    ]


def told_apart(effect: ModalityEffect) -> tuple[bool, bool]:
    """Whether the trend, and any pair, are significant."""
    tested = [effect.trend.p_value, *(pair.hazard.p_value for pair in effect.pairs)]
    trend, *pairs = (p_value is not None and p_value < ALPHA for p_value in tested)
    return trend, any(pairs)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="False positives of the tests over modalities.")
    parser.add_argument("--studies", type=int, default=1500)
    parser.add_argument("--agent", default="human-inspired", help="any agent that reads reports")
    parser.add_argument("--trials", type=int, nargs="+", default=[10, 30], help="for each modality")
    parser.add_argument("--shared", type=float, nargs="+", default=[0.0, 0.5], help="chance of equal luck")
    parser.add_argument("--lapses", type=float, nargs=3, help="of the agent in RGB, RGB-D and ground truth")
    parser.add_argument("--pool", type=int, default=2000, help="trials to deal from")
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    if chosen.lapses:
        pools = [played(f"{chosen.agent}?lapse={lapse:g}", chosen.pool) for lapse in chosen.lapses]
    else:
        pools = [played(chosen.agent, chosen.pool)] * len(MODALITIES)
    solved = ", ".join(f"{sum(trial.solved for trial in pool)} of {len(pool)}" for pool in pools)
    print(f"{chosen.agent}: {solved} trials solved; {chosen.studies} studies a row")
    print("| trials | luck shared | trend over fidelity | 95 % interval | any pair (Holm) |")
    print("|---|---|---|---|---|")
    for trials in chosen.trials:
        for shared in chosen.shared:
            rng = np.random.default_rng([chosen.seed, trials, round(100 * shared)])
            effects = (
                modality_effects(courses(cells_of(dealt(pools, trials, shared, rng)).values()))
                for _ in range(chosen.studies)
            )
            counts = np.array([told_apart(effect) for found in effects for effect in found]).sum(axis=0)
            trend, pairs = (proportion(int(count), chosen.studies) for count in counts)
            print(
                f"| {trials} | {shared:g} | {trend.value:.3f} | {trend.low:.3f} to {trend.high:.3f} "
                f"| {pairs.value:.3f} ({pairs.low:.3f} to {pairs.high:.3f}) |",
                flush=True,
            )


if __name__ == "__main__":
    main()

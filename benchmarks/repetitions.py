"""Why conclusions rest on trials and not on repetitions: ``python benchmarks/repetitions.py [--studies 400]``.

Printed are, over studies of the paper's size in a world where loops do nothing and success follows the paper's Fig. 4,
the correlation of success and loop rate over 21 repetitions; and the share of percentile intervals of a bootstrap over
repetitions of ten trials that hold the true share of solved trials, the lowest and the highest over shares of 0.1, 0.23
and 0.5 and correlations of 0, 0.2 and 0.5 within a repetition (beta-binomial).
"""

from __future__ import annotations

import argparse
from itertools import product

import numpy as np

from lockprobe.foundation.seeds import generator
from lockprobe.simulation.audit.simulate import simulate_outcomes
from lockprobe.simulation.audit.simulated_agents import WORLDS
from lockprobe.statistics.clustered import cluster_bootstrap

SHARES, CORRELATIONS, TRIALS = (0.1, 0.23, 0.5), (0.0, 0.2, 0.5), 10


def correlation(number: int) -> float:
    """Pearson's r of success and loop rate over the repetitions of one study in which loops do nothing."""
    world = WORLDS["loops-irrelevant"]
    found = simulate_outcomes(world, world.design, generator(number, world.name, "repetitions"))
    _, place = np.unique(np.stack([found.dose, found.repetition]), axis=1, return_inverse=True)
    sizes = np.bincount(place.ravel())
    solved, looping = (np.bincount(place.ravel(), what) / sizes for what in (found.solved, found.onset > 0))
    return float(np.corrcoef(solved, looping)[0, 1])


def coverage(repetitions: int, share: float, alike: float, studies: int) -> float:
    """The share of bootstrapped intervals that hold the true share."""
    rng = np.random.default_rng([repetitions, round(100 * share), round(100 * alike)])
    clusters, held = np.repeat(np.arange(repetitions), TRIALS), 0
    for _ in range(studies):
        shares = np.full(repetitions, share)
        if alike:
            shares = rng.beta(share * (1 / alike - 1), (1 - share) * (1 / alike - 1), repetitions)
        solved = rng.random((repetitions, TRIALS)) < shares[:, None]
        found = cluster_bootstrap(solved.ravel(), clusters, rng)
        held += found.low is not None and found.high is not None and found.low <= share <= found.high
    return held / studies


def main() -> None:
    """Print what was found."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--studies", type=int, default=400)
    studies = parser.parse_args().studies
    low, middle, high = np.quantile([correlation(number) for number in range(studies)], (0.05, 0.5, 0.95))
    print(f"r of success and loop rate over repetitions: median {middle:.2f}, 90 % of studies {low:.2f} to {high:.2f}")
    for repetitions in (3, 10, 30):
        found = [coverage(repetitions, share, alike, studies) for share, alike in product(SHARES, CORRELATIONS)]
        print(f"bootstrap over {repetitions} repetitions: {min(found):.0%} to {max(found):.0%} of 95 % intervals hold")


if __name__ == "__main__":
    main()

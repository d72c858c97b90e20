"""How often intervals of clustered shares hold the truth: ``python benchmarks/ceiling_coverage.py [--samples 1000]``.

Blocks of trials, as of one agent that plays the same luck at every p: all trials of a block go alike in every block
(identical), in half of the blocks, or in none (independent). Printed for each true share is the share of samples whose
interval holds it, and in brackets the mean width over that of Wilson's interval for independent trials.
"""

from __future__ import annotations

import argparse
from functools import cache

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.clustered import clustered_proportion
from lockprobe.statistics.proportions import proportion

SHARES = (0.5, 0.9, 0.95, 0.98, 0.99)
ALIKE = {"identical": 1.0, "half": 0.5, "independent": 0.0}


@cache
def ends(counts: tuple[int, ...], size: int) -> tuple[float, float, float]:
    """The interval of blocks of one size, and how wide Wilson's would be."""
    found = clustered_proportion(counts, [size] * len(counts))
    alone = proportion(found.count, found.n)
    return found.low, found.high, alone.high - alone.low


def drawn(truth: float, alike: float, blocks: int, size: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """Successes of each block, in order, as no interval depends on it."""
    same, own = rng.random((blocks, 1)) < truth, rng.random((blocks, size)) < truth
    return np.sort(np.where(rng.random((blocks, 1)) < alike, same, own).sum(axis=1))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=1000)
    parser.add_argument("--sizes", default="4,7", help="trials of a block")
    asked = parser.parse_args()
    print(f"| trials of a block | blocks | {' | '.join(map(str, SHARES))} |\n|" + "---|" * (2 + len(SHARES)))
    for size in map(int, asked.sizes.split(",")):
        for name, alike in ALIKE.items():
            for blocks in (10, 30, 100):
                cells = []
                for truth in SHARES:
                    rng = np.random.default_rng([blocks, size, round(1000 * truth)])
                    samples = (tuple(drawn(truth, alike, blocks, size, rng).tolist()) for _ in range(asked.samples))
                    low, high, alone = np.array([ends(sample, size) for sample in samples]).T
                    held = np.mean((low <= truth) & (truth <= high))
                    cells.append(f"{held:.3f} ({np.mean(high - low) / np.mean(alone):.1f})")
                print(f"| {size}, {name} | {blocks} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()

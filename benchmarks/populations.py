"""Populations of simple agents, against the same trials one by one, and what an exact course costs beside them.

    uv run python benchmarks/populations.py [--trials 200000]

CPU time of one process; all trials at a flip rate of 0.3 on ``chain-4``. The ratio is to ``lockprobe.run_trial`` called
in a loop, which a user would write instead.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import lockprobe

AGENTS = ("random", "human-inspired", "cognitive:perseverant")
FEW = 400
P = 0.3


def cpu_seconds(work: Callable[[], object]) -> float:
    """CPU time of the quicker of two."""
    taken = []
    for _ in range(2):
        began = time.process_time()
        work()
        taken.append(time.process_time() - began)
    return min(taken)


def one_by_one(agent: str) -> None:
    """Trials with their records."""
    for trial in range(1, FEW + 1):
        lockprobe.run_trial(agent=agent, p=P, trial=trial)


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=200_000, help="trials of a population")
    trials = parser.parse_args().trials
    print(f"| agent | {trials:,} trials, s | trials a second | ratio to one by one | exact course, ms |")
    print("|---|---|---|---|---|")
    for agent in AGENTS:
        alone = cpu_seconds(lambda agent=agent: one_by_one(agent)) / FEW
        many = cpu_seconds(lambda agent=agent: lockprobe.population(agent, p=P, trials=trials))
        exact = 1000 * cpu_seconds(lambda agent=agent: lockprobe.propagate(agent, p=P))
        row = f"| `{agent}` | {many:.1f} | {trials / many:,.0f} | {alone * trials / many:.0f} | {exact:.1f} |"
        print(row, flush=True)


if __name__ == "__main__":
    main()

"""Loop cover: the paper's linear programme against the solvers that Lockprobe uses, in one run.

CPU time, so that other work on the machine changes the ratios little. Everything is compiled before it is timed; what
that costs stands in its own row.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterable
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.loops import Rule, any_loop_batch, cover, kernels, measure

STEPS = 20
ACTIONS = 4

Trials = NDArray[np.int64]


def random_trials(trials: int, rng: np.random.Generator) -> Trials:
    """Uniform actions, shape (trials, 20)."""
    return rng.integers(0, ACTIONS, (trials, STEPS))


def loopy_trials(trials: int, rng: np.random.Generator) -> Trials:
    """A cycle of two to six actions over and over, one action in ten another, shape (trials, 20)."""
    cycles = [np.resize(rng.integers(0, ACTIONS, rng.integers(2, 7)), STEPS) for _ in range(trials)]
    return np.where(rng.random((trials, STEPS)) < 0.1, random_trials(trials, rng), cycles)


def cpu_seconds(work: Callable[[], object], repeats: int = 3) -> float:
    """CPU time of the quickest of a few."""
    taken = []
    for _ in range(repeats):
        began = time.process_time()
        work()
        taken.append(time.process_time() - began)
    return min(taken)


def one_by_one(trials: Iterable[list[int]], solver: str, rule: Rule) -> int:
    """Covers trials alone; returns how many actions of all are covered."""
    return sum(cover(trial, solver=solver, rule=rule).covered for trial in trials)  # type: ignore[arg-type]


def compare(kind: str, trials: Trials, literal: int) -> None:
    """Rows for one kind of trial: the programme on the first few, the others on all."""
    few = trials[:literal].tolist()
    alone = list(islice(trials.tolist(), 2000))
    assert measure(trials[:literal]).covered.sum() == one_by_one(few, "ilp", "free")
    programme = cpu_seconds(lambda: one_by_one(few, "ilp", "free"), 1) / len(few)
    ways: list[tuple[str, float]] = [("binary linear programme (HiGHS)", programme)]
    ways.append(("default solver, one trial a call", cpu_seconds(lambda: one_by_one(alone, "dp", "free")) / len(alone)))
    ways.append(("default solver, all measures, one batch", cpu_seconds(lambda: measure(trials)) / len(trials)))
    ways.append(("any loop, one batch", cpu_seconds(lambda: any_loop_batch(trials)) / len(trials)))
    for way, seconds in ways:
        print(f"| {kind} | free | {way} | {seconds * 1e6:.2f} | {programme / seconds:,.0f} |")
    rules: tuple[Rule, ...] = ("repeat", "whole")
    for rule in rules:
        assert one_by_one(few, "dp", rule) == one_by_one(few, "ilp", rule)
        programme = cpu_seconds(lambda rule=rule: one_by_one(few, "ilp", rule), 1) / len(few)
        search = cpu_seconds(lambda rule=rule: one_by_one(alone, "dp", rule)) / len(alone)
        print(f"| {kind} | {rule} | binary linear programme (HiGHS) | {programme * 1e6:.2f} | 1 |")
        print(
            f"| {kind} | {rule} | default solver, one trial a call | {search * 1e6:.2f} | {programme / search:,.0f} |"
        )


def main() -> None:
    """Prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=100_000, help="trials in a batch")
    parser.add_argument("--literal", type=int, default=200, help="trials for the linear programme")
    asked = parser.parse_args()
    rng = np.random.default_rng(0)
    randoms, loopies = random_trials(asked.trials, rng), loopy_trials(asked.trials, rng)
    long = random_trials(50_000, rng).ravel()
    loading = cpu_seconds(lambda: (measure(randoms[: kernels.WORTH_COMPILING // STEPS]), cover(long)), 1)
    print(f"first large batch and first long sequence, with numba's import and compilation: {loading:.1f} s\n")
    print(f"| trials of {STEPS} | cover | way | µs a trial | ratio |\n|---|---|---|---|---|")
    compare("random", randoms, asked.literal)
    compare("loopy", loopies, asked.literal)
    print("\n| one sequence of | ns an action | seconds |\n|---|---|---|")
    for n in (10_000, 100_000, 1_000_000):
        seconds = cpu_seconds(lambda n=n: cover(long[:n]), 5)
        print(f"| {n:,} random actions | {seconds / n * 1e9:.0f} | {seconds:.4f} |")


if __name__ == "__main__":
    main()

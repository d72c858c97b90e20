"""Loop cover: the paper's linear programme, and n-grams in plain Python, against the solvers of Lockprobe, in one run.

CPU time, so that other work on the machine changes the ratios little. Trials of every length are covered twice: as
without numba, and once everything is compiled; what that costs stands in its own row.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.loops import Rule, any_loop_batch, cover, kernels, measure

STEPS = 20
ACTIONS = 4
LENGTHS = (20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000, 100_000, 1_000_000)

Trials = NDArray[np.int64]


def random_trials(trials: int, rng: np.random.Generator) -> Trials:
    """Uniform actions, shape (trials, 20)."""
    return rng.integers(0, ACTIONS, (trials, STEPS))


def loopy_trials(trials: int, rng: np.random.Generator) -> Trials:
    """A cycle of two to six actions over and over, one action in ten another, shape (trials, 20)."""
    cycles = [np.resize(rng.integers(0, ACTIONS, rng.integers(2, 7)), STEPS) for _ in range(trials)]
    return np.where(rng.random((trials, STEPS)) < 0.1, random_trials(trials, rng), cycles)


def one_trial(kind: str, n: int, rng: np.random.Generator) -> list[int]:
    """A trial of ``n`` actions: random, a cycle of five with one action in ten another, or that cycle alone."""
    random, cycle = rng.integers(0, ACTIONS, n), np.resize([0, 1, 2, 3, 1], n)
    trials = {"random": random, "loopy": np.where(rng.random(n) < 0.1, random, cycle), "cycle": cycle}
    return trials[kind].tolist()


def by_n_grams(actions: list[int], shortest: int = 3) -> tuple[int, list[tuple[int, int]]]:
    """A greatest cover as one would write it at first: how many actions it covers, and its pieces (start, length).

    Longer loops than those of ``2 * shortest - 1`` actions cover no more.
    """
    n = len(actions)
    first: dict[tuple[int, ...], int] = {}
    loops = set()
    for length in range(shortest, 2 * shortest):
        for start in range(n - length + 1):
            word = tuple(actions[start : start + length])
            if start - first.setdefault(word, start) >= length:
                loops.add(word)
    best, piece = [0] * (n + 1), [0] * (n + 1)
    for start in range(n - shortest, -1, -1):
        best[start] = best[start + 1]
        for length in range(shortest, min(2 * shortest - 1, n - start) + 1):
            covered = length + best[start + length]
            if covered > best[start] and tuple(actions[start : start + length]) in loops:
                best[start], piece[start] = covered, length
    pieces, start = [], 0
    while start < n:
        if piece[start]:
            pieces.append((start, piece[start]))
        start += piece[start] or 1
    return best[0], pieces


def cpu_seconds(work: Callable[[], object], repeats: int = 3) -> float:
    """CPU time of the quickest of a few, each repeated for ten milliseconds."""
    began, times = time.process_time(), 0
    while time.process_time() - began < 0.01:
        work()
        times += 1
    taken = []
    for _ in range(repeats):
        began = time.process_time()
        for _ in range(times):
            work()
        taken.append((time.process_time() - began) / times)
    return min(taken)


def in_turn(ways: Sequence[Callable[[], object]], repeats: int) -> list[float]:
    """CPU time of each of some ways, taken in turn."""
    return [min(taken) for taken in zip(*([cpu_seconds(way, 1) for way in ways] for _ in range(repeats)), strict=True)]


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


def repeats(n: int) -> int:
    """How often a trial of ``n`` actions is covered for its time."""
    return 15 if n <= 10_000 else 2


def lengths(rng: np.random.Generator) -> float:
    """A row for each kind and length of one trial; returns the time to import numba and its compiled code."""
    trials = {(kind, n): one_trial(kind, n, rng) for kind in ("random", "loopy", "cycle") for n in LENGTHS}
    worth, kernels.WORTH_COMPILING = kernels.WORTH_COMPILING, sys.maxsize
    taken = {}
    for key, trial in trials.items():
        assert cover(trial).covered == by_n_grams(trial)[0]
        taken[key] = in_turn([partial(by_n_grams, trial), partial(cover, trial)], repeats(len(trial)))
    kernels.WORTH_COMPILING = 0
    began = time.process_time()
    cover(trials["random", 100])
    measure(np.zeros((1, STEPS), dtype=np.int64))
    loading = time.process_time() - began
    print("| one trial | actions | n-grams µs | without numba µs | ratio | compiled µs | ratio |")
    print("|---|---|---|---|---|---|---|")
    for (kind, n), trial in trials.items():
        base, plain = taken[kind, n]
        again, fast = in_turn([partial(by_n_grams, trial), partial(cover, trial)], repeats(n))
        print(
            f"| {kind} | {n:,} | {min(base, again) * 1e6:,.0f} | {plain * 1e6:,.0f} | {base / plain:.2f} "
            f"| {fast * 1e6:,.0f} | {again / fast:.1f} |"
        )
    kernels.WORTH_COMPILING = worth
    return loading


def main() -> None:
    """Prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=100_000, help="trials in a batch")
    parser.add_argument("--literal", type=int, default=200, help="trials for the linear programme")
    asked = parser.parse_args()
    rng = np.random.default_rng(0)
    loading = lengths(rng)
    print(f"\nonce a process, to import numba and what it compiled: {loading:.1f} s\n")
    randoms, loopies = random_trials(asked.trials, rng), loopy_trials(asked.trials, rng)
    print(f"| trials of {STEPS} | cover | way | µs a trial | ratio |\n|---|---|---|---|---|")
    compare("random", randoms, asked.literal)
    compare("loopy", loopies, asked.literal)


if __name__ == "__main__":
    main()

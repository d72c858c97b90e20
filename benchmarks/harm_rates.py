"""How often a blind agent's loops are taken for harmful: ``python benchmarks/harm_rates.py [--studies 200]``.

Agents that ignore all reports play a box; their success after a loop is tested against an odds ratio of 1, and against
the odds ratio of a blind agent with their own action habits on the box. Nothing that they do follows from a loop, so
that a test should find harm, or help, in .05 of studies. ``target_or_list`` and ``own_order`` have habits that no chain
of first order holds: the second test finds more than such habits there, although loops do nothing. ``stuck`` is
harmed: once a loop is complete it repeats its last joint with probability 0.9.

Printed are the shares of studies in which each test rejects, the true odds ratio and the mean baseline.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.families import box
from lockprobe.simulation.power.worlds import P
from lockprobe.statistics.inference.hazard import LoopEffect, loop_hazard
from lockprobe.statistics.loops import onset_batch
from lockprobe.statistics.loops.habit_baseline import Actions, blind_trials, played_out
from lockprobe.statistics.loops.null_models import chain_walks
from lockprobe.statistics.proportions import ALPHA

BUDGET = 20

Walks = NDArray[np.int64]
Play = Callable[[NDArray[np.float64], Walks, int, np.random.Generator], Walks]
"""Joints attempted, shape (trials, budget), from p, the joint at each place of the list, the target, a stream."""


def from_chain(first: NDArray[np.float64], after: NDArray[np.float64], trials: int, rng: np.random.Generator) -> Walks:
    """Walks of a chain, shape (trials, budget)."""
    return chain_walks(first, after, rng.random((BUDGET, trials))).T.astype(np.int64)


def leaning(to: int, share: float, n: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """One of n symbols is taken with that probability at every step, the others alike."""
    first = np.full(n, (1 - share) / (n - 1))
    first[to] = share
    return first, np.tile(first, (n, 1))


def following(step: int, share: float, n: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The symbol so many places on from the last is taken with that probability, the others alike."""
    on = np.roll(np.eye(n), step, axis=1)
    return np.full(n, 1 / n), share * on + (1 - share) / (n - 1) * (1 - on)


def uniform(p: NDArray[np.float64], listed: Walks, target: int, rng: np.random.Generator) -> Walks:
    """Any joint."""
    return rng.integers(0, listed.shape[1], (len(p), BUDGET))


def no_repeat(p: NDArray[np.float64], listed: Walks, target: int, rng: np.random.Generator) -> Walks:
    """Any joint but the last."""
    return from_chain(*following(0, 0.0, listed.shape[1]), len(p), rng)


def target_often(p: NDArray[np.float64], listed: Walks, target: int, rng: np.random.Generator) -> Walks:
    """The target with probability 0.4."""
    return from_chain(*leaning(target, 0.4, listed.shape[1]), len(p), rng)


def last_again(p: NDArray[np.float64], listed: Walks, target: int, rng: np.random.Generator) -> Walks:
    """The last joint with probability 0.5."""
    return from_chain(*following(0, 0.5, listed.shape[1]), len(p), rng)


def round_robin(p: NDArray[np.float64], listed: Walks, target: int, rng: np.random.Generator) -> Walks:
    """The next joint of the panel with probability 0.8."""
    return from_chain(*following(1, 0.8, listed.shape[1]), len(p), rng)


def round_the_list(p: NDArray[np.float64], listed: Walks, target: int, rng: np.random.Generator) -> Walks:
    """The next joint of the list, which is shuffled, with probability 0.8."""
    return np.take_along_axis(listed, from_chain(*following(1, 0.8, listed.shape[1]), len(p), rng), axis=1)


def first_of_the_list(p: NDArray[np.float64], listed: Walks, target: int, rng: np.random.Generator) -> Walks:
    """The first joint of the list with probability 0.4."""
    return np.take_along_axis(listed, from_chain(*leaning(0, 0.4, listed.shape[1]), len(p), rng), axis=1)


def target_by_p(p: NDArray[np.float64], listed: Walks, target: int, rng: np.random.Generator) -> Walks:
    """The target with probability 0.1 + p."""
    walks = np.empty((len(p), BUDGET), dtype=np.int64)
    for at in np.unique(p):
        walks[p == at] = from_chain(*leaning(target, 0.1 + at, listed.shape[1]), int((p == at).sum()), rng)
    return walks


def target_or_list(p: NDArray[np.float64], listed: Walks, target: int, rng: np.random.Generator) -> Walks:
    """The target with probability 0.3, else the next joint of the list in four of five cases."""
    walks = round_the_list(p, listed, target, rng)
    return np.where(rng.random(walks.shape) < 0.3, target, walks)


def own_order(p: NDArray[np.float64], listed: Walks, target: int, rng: np.random.Generator) -> Walks:
    """In each trial the next joint of an order of its own with probability 0.8."""
    own = np.argsort(rng.random(listed.shape), axis=1)
    return np.take_along_axis(own, from_chain(*following(1, 0.8, listed.shape[1]), len(p), rng), axis=1)


def stuck(p: NDArray[np.float64], listed: Walks, target: int, rng: np.random.Generator) -> Walks:
    """Any joint but the last; once a loop is complete, the last again with probability 0.9."""
    walks = no_repeat(p, listed, target, rng)
    onset = onset_batch(walks)
    again = rng.random(walks.shape) < 0.9
    for step in range(1, BUDGET):
        looped = (onset > 0) & (onset <= step)
        walks[:, step] = np.where(looped & again[:, step], walks[:, step - 1], walks[:, step])
    return walks


BLIND: tuple[Play, ...] = (
    uniform, no_repeat, target_often, last_again, round_robin, round_the_list, first_of_the_list, target_by_p
)  # fmt: skip
OTHERS: tuple[Play, ...] = (target_or_list, own_order)
HARMED: tuple[Play, ...] = (stuck,)


def study(play: Play, lockbox: Lockbox, trials: int, rng: np.random.Generator) -> tuple[LoopEffect, LoopEffect]:
    """One study of so many trials a p, tested against 1 and against the agent's own habits."""
    n, p = len(lockbox.joints), np.repeat(P, trials)
    listed = np.argsort(rng.random((len(p), n)), axis=1)
    walks = play(p, listed, lockbox.target_index, rng)
    found = played_out(walks, p, lockbox)
    actions = Actions(
        p=p,
        joints=tuple(row[:length] for row, length in zip(walks, found.length, strict=True)),
        ways=np.stack([np.tile(np.arange(n), (len(p), 1)), np.argsort(rng.random(listed.shape), axis=1), listed]),
        budget=BUDGET,
    )
    return loop_hazard(found), loop_hazard(found, blind_trials(actions, lockbox, rng))


def row(play: Play, lockbox: Lockbox, trials: int, studies: int) -> str:
    """Rates of one agent at one size."""
    found = [study(play, lockbox, trials, np.random.default_rng([number, trials])) for number in range(studies)]
    one, own = np.mean([[e.p_value is not None and e.p_value < ALPHA for e in effects] for effects in found], axis=0)
    bases = [against.blind.odds_ratio for _, against in found if against.blind]
    luck, p = np.random.default_rng(0), np.repeat(P, 20_000)
    listed = np.argsort(luck.random((len(p), len(lockbox.joints))), axis=1)
    truth = loop_hazard(played_out(play(p, listed, lockbox.target_index, luck), p, lockbox))
    name = play.__name__.replace("_", " ")
    mean = float(np.exp(np.mean(np.log(bases))))
    return f"| {name} | {trials} | {truth.odds_ratio:.2f} | {mean:.2f} | {one:.3f} | {own:.3f} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--studies", type=int, default=200)
    parser.add_argument("--box", default="chain-4")
    parser.add_argument("--trials", default="30,100,300", help="trials a p")
    parser.add_argument("--agents", default=",".join(play.__name__ for play in (*BLIND, *OTHERS, *HARMED)))
    asked = parser.parse_args()
    lockbox = box(asked.box)
    print("| agent | trials a p | odds ratio | mean baseline | against 1 | against the baseline |\n|" + "---|" * 6)
    for play in (*BLIND, *OTHERS, *HARMED):
        for trials in map(int, asked.trials.split(",")):
            if play.__name__ in asked.agents.split(","):
                print(row(play, lockbox, trials, asked.studies), flush=True)


if __name__ == "__main__":
    main()

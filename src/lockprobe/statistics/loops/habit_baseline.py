"""The habit baseline: simulated trials of a blind agent with an agent's own action habits, on its box.

A blind agent ignores every report. Its success still correlates with its loops, because of the box: a repeated action
may meet an unchanged box, and a habit of taking all joints in turn solves the box in the second round. The odds of
solving after a loop with these habits on this box are the null hypothesis for the test of whether loops do harm
(:mod:`lockprobe.statistics.inference.hazard`).

*Habits* are a first-order Markov chain of actions at each p, as in the null ``markov`` of loop rates. Labels and their
listing are shuffled between trials, so habits can concern joints, labels, or places in the list. The three models have
equally many parameters; the one of greatest likelihood is used.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.state_space import space_of
from lockprobe.statistics.loops.chance import first_loops
from lockprobe.statistics.loops.null_models import chain_walks, markov_chain
from lockprobe.statistics.outcomes import Outcomes
from lockprobe.trial.record import Trial

__all__ = ["Actions", "actions_of", "blind_trials", "blind_twin", "played_out"]

Whole = NDArray[np.int64]

SIMULATED = 20_000
"""Trials simulated for one agent over all p, at least."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Actions:
    """The actions of one agent's trials on a box of n joints.

    Attributes:
        p: Flip probability of each trial, [0, 1], shape (trials,).
        joints: The joints that each trial attempted, by place in the box, at least one.
        ways: The joint of each symbol, shape (3, trials, n). The three codings use joints, labels in alphabetical
            order, or places in the list as symbols.
        budget: Steps of a trial.
    """

    p: NDArray[np.float64]
    joints: tuple[Whole, ...]
    ways: Whole
    budget: int


@dataclass(frozen=True, slots=True)
class _Chain:
    """A fitted Markov chain: its symbols in order, initial probabilities and transition probabilities."""

    symbols: Whole
    first: NDArray[np.float64]
    after: NDArray[np.float64]


def blind_twin(
    trials: Sequence[Trial], box: Lockbox | None, rng: np.random.Generator, doses: Sequence[float] | None = None
) -> Outcomes | None:
    """Simulated trials of a blind agent with the habits of these trials; None if the box is not known.

    ``doses`` are their doses on an axis, as :func:`lockprobe.statistics.outcomes.outcomes` takes them.
    """
    if box is None or any(set(trial.joints) != set(box.names) for trial in trials):
        return None
    return blind_trials(actions_of(trials, box, doses), box, rng)


def actions_of(trials: Sequence[Trial], box: Lockbox, doses: Sequence[float] | None = None) -> Actions:
    """The actions in one agent's ended trials on the box."""
    at = [trial.p or 0.0 for trial in trials] if doses is None else doses
    kept = [(trial, dose) for trial, dose in zip(trials, at, strict=True) if trial.ending != "error" and trial.steps]
    played = [trial for trial, _ in kept]
    meant = [
        {label: box.names.index(name) for label, name in zip(trial.labels, trial.joints, strict=True)}
        for trial in played
    ]  # by name: the panel may differ from trial to trial
    ways = [
        [range(len(box.joints)) for _ in played],
        [[one[label] for label in sorted(one)] for one in meant],
        [[one[label] for label in trial.listing] for one, trial in zip(meant, played, strict=True)],
    ]
    return Actions(
        p=np.array([dose for _, dose in kept], dtype=np.float64),
        joints=tuple(np.array([*map(box.names.index, trial.actions)], dtype=np.int64) for trial in played),
        ways=np.array(ways, dtype=np.int64).reshape(3, len(played), len(box.joints)),
        budget=max((trial.budget for trial in played), default=0),
    )


def blind_trials(actions: Actions, box: Lockbox, rng: np.random.Generator) -> Outcomes | None:
    """Simulated trials of a blind agent with these habits on the same box; None without trials.

    The shares of trials over p are equal. The box follows its rules; failures of a robot are not simulated.
    """
    if not actions.joints:
        return None
    chains, _, way = max(((*_fitted(actions, way), way) for way in actions.ways), key=itemgetter(1))
    times = -(-SIMULATED // len(actions.p))
    walks, p = [], []
    for at, chain in chains.items():
        meant = np.repeat(way[actions.p == at], times, axis=0)
        drawn = chain.symbols[chain_walks(chain.first, chain.after, rng.random((actions.budget, len(meant)))).T]
        walks.append(np.take_along_axis(meant, drawn, axis=1))
        p.append(np.full(len(meant), at))
    return played_out(np.concatenate(walks), np.concatenate(p), box)


def played_out(joints: Whole, p: NDArray[np.float64], box: Lockbox) -> Outcomes:
    """The outcomes of fixed action sequences by the rules of the box; no two trials share luck.

    Args:
        joints: Joints attempted until the box is solved, by place in the box, shape (trials, budget).
        p: Flip probability of each trial, shape (trials,).
        box: The box.
    """
    space = space_of(box)
    trials, budget = joints.shape
    state, length = np.full(trials, space.start), np.full(trials, budget)
    solved = np.zeros(trials, dtype=np.bool_)
    for step in range(budget):
        joint = joints[:, step]
        moved = space.may_move[state, joint]
        state = np.where(moved, state ^ (1 << joint), state)
        now = moved & (joint == space.target) & ~solved
        length[now] = step + 1
        solved |= now
    onset = first_loops(joints.astype(np.int8))
    return Outcomes(
        dose=p,
        repetition=np.ones(trials, dtype=np.int64),
        trial=np.arange(1, trials + 1),
        length=length,
        solved=solved,
        onset=np.where(onset <= length, onset, 0),
    )


def _fitted(actions: Actions, way: Whole) -> tuple[dict[float, _Chain], float]:
    """The chain at each p and the log-likelihood of all actions, with ``way`` as the coding of symbols."""
    symbols = [meant.argsort()[joints] for meant, joints in zip(way, actions.joints, strict=True)]
    chains, likelihood = {}, 0.0
    for at in np.unique(actions.p).tolist():
        here = [row for row, p in zip(symbols, actions.p, strict=True) if p == at]
        first, after = markov_chain([row.tolist() for row in here])
        order = np.array(list(dict.fromkeys(np.concatenate(here).tolist())))
        place = np.empty(order.max() + 1, dtype=np.int64)
        place[order] = np.arange(len(order))
        chains[at] = _Chain(order, first, after)
        for row in here:
            seen = place[row]
            likelihood += float(np.log(first[seen[0]]) + np.log(after[seen[:-1], seen[1:]]).sum())
    return chains, likelihood

"""Exact results of a policy's trials: propagates probabilities and draws no random numbers.

A trial of a policy is a Markov chain. A state is the true configuration, the positions told last as far as the next
report heeds them, and the policy's memory. If the memory has few values, the probability of every state after every
step can be computed, and from it the success rate in the limit of infinitely many trials. Larger state spaces are
sampled by :mod:`lockprobe.simulation.kernel`, conditions of other interventions by :func:`lockprobe.run_trial`.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations, product
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from lockprobe.agents.ideal_observer import IdealObserver
from lockprobe.agents.policy import Policy
from lockprobe.agents.strategies import HumanInspired, LoopBreaker, RandomAgent, RandomNoRepeat, SoftmaxMemory
from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.families import DEFAULT_BOX
from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.flip import DEFAULT, FlipKind, OutcomeFlip
from lockprobe.simulation.kernel import Minds, World, policy_of, world_of

MOST_STATES = 200_000
"""States that are followed at once, over all orders of the joints."""

_ROUNDING = 1e-9
"""Tolerance for rounding errors in sums of probabilities."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Propagation:
    """Exact results of a trial: the probability that the box is solved by step 0, 1, ..., shape (budget + 1,)."""

    solved: tuple[float, ...]

    @property
    def success(self) -> float:
        """Probability that the box is solved within the budget."""
        return self.solved[-1]

    @property
    def steps(self) -> float:
        """Expected length of a trial; one that is not solved uses up its budget."""
        return sum(1 - share for share in self.solved[:-1])

    def by(self, share: float) -> int | None:
        """The first step by which this share of trials is solved; None if the budget ends before."""
        return next((step for step, solved in enumerate(self.solved) if solved > share - _ROUNDING), None)


def propagate(
    agent: str | Policy[Any] = "human-inspired",
    box: str | Path | Lockbox = DEFAULT_BOX,
    *,
    p: float = 0.0,
    flip: FlipKind | OutcomeFlip = DEFAULT,
    modality: str | None = None,
    max_steps: int = 20,
) -> Propagation:
    """The exact success of one agent on one box, step by step, over all orders in which joints can be listed.

    Args:
        agent: Spec of an agent that is a policy, or a policy.
        box: Name of a box, path of a TOML file, or a box.
        p: Flip probability, [0, 1].
        flip: What a false report is: a word, or a flip with any option but ``while``, whose rate does not count.
        modality: How the box is shown: ``symbolic?tell=state`` (positions only; policies compare them, as they do with
            pictures that they see well), ``symbolic`` (outcomes too) or ``symbolic?tell=outcome`` (no positions). The
            default is that of studies.
        max_steps: Budget in steps.

    >>> course = propagate("human-inspired")
    >>> round(course.steps, 9), course.by(0.8), course.by(1)
    (8.5, 9, 10)
    """
    policy, world = policy_of(agent), world_of(box, flip, p, modality, max_steps)
    if world.flip.while_ != "always":
        raise BadValue("flip", "while=looping", "none with while, which has to be sampled (lockprobe.run_trial)")
    panel = tuple(range(world.space.joints))
    heedless = (RandomAgent, RandomNoRepeat, HumanInspired, IdealObserver, LoopBreaker)
    heeds = policy.position != 0 if type(policy) is SoftmaxMemory else type(policy) not in heedless
    orders = list(permutations(panel)) if heeds else [panel]  # those whose order can matter, unknown ones among them
    courses = [_course(policy, world, order, MOST_STATES // len(orders)) for order in orders]
    return Propagation(solved=tuple(np.minimum(np.mean(courses, axis=0), 1.0).tolist()))  # for rounding errors


def _course(policy: Policy[Any], world: World, order: tuple[int, ...], most: int) -> list[float]:
    """The probability that the box is solved by step 0, 1, ... where its joints are listed in this order.

    Configurations and what is told have a bit for each joint, in the order of the listing.
    """
    flip, space, joints, minds = world.flip, world.space, world.space.joints, Minds(policy, world)
    listing, every = np.array(order), np.arange(2**world.space.joints)
    panel = (every[:, None] >> np.arange(joints) & 1) @ (1 << listing)  # each configuration in the order of the panel
    may_move, start = space.may_move[panel][:, listing], int(np.flatnonzero(panel == space.start)[0])
    lasts = world.states_only or (world.tell == "both" and (flip.keep > 0 or flip.inverts == "outcome"))
    now, told, mind, mass = np.array([start]), np.array([start]), minds.begin(listing[None]), np.ones(1, np.float64)
    course = [0.0]
    for step in range(1, world.budget + 1):
        chances = minds.chances(mind)
        rows, places = np.nonzero(chances)
        moved = may_move[now[rows], places]
        mass = mass[rows] * chances[rows, places]
        opens = moved & (listing[places] == space.target)
        course.append(course[-1] + float(mass[opens].sum()))
        rows, places, moved, mass = rows[~opens], places[~opens], moved[~opens], mass[~opens]
        bits, last = 1 << places, told[rows]
        now, mind = now[rows] ^ moved * bits, mind[rows]
        rate = flip.p * flip.falls_on(step)
        lie = rate * (moved == (flip.only == "moved")) if flip.only != "any" else np.full(len(rows), rate)
        survives = rate if flip.others == "noisy" else flip.keep
        states, masses = np.empty(0, np.int64), np.empty(0, np.float64)
        for drawn in product((0.0, 1.0), repeat=flip.numbers(joints)):  # the least number and one that hits nothing
            share = (1 - lie if drawn[0] else lie) * prod(1 - survives if one else survives for one in drawn[1:])
            at = np.flatnonzero(share)
            outcome, shown = flip.report(now[at], last[at], bits[at], moved[at], drawn)
            said = (shown ^ last[at]) & bits[at] != 0 if world.states_only else outcome
            after = minds.remember(mind[at], places[at], said, shown ^ start)
            goals = (after << joints | now[at]) << joints | (shown if lasts else now[at])
            states, which = np.unique(np.concatenate([states, goals]), return_inverse=True)
            masses = np.asarray(np.bincount(which, np.concatenate([masses, mass[at] * share[at]])))
            if len(states) > most:
                raise BadValue(
                    f"states of {type(policy).__name__} on {world.box.name}",
                    f"more than {most}",
                    "fewer to follow: a smaller budget or flip rate 0; or sample it (lockprobe.population)",
                )
        mass = masses
        now, told, mind = states >> joints & every[-1], states & every[-1], states >> 2 * joints
    return course

"""Exact results of a policy's trials: propagates probabilities and draws no random numbers.

A trial of a policy is a Markov chain over (true configuration, reported configuration, memory). If the memory has few
values, the probability of every state after every step can be computed, and from it the success rate in the limit of
infinitely many trials. Larger state spaces are sampled by :mod:`lockprobe.simulation.population`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations
from math import nan
from pathlib import Path
from typing import Any, Literal, get_args

from lockprobe.agents.cognitive import LoopBreaker, RandomMap, SoftmaxMemory
from lockprobe.agents.human_inspired import HumanInspired
from lockprobe.agents.ideal_observer import IdealObserver
from lockprobe.agents.policy import Policy
from lockprobe.agents.strategies import RandomAgent, RandomNoRepeat
from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.families import DEFAULT_BOX
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.validation import check_choice, check_whole
from lockprobe.interventions.flip import DEFAULT, FlipKind
from lockprobe.simulation.exact.condition_chances import ConditionChances, condition_chances
from lockprobe.simulation.exact.markov_chain import MarkovChain
from lockprobe.simulation.kernel import LONGEST, World, policy_of, world_of
from lockprobe.trial.protocols import Intervention

Listing = Literal["shuffled", "panel"]
"""The order in which joints are listed to the agent: drawn anew for every trial, or along the panel."""

MOST_STATES = 200_000
"""This many states take about twenty seconds."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Propagation:
    """Exact results of a trial.

    Attributes:
        solved: Probability that the box is solved by step 0, 1, ..., shape (budget + 1,).
        apart: Probability that the reported configuration is not the true one after step 0, 1, ..., given that the
            trial goes on, shape (budget + 1,); 0 if no trial goes on. None where positions are not told.
        false_outcomes: Share of all reports whose outcome, told or inferred by comparing two reports, is the opposite
            of the true one, [0, 1]. Only reports that are given in trials that go on count; NaN if none is.
        states: Number of states met, over all listings. A state counts once for each phase of the condition.
    """

    solved: tuple[float, ...]
    apart: tuple[float, ...] | None
    false_outcomes: float
    states: int

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
        return next((step for step, solved in enumerate(self.solved) if solved > share - ROUNDING), None)


ROUNDING = 1e-9
"""Tolerance for rounding errors in sums of probabilities."""


def propagate(
    agent: str | Policy[Any] = "human-inspired",
    box: str | Path | Lockbox = DEFAULT_BOX,
    *,
    p: float = 0.0,
    flip: FlipKind = DEFAULT,
    condition: str | Sequence[Intervention] = "",
    modality: str | None = None,
    max_steps: int = 20,
    listing: Listing = "shuffled",
    most_states: int = MOST_STATES,
) -> Propagation:
    """The exact success of one agent on one box, step by step.

    Args:
        agent: Spec of an agent that is a policy, or a policy.
        box: Name of a box, path of a TOML file, or a box.
        p: Flip probability, [0, 1].
        flip: What a false report is.
        condition: Further interventions: ``flip`` with every option except ``while``, ``drop``, ``tremble``, ``force``,
            ``correction``, ``phantom`` without flips, and everything asked, which few policies heed.
            Several flips at different steps make a flip rate that changes: ``flip?p=0.4&until=7 + flip?p=1&at=8``.
        modality: How the box is shown: ``symbolic?tell=state`` (positions only; policies compare them, as they do with
            pictures that they see well), ``symbolic`` (outcomes too) or ``symbolic?tell=outcome`` (no positions). The
            default is that of studies.
        max_steps: Budget in steps.
        listing: ``shuffled`` averages over all orders of the listing, where the order matters.
        most_states: Largest number of states.

    Raises:
        UserMistake: If a name does not exist, a value is out of range, an intervention is not supported, or there are
            more states.

    >>> course = propagate("human-inspired")
    >>> round(course.steps, 9), course.by(0.8), course.by(1)
    (8.5, 9, 10)
    """
    check_whole("max_steps", max_steps, 1, LONGEST)
    check_whole("most_states", most_states, 1)
    chances = condition_chances(condition, p, flip, modality, budget=max_steps)
    policy, world = policy_of(agent), world_of(box, flip=chances.flip, max_steps=max_steps, tell=chances.tell)
    if chances.asks and policy.heeds_remarks:
        expected = "distract alone of what is asked, for an agent that heeds remarks; sample it (lockprobe.run_trial)"
        raise BadValue("condition", condition, expected)
    check_choice("listing", listing, get_args(Listing))
    panel = tuple(range(len(world.places)))
    orders = list(permutations(panel)) if listing == "shuffled" and heeds_order(policy) else [panel]
    return _course(policy, world, chances, orders, most_states)


def _course(
    policy: Policy[Any],
    world: World,
    chances: ConditionChances,
    orders: Sequence[tuple[int, ...]],
    most_states: int,
) -> Propagation:
    """The mean course over orders of the listing."""
    solved, apart, states = [0.0] * (world.budget + 1), [0.0] * (world.budget + 1), 0
    given = false = 0.0
    for order in orders:
        chain = MarkovChain(policy, world, chances, order, most_states - states)
        for step, (done, differs) in enumerate(chain.run()):
            solved[step] += done / len(orders)
            apart[step] += differs / len(orders)
        given, false = given + chain.given, false + chain.false
        states += len(chain.onward)
    shares = tuple(part / (1 - done) if 1 - done > ROUNDING else 0.0 for part, done in zip(apart, solved, strict=True))
    return Propagation(
        solved=tuple(solved),
        apart=None if world.tell == "outcome" else shares,
        false_outcomes=false / given if given else nan,
        states=states,
    )


def heeds_order(policy: Policy[Any]) -> bool:
    """Whether the order of the listing can matter to a policy; True for unknown policies."""
    if type(policy) is SoftmaxMemory:
        return policy.position != 0
    return type(policy) not in _HEEDLESS


_HEEDLESS = (RandomAgent, RandomNoRepeat, HumanInspired, RandomMap, IdealObserver, LoopBreaker)
"""Policies to which the order of the listing does not matter."""

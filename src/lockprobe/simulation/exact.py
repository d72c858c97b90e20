"""Exact results of a policy's trials: propagates probabilities and draws no random numbers.

A trial of a policy is a Markov chain. A state is the true configuration, the joints whose reported positions are false,
and the policy's memory. False positions may be kept until the joint is attempted again (``others=kept``), kept with a
chance, or drawn anew. If the memory has few values, the probability of every state after every step can be computed,
and from it the success rate in the limit of infinitely many trials. Larger state spaces are sampled by
:mod:`lockprobe.simulation.kernel`, conditions of other interventions by :func:`lockprobe.run_trial`.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass
from itertools import permutations
from pathlib import Path
from typing import Any, NamedTuple

from lockprobe.agents.ideal_observer import IdealObserver
from lockprobe.agents.policy import Policy, Told
from lockprobe.agents.strategies import (
    HumanInspired,
    LoopBreaker,
    RandomAgent,
    RandomNoRepeat,
    SoftmaxMemory,
)
from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.families import DEFAULT_BOX
from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.flip import DEFAULT, FlipKind, OutcomeFlip
from lockprobe.simulation.kernel import World, policy_of, world_of

MOST_STATES = 200_000
"""This many states take about twenty seconds."""

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
    solved = [0.0] * (world.budget + 1)
    for order in orders:
        for step, done in enumerate(_MarkovChain(policy, world, order, MOST_STATES // len(orders)).run()):
            solved[step] += done / len(orders)
    return Propagation(solved=tuple(solved))


class _State(NamedTuple):
    """A state of the Markov chain; a configuration has bit j for joint j in panel order, 1 if away from the start."""

    configuration: int
    wrong: int  # the joints told falsely, as far as the next report heeds them
    compared: int  # what the next report is compared with where states alone are told, else 0
    memory: Hashable


class _MarkovChain:
    """The Markov chain of one policy under one order of the listing: its states and transition probabilities.

    Attributes:
        onward: What can follow each state met, at the rate of the flip at the step: the probability that the next step
            solves the box, and those of the next states.
    """

    def __init__(self, policy: Policy[Any], world: World, order: tuple[int, ...], most_states: int) -> None:
        self.onward: dict[tuple[_State, float], tuple[float, Mapping[_State, float]]] = {}
        self._policy, self._world, self._order, self._most = policy, world, order, most_states
        self._view, self._space = world.view(order), world.space
        self._may_move = world.space.may_move.tolist()

    def run(self) -> Iterator[float]:
        """The probability that the box is solved after step 0, 1, ..."""
        solved, running = 0.0, {_State(0, 0, 0, self._policy.begin(self._view)): 1.0}
        yield solved
        for step in range(1, self._world.budget + 1):
            after: dict[_State, float] = defaultdict(float)
            rate = self._world.flip.p * self._world.flip.falls_on(step)
            for state, mass in running.items():
                opens, goals = self._follow(state, rate)
                solved += mass * opens
                for goal, chance in goals.items():
                    after[goal] += mass * chance
            running = after
            yield solved

    def _follow(self, state: _State, rate: float) -> tuple[float, Mapping[_State, float]]:
        """What can follow a state if the next report is inverted at this rate."""
        if (found := self.onward.get((state, rate))) is not None:
            return found
        if len(self.onward) >= self._most:
            raise BadValue(
                f"states of {type(self._policy).__name__} on {self._world.box.name}",
                f"more than {self._most}",
                "fewer to follow: a smaller budget or flip rate 0; or sample it (lockprobe.population)",
            )
        flip, opens, goals = self._world.flip, 0.0, dict[_State, float]()
        for place, chance in enumerate(self._policy.chances(self._view, state.memory)):
            joint = self._order[place]
            moved = self._may_move[state.configuration ^ self._space.start][joint]
            if not chance or (moved and joint == self._space.target):
                opens += chance
                continue
            lie = rate if flip.only in ("any", "moved" if moved else "blocked") else 0.0
            for inverted, share in ((True, lie), (False, 1 - lie)):
                for others, part in self._others(state.wrong, joint, rate) if share else ():
                    goal = self._told(state, place, others, moved=moved, inverted=inverted)
                    goals[goal] = goals.get(goal, 0.0) + chance * share * part
        self.onward[state, rate] = opens, goals
        return opens, goals

    def _others(self, wrong: int, joint: int, rate: float) -> list[tuple[int, float]]:
        """The joints besides the attempted one whose positions a report tells falsely, and how probably.

        ``wrong`` are the joints that were told falsely before.
        """
        chance, possible = self._world.flip.keep, wrong
        if self._world.flip.others == "noisy":
            chance, possible = rate, -1
        found = [(0, 1.0)]
        for bit in (1 << other for other in self._order if other != joint and self._world.tell != "outcome"):
            ways = ((bit, chance), (0, 1 - chance)) if possible & bit else ((0, 1.0),)
            found = [(told | false, share * part) for told, share in found for false, part in ways if part]
        return found

    def _told(self, state: _State, place: int, others: int, *, moved: bool, inverted: bool) -> _State:
        """The state after a report on the attempt at a place of the listing."""
        world, flip, positions = self._world, self._world.flip, self._world.tell != "outcome"
        bit = 1 << self._order[place]
        told = configuration = state.configuration ^ moved * bit
        if positions:
            last = (configuration ^ others) & ~bit | (state.configuration ^ state.wrong) & bit
            lasting = others if flip.others == "noisy" else -1
            told = flip.positions(configuration, last, bit, moved=moved, flipped=inverted, lasting=lasting)
        said = moved != (inverted and flip.part != "position")
        if world.states_only:
            said = (told ^ state.compared) & bit != 0
        shifted = sum((told >> joint & 1) << at for at, joint in enumerate(self._order))
        report = Told(joint=place, moved=said, shifted=shifted if positions else None, states_only=world.states_only)
        wrong = told ^ configuration if flip.keep or flip.inverts == "outcome" else 0
        memory = self._policy.remember(self._view, state.memory, report)
        return _State(configuration, wrong, told if world.states_only else 0, memory)

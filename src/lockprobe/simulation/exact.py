"""Exact results of a policy's trials: propagates probabilities and draws no random numbers.

A trial of a policy is a Markov chain. A state is the true configuration, the joints whose reported positions are false,
and the policy's memory. False positions may be kept until the joint is attempted again (``others=kept``), kept with a
chance, or drawn anew. If the memory has few values, the probability of every state after every step can be computed,
and from it the success rate in the limit of infinitely many trials. Larger state spaces are sampled by
:mod:`lockprobe.simulation.population`, conditions of other interventions by :func:`lockprobe.run_trial`.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import permutations
from math import nan
from pathlib import Path
from typing import Any, Literal, NamedTuple, get_args

from lockprobe.agents.cognitive import LoopBreaker, RandomMap, SoftmaxMemory
from lockprobe.agents.human_inspired import HumanInspired
from lockprobe.agents.ideal_observer import IdealObserver
from lockprobe.agents.policy import Policy, Told
from lockprobe.agents.strategies import RandomAgent, RandomNoRepeat
from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.families import DEFAULT_BOX
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.validation import check_choice, check_whole
from lockprobe.interventions.flip import DEFAULT, FlipKind, OutcomeFlip, flip_of
from lockprobe.simulation.kernel import LONGEST, World, policy_of, what_is_told, world_of

Listing = Literal["shuffled", "panel"]
"""The order in which joints are listed to the agent: drawn anew for every trial, or along the panel."""

MOST_STATES = 200_000
"""This many states take about twenty seconds."""

_ROUNDING = 1e-9
"""Tolerance for rounding errors in sums of probabilities."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Propagation:
    """Exact results of a trial.

    Attributes:
        solved: Probability that the box is solved by step 0, 1, ..., shape (budget + 1,).
        apart: Probability that the reported configuration is not the true one after step 0, 1, ..., given that the
            trial goes on, shape (budget + 1,); 0 if no trial goes on. None where positions are not told.
        false_outcomes: Share of all reports whose outcome, told or inferred by comparing two reports, is the opposite
            of the true one, [0, 1]. Only reports in trials that go on count; NaN if there is none.
        states: Number of states met, over all listings. A state counts twice if the flip leaves some steps out.
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
        return next((step for step, solved in enumerate(self.solved) if solved > share - _ROUNDING), None)


def propagate(
    agent: str | Policy[Any] = "human-inspired",
    box: str | Path | Lockbox = DEFAULT_BOX,
    *,
    p: float = 0.0,
    flip: FlipKind | OutcomeFlip = DEFAULT,
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
        flip: What a false report is: a word, or a flip with any option but ``while``, whose rate does not count.
        modality: How the box is shown: ``symbolic?tell=state`` (positions only; policies compare them, as they do with
            pictures that they see well), ``symbolic`` (outcomes too) or ``symbolic?tell=outcome`` (no positions). The
            default is that of studies.
        max_steps: Budget in steps.
        listing: ``shuffled`` averages over all orders of the listing, where the order matters.
        most_states: Largest number of states.

    >>> course = propagate("human-inspired")
    >>> round(course.steps, 9), course.by(0.8), course.by(1)
    (8.5, 9, 10)
    """
    check_whole("max_steps", max_steps, 1, LONGEST)
    check_whole("most_states", most_states, 1)
    check_choice("listing", listing, get_args(Listing))
    acting = replace(flip, p=p) if isinstance(flip, OutcomeFlip) else flip_of(flip, p)
    if acting.while_ != "always":
        raise BadValue("flip", "while=looping", "none with while, which has to be sampled (lockprobe.run_trial)")
    tell = what_is_told(modality, "memoryless" if isinstance(flip, OutcomeFlip) else flip)
    policy, world = policy_of(agent), world_of(box, flip=acting, max_steps=max_steps, tell=tell)
    panel = tuple(range(world.space.joints))
    orders = list(permutations(panel)) if listing == "shuffled" and heeds_order(policy) else [panel]
    solved, apart, states = [0.0] * (world.budget + 1), [0.0] * (world.budget + 1), 0
    given = false = 0.0
    for order in orders:
        chain = _MarkovChain(policy, world, order, most_states - states)
        for step, (done, differs) in enumerate(chain.run()):
            solved[step] += done / len(orders)
            apart[step] += differs / len(orders)
        given, false, states = given + chain.given, false + chain.false, states + len(chain.onward)
    shares = tuple(part / (1 - done) if 1 - done > _ROUNDING else 0.0 for part, done in zip(apart, solved, strict=True))
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


class _State(NamedTuple):
    """A state of the Markov chain; a configuration has bit j for joint j in panel order, 1 if away from the start."""

    configuration: int
    wrong: int  # the joints told falsely, as far as the next report heeds them
    compared: int  # what the next report is compared with where states alone are told, else 0
    memory: Hashable


class _Onward(NamedTuple):
    """All that can follow a state: the next states by number, and the probability that the next step ...

    ... solves the box, reports wrong positions, or reports a false outcome.
    """

    goals: tuple[tuple[int, float], ...]
    solved: float
    apart: float
    false: float


class _MarkovChain:
    """The Markov chain of one policy under one order of the listing: its states and transition probabilities.

    Attributes:
        onward: What can follow each state met, by its number, and whether the flip falls on the step.
        given: Expected number of reports, after a run.
        false: Expected number of reports whose outcome is false.
    """

    def __init__(self, policy: Policy[Any], world: World, order: tuple[int, ...], most_states: int) -> None:
        self.onward: dict[tuple[int, bool], _Onward] = {}
        self.given = self.false = 0.0
        self._numbers: dict[_State, int] = {}  # states are compared once and then known by number
        self._states: list[_State] = []
        self._policy, self._world, self._order, self._most = policy, world, order, most_states
        self._view, self._space = world.view(order), world.space
        self._may_move = world.space.may_move.tolist()

    def run(self) -> Iterator[tuple[float, float]]:
        """After step 0, 1, ...: P(solved), and P(not solved, and the reported positions are wrong)."""
        solved, running = 0.0, {self._number(_State(0, 0, 0, self._policy.begin(self._view))): 1.0}
        yield solved, 0.0
        for step in range(1, self._world.budget + 1):
            after: dict[int, float] = defaultdict(float)
            apart, falls = 0.0, self._world.flip.falls_on(step)
            for state, mass in running.items():
                onward = self._follow(state, falls=falls)
                solved += mass * onward.solved
                apart += mass * onward.apart
                self.given += mass * (1 - onward.solved)
                self.false += mass * onward.false
                for goal, chance in onward.goals:
                    after[goal] += mass * chance
            running = after
            yield solved, apart

    def _number(self, state: _State) -> int:
        number = self._numbers.setdefault(state, len(self._states))
        if number == len(self._states):
            self._states.append(state)
        return number

    def _follow(self, state: int, *, falls: bool) -> _Onward:
        """What can follow a state; ``falls`` says whether the flip can invert the next report."""
        if (state, falls) not in self.onward:
            if len(self.onward) >= self._most:
                raise BadValue(
                    f"states of {type(self._policy).__name__} on {self._world.box.name}",
                    f"more than {self._most}",
                    "fewer to follow: a smaller budget or flip rate 0; or sample it (lockprobe.population)",
                )
            goals: dict[int, float] = defaultdict(float)
            solved = apart = false = 0.0
            for goal, chance, wrong, untrue in self._expand(self._states[state], falls=falls):
                if goal is None:
                    solved += chance
                    continue
                goals[self._number(goal)] += chance
                apart += chance * wrong
                false += chance * untrue
            self.onward[state, falls] = _Onward(tuple(goals.items()), solved, apart, false)
        return self.onward[state, falls]

    def _expand(self, state: _State, *, falls: bool) -> Iterator[tuple[_State | None, float, bool, bool]]:
        """The next states (None if the box is solved) with their probabilities.

        With each, whether its report tells wrong positions, and whether it tells a false outcome.
        """
        world, flip = self._world, self._world.flip
        for place, chance in enumerate(self._policy.probabilities(self._view, state.memory)):
            joint = self._order[place]
            moved = self._may_move[state.configuration ^ self._space.start][joint]
            if not chance or (moved and joint == self._space.target):
                if chance:
                    yield None, chance, False, False
                continue
            configuration = state.configuration ^ moved << joint
            lie = flip.p if falls and flip.only in ("any", "moved" if moved else "blocked") else 0.0
            for inverted, share in ((True, lie), (False, 1 - lie)):
                for others, part in self._others(state.wrong, joint, falls=falls) if share else ():
                    told, wrong = self._told(state, configuration, place, moved, others, inverted=inverted)
                    memory = self._policy.remember(self._view, state.memory, told)
                    heeded = wrong if flip.keep or flip.inverts == "outcome" else 0
                    goal = _State(configuration, heeded, configuration ^ wrong if world.states_only else 0, memory)
                    yield goal, chance * share * part, wrong != 0, told.moved != moved

    def _others(self, wrong: int, joint: int, *, falls: bool) -> list[tuple[int, float]]:
        """The joints besides the attempted one whose positions a report tells falsely, and how probably.

        ``wrong`` are the joints that were told falsely before.
        """
        flip, others = self._world.flip, [other for other in self._order if other != joint]
        if self._world.tell == "outcome":
            return [(0, 1.0)]
        if flip.others == "noisy":
            chance, possible = flip.p * falls, others
        else:
            chance, possible = flip.keep, [other for other in others if wrong >> other & 1]
        if chance in (0, 1):
            return [(sum(1 << other for other in possible) if chance else 0, 1.0)]
        found = [(0, 1.0)]
        for bit in (1 << other for other in possible):
            found = [
                one for told, share in found for one in ((told | bit, share * chance), (told, share * (1 - chance)))
            ]
        return found

    def _told(
        self, state: _State, configuration: int, place: int, moved: bool, others: int, *, inverted: bool
    ) -> tuple[Told, int]:
        """A report on an attempt, and the joints whose positions it tells falsely."""
        flip, states_only, positions = self._world.flip, self._world.states_only, self._world.tell != "outcome"
        told, bit = configuration, 1 << self._order[place]
        if positions:
            last = (configuration ^ others) & ~bit | (state.configuration ^ state.wrong) & bit
            lasting = others if flip.others == "noisy" else -1
            told = flip.positions(configuration, last, bit, moved=moved, flipped=inverted, lasting=lasting)
        heard = moved != (inverted and flip.part != "position")
        said = bool((told ^ state.compared) >> self._order[place] & 1) if states_only else heard
        shifted = _listed(told, self._order) if positions else None
        return Told(joint=place, moved=said, shifted=shifted, states_only=states_only), told ^ configuration


@lru_cache(maxsize=4096)
def _listed(configuration: int, order: tuple[int, ...]) -> int:
    """A configuration with its bits in the order of the listing."""
    return sum((configuration >> joint & 1) << place for place, joint in enumerate(order))

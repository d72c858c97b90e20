"""Exact results of a policy's trials: propagates probabilities and draws no random numbers.

A trial of a policy is a Markov chain. A state is the true configuration, the joints whose reported positions are false,
and the policy's memory. False positions may be kept until the joint is attempted again (``others=kept``), kept with a
chance, or drawn anew. If the memory has few values, the probability of every state after every step can be computed,
and from it the success rate in the limit of infinitely many trials. Larger state spaces are sampled by
:mod:`lockprobe.simulation.population`.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
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
from lockprobe.interventions.flip import DEFAULT, FlipKind
from lockprobe.simulation.condition_chances import ConditionChances, Report, condition_chances
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
    solved, apart, states = [0.0] * (world.budget + 1), [0.0] * (world.budget + 1), 0
    given = false = 0.0
    for order in orders:
        chain = _MarkovChain(policy, world, chances, order, most_states - states)
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


class TooManyStates(BadValue):
    """A policy has more states than can be followed; it can be sampled."""


class _State(NamedTuple):
    """A state of the Markov chain; a configuration has bit j for joint j in panel order, 1 if away from the start."""

    configuration: int
    wrong: int  # the joints told falsely, as far as the next report heeds them; none where the last one told nothing
    compared: int  # what the next report is compared with where states alone are told, else 0
    memory: Hashable


class _Transition(NamedTuple):
    """A transition: next state (None if the box is solved), probability, and what its report is.

    That is whether it reports wrong positions, and whether its outcome is false (None: there is no report).
    """

    goal: _State | None
    chance: float
    wrong: bool = False
    false: bool | None = None


class _Onward(NamedTuple):
    """All that can follow a state: the next states by number, and the probability that the next step ...

    ... solves the box, reports wrong positions, reports anything, or reports a false outcome.
    """

    goals: tuple[tuple[int, float], ...]
    solved: float
    apart: float
    given: float
    false: float


class _MarkovChain:
    """The Markov chain of one policy under one order of the listing: its states and transition probabilities.

    Attributes:
        onward: What can follow each state met, by phase of the condition and number of the state.
        given: Expected number of reports, after a run.
        false: Expected number of reports whose outcome is false.
    """

    def __init__(
        self, policy: Policy[Any], world: World, chances: ConditionChances, order: tuple[int, ...], most_states: int
    ) -> None:
        self.onward: dict[tuple[int, int], _Onward] = {}
        self.given = self.false = 0.0
        self._phases: dict[Hashable, int] = {}  # phases of the condition, by number
        self._reports: dict[tuple[int, bool], list[Report]] = {}
        self._numbers: dict[_State, int] = {}  # states are compared once and then known by number
        self._states: list[_State] = []
        self._policy = policy
        self._world = world
        self._condition = chances
        self._order = order
        self._view = world.view(order)
        self._may_move = world.may_move.tolist()
        self._most = most_states

    def run(self) -> Iterator[tuple[float, float]]:
        """After step 0, 1, ...: P(solved), and P(not solved, and the reported positions are wrong)."""
        solved, running = 0.0, {self._number(_State(0, 0, 0, self._policy.begin(self._view))): 1.0}
        yield solved, 0.0
        for step in range(1, self._world.budget + 1):
            after: dict[int, float] = defaultdict(float)
            apart, phase = 0.0, self._phases.setdefault(self._condition.phase(step), len(self._phases))
            for state, mass in running.items():
                onward = self._follow(state, step, phase)
                solved += mass * onward.solved
                apart += mass * onward.apart
                self.given += mass * onward.given
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

    def _follow(self, state: int, step: int, phase: int) -> _Onward:
        """What can follow a state; computed once per phase."""
        at = (phase, state)
        if at not in self.onward:
            if len(self.onward) >= self._most:
                raise TooManyStates(
                    f"states of {type(self._policy).__name__} on {self._world.name}",
                    f"more than {self._most}",
                    "fewer to follow: a smaller budget or flip rate 0; or sample it (lockprobe.population)",
                )
            goals: dict[int, float] = defaultdict(float)
            solved = apart = told = untrue = 0.0
            for goal, chance, wrong, false in self._expand(self._states[state], step, phase):
                if goal is None:
                    solved += chance
                    continue
                goals[self._number(goal)] += chance
                apart += chance * wrong
                told += chance * (false is not None)
                untrue += chance * bool(false)
            self.onward[at] = _Onward(tuple(goals.items()), solved, apart, told, untrue)
        return self.onward[at]

    def _expand(self, state: _State, step: int, phase: int) -> Iterator[_Transition]:
        world = self._world
        chosen = self._policy.probabilities(self._view, state.memory)
        for place, chance in enumerate(self._condition.attempted(chosen, step)):
            if not chance:
                continue
            joint = self._order[place]
            moved = self._may_move[state.configuration ^ world.start][joint]
            if moved and joint == world.target:
                yield _Transition(None, chance)
                continue
            configuration = state.configuration ^ moved << joint
            if (phase, moved) not in self._reports:
                self._reports[phase, moved] = self._condition.reports(step, moved=moved)
            for report in self._reports[phase, moved]:
                for others, share in self._others(state.wrong, joint, report, self._condition.noise(step)):
                    told = chance * report.chance * share
                    yield self._after_report(state, configuration, place, moved, report, others, told)

    def _others(self, wrong: int, joint: int, report: Report, noise: float) -> list[tuple[int, float]]:
        """The joints besides the attempted one whose positions a report tells falsely, and how probably.

        Args:
            wrong: The joints that were told falsely before.
            joint: The joint attempted.
            report: The report.
            noise: The probability that it inverts the position of another joint.
        """
        if report.inverted is None or self._world.tell == "outcome":
            return [(0, 1.0)]
        others = [other for other in self._order if other != joint]
        if report.phantom and others:
            return [(1 << other, 1 / len(others)) for other in others]
        keep = self._world.flip.keep
        chance, possible = (noise, others) if noise else (keep, [other for other in others if wrong >> other & 1])
        if chance in (0, 1):
            return [(sum(1 << other for other in possible) if chance else 0, 1.0)]
        found = [(0, 1.0)]
        for bit in (1 << other for other in possible):
            found = [
                one for told, share in found for one in ((told | bit, share * chance), (told, share * (1 - chance)))
            ]
        return found

    def _after_report(
        self, state: _State, configuration: int, place: int, moved: bool, given: Report, others: int, chance: float
    ) -> _Transition:
        """The transition after a report, with its probability."""
        flip = self._world.flip
        if given.inverted is None:
            memory = self._policy.remember_silence(self._view, state.memory, place)
            return _Transition(_State(configuration, 0, state.compared, memory), chance)
        say = partial(self._statement, state, configuration, place, moved, others)
        report, wrong = say(inverted=given.inverted)
        first = None if given.corrects is None else say(inverted=given.corrects)[0]
        report = replace(report, corrects=first, remarked=given.remarked)
        memory = self._policy.remember(self._view, state.memory, report)
        heeded = wrong if flip.keep or flip.inverts == "outcome" else 0
        goal = _State(configuration, heeded, configuration ^ wrong if self._world.states_only else 0, memory)
        return _Transition(goal, chance, wrong != 0, report.moved != moved)

    def _statement(
        self, state: _State, configuration: int, place: int, moved: bool, others: int, *, inverted: bool
    ) -> tuple[Told, int]:
        """One statement on an attempt, and the joints whose positions it tells falsely."""
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

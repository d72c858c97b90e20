"""The Markov chain of one policy's trials: states, and what follows each of them with which probability.

A state is the true configuration, the joints whose reported positions are false, and the policy's memory. False
positions may be kept until the joint is attempted again (``others=kept``), kept with a chance, or drawn anew.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Iterator
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any, NamedTuple

from lockprobe.agents.policy import Policy, Told
from lockprobe.foundation.errors import BadValue
from lockprobe.simulation.exact.condition_chances import ConditionChances, Report
from lockprobe.simulation.kernel import World


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


class MarkovChain:
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

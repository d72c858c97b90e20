"""Exact courses: against brute force over every choice and every flip, another program, and published figures."""

import itertools
from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest

from lockprobe.agents.strategies import (
    STRATEGIES,
    HumanInspired,
    RandomAgent,
    RandomNoRepeat,
    RoundRobin,
    SoftmaxMemory,
)
from lockprobe.boxes.families import box
from lockprobe.boxes.solve import random_curve
from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.words import TextChannel
from lockprobe.simulation import exact
from lockprobe.simulation.exact import propagate
from lockprobe.trial.record import Decision, Moment, Percept, Situation, Task, Turn


class Loaded:
    """A stream that gives this number."""

    def __init__(self, number):
        self.number = number

    def random(self, size):
        return np.full(size, self.number)


def branches(policy, puzzle, flip, tell, left, situation, past, configuration):
    """Every way on: its probability, and the step that solves the box (None: none)."""
    if not left:
        yield 1.0, None
        return
    task, known = situation.task, policy.recall(situation)
    for place, chosen in enumerate(policy.probabilities(known.view, known.memory)):
        label = task.joints[place]
        after, moved = puzzle.attempt(configuration, int(label))
        if chosen and moved and int(label) == puzzle.target_index:
            yield chosen, len(past)
        elif chosen:
            positions = tuple(after[int(label)] for label in task.joints)
            truth = Percept(joint=label, outcome="moved" if moved else "blocked", positions=positions)
            for stream, luck in ((Loaded(0.0), flip.p), (Loaded(1 - 2**-53), 1 - flip.p)):
                told = flip.perceive(truth, past, task, stream)
                turn = Turn(percept=situation.percept, decision=Decision(joint=label))
                read = TextChannel(tell=tell).perceive(told, past, task, stream)
                onward = Situation(task=task, past=(*situation.past, turn), percept=read)
                moments = (*past, Moment(was=truth, told=told, chosen=label, attempted=label))
                for share, end in branches(policy, puzzle, flip, tell, left - 1, onward, moments, after):
                    yield chosen * luck * share, end


def by_brute_force(policy, puzzle, flip, tell, budget, order):
    """The course where the joints are listed in this order; their labels are their places on the panel."""
    labels, places = tuple(map(str, order)), tuple(puzzle.joints[j].place for j in order)
    task = Task(joints=labels, target=str(puzzle.target_index), budget=budget, places=places)
    opening = Percept(positions=tuple(puzzle.initial[j] for j in order))
    solved = np.zeros(budget + 1)
    first = Percept() if tell == "outcome" else opening
    start, past = Situation(task=task, past=(), percept=first), (Moment(was=opening, told=opening),)
    for share, end in branches(policy, puzzle, flip, tell, budget, start, past, puzzle.initial):
        solved[end or budget + 1 :] += share
    return solved


FLIP = OutcomeFlip(p=0.3)
READINGS = [replace(FLIP, inverts=inverts, keep=keep) for inverts in ("position", "outcome") for keep in (0, 1)]
LEAVING_OUT = [
    replace(FLIP, only="moved"), replace(FLIP, only="blocked", keep=1), replace(FLIP, at=(2, 3)),
    replace(FLIP, at=(1, 3), keep=1),
]  # fmt: skip
PARTS = [
    replace(FLIP, part="outcome"),
    *(replace(FLIP, part="position", inverts=one) for one in ("position", "outcome")),
]
POLICIES = [
    RandomAgent(), RandomNoRepeat(), RoundRobin(), *(one for name, one in STRATEGIES.items() if name.startswith("human")),
    HumanInspired(lapse=0.3),
    SoftmaxMemory(target=0.4, closed=0.8, failure=2, decay=0.7, reset=0.4, recent=-0.6, stay=0.9, position=0.5),
]  # fmt: skip


TOLD = [
    *itertools.product([*READINGS, *LEAVING_OUT], ["both", "state"]), (READINGS[0], "outcome"),
    *((part, "both") for part in PARTS),
]  # fmt: skip


@pytest.mark.parametrize(("number", "flip", "tell"), [(number, *told) for number, told in enumerate(TOLD)])
def test_the_course_is_the_sum_over_every_choice_and_all_luck(number, flip, tell):
    """Each with a third of the policies, in turn."""
    for policy in POLICIES[number % 3 :: 3]:
        heedful = isinstance(policy, RoundRobin | SoftmaxMemory)
        orders = list(itertools.permutations(range(3))) if heedful else [(0, 1, 2)]
        solved = np.mean([by_brute_force(policy, box("chain-3"), flip, tell, 3, order) for order in orders], axis=0)
        course = propagate(policy, "chain-3", p=flip.p, flip=flip, modality=f"symbolic?tell={tell}", max_steps=3)
        assert course.solved == pytest.approx(solved, abs=1e-12)


@pytest.mark.parametrize("name", ["chain-4", "fork", "reset", "gray-code"])
def test_blind_agents_have_the_curves_of_the_box(name):
    """0.392655 for the uniform agent on chain-4, whatever it is told."""
    for agent, repeats in (("random", True), ("random-no-repeat", False)):
        course = propagate(agent, name, p=0.4, flip="sticky")
        assert course.solved == pytest.approx(random_curve(box(name), repeats=repeats), abs=1e-12)
    assert propagate("random").success == pytest.approx(0.392655, abs=5e-7)


class OneWithoutMemory:
    facts = MappingProxyType({})

    async def decide(self, situation, rng):
        return Decision(joint=situation.task.joints[0])


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"agent": "cognitive:loop-breaker"}, "states of LoopBreaker on chain-4: got 'more than 50'"),
        ({"max_steps": 0}, "max_steps: got 0, expected a whole number from 1 to 10000"),
        ({"p": 2}, "p: got 2"),
        ({"agent": OneWithoutMemory()}, "agent: got <"),
        ({"flip": OutcomeFlip(while_="looping")}, "flip: got 'while=looping', expected none with while"),
        ({"modality": "rgb"}, "modality: got 'rgb'"),
        ({"modality": "symbolic?tell=state", "flip": "outcome-only"}, "flip: got 'outcome-only'"),
        ({"modality": "symbolic?source=camera"}, "modality: got 'symbolic?source=camera', expected symbolic without"),
    ],
)
def test_what_cannot_be_followed_is_refused_in_one_line(monkeypatch, asked, said):
    monkeypatch.setattr(exact, "MOST_STATES", 50)
    with pytest.raises(BadValue) as refused:
        propagate(**asked)
    assert str(refused.value).startswith(said)

"""The contracts hold for ours and find who breaks them; the builders do as they are told."""

import random
from dataclasses import dataclass, replace
from itertools import count, cycle
from types import MappingProxyType

import pytest

from lockprobe.agents.strategies import RandomAgent
from lockprobe.boxes.families import STRUCTURES, box
from lockprobe.foundation.errors import BadValue, UserMistake
from lockprobe.interventions.asked_and_done import Tremble
from lockprobe.interventions.conditions import interventions_of
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.testing import (
    ScriptedAgent,
    check_agent,
    check_box,
    check_intervention,
    check_measure,
    check_plant,
    make_trial,
)
from lockprobe.trial.record import Decision
from lockprobe.trial.trial_json import trial_from_json, trial_to_json


@pytest.mark.parametrize("agent", ["human-inspired", ScriptedAgent(joints=(0, 2))])
def test_agents_that_keep_it(agent):
    check_agent(agent, boxes=["chain-4"])


class Agent(RandomAgent):
    facts = MappingProxyType({})


class Counts(Agent):
    """Takes another joint whenever it is asked."""

    asked = 0

    async def decide(self, situation, rng):
        self.asked += 1
        return Decision(joint=situation.task.joints[self.asked % 4])


class Forgets(Agent):
    """Keeps the trial in itself, and begins anew with the first look: one by one nobody can tell."""

    async def decide(self, situation, rng):
        if not situation.past:
            self.told = []
        self.told.append(situation.percept.outcome)
        return Decision(joint=situation.task.joints[self.told.count("moved") % 4])


class Elsewhere(Agent):
    """Draws from a stream of its own."""

    async def decide(self, situation, rng):
        return Decision(joint=random.choice(situation.task.joints))


class Unlisted(Agent):
    async def decide(self, situation, rng):
        return Decision(joint="Z")


class Odd(Agent):
    facts = MappingProxyType({"path": {"a": 1}})


class Breaks(Agent):
    async def decide(self, situation, rng):
        raise KeyError("no such thing")


@pytest.mark.parametrize(
    ("agent", "said"),
    [
        (Counts(), "plays the same trial differently again"),
        (Elsewhere(), "plays the same trial differently again"),
        (Forgets(), "keeps something between calls"),
        (Unlisted(), "its decision: got 'Z'"),
        (Odd(), "a fact of Odd is no text"),
        (Breaks(), r"a trial of Breaks broke: in the agent \(test_testing.py, line \d+\): KeyError: 'no such thing'"),
        (object(), "has no `facts` or no `decide`"),
    ],
)
def test_agents_that_break_it(agent, said):
    with pytest.raises(AssertionError, match=said):
        check_agent(agent, boxes=["chain-4"])


CHAIN = box("chain-4")
NUMBERS, TURNS = count(2), cycle(("chain-3", "chain-4"))
KNOT = {"revolute-left": ({"slider-1": True},), "slider-1": ({"revolute-left": True},)}


@pytest.mark.parametrize("name", [*[*STRUCTURES][::9], "random-5-17"])
def test_boxes_that_keep_it(name):
    check_box(name)
    check_box(box(name))
    check_box(lambda: box(name))


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (replace(CHAIN, interlock=KNOT), "unsolvable"),
        (replace(CHAIN, name="a box"), "cannot be written down: .*expected a name"),
        (lambda: box(next(TURNS)), "is another box when it is asked for again"),
        (lambda: "chain-4", "'chain-4' is no Lockbox"),
        (
            replace(CHAIN, joints=tuple(replace(j, place=(1, i)) for i, j in enumerate(CHAIN.joints))),
            "cannot be written down",
        ),
    ],
)
def test_boxes_that_break_it(asked, said):
    with pytest.raises(AssertionError, match=said):
        check_box(asked)


@dataclass(frozen=True, kw_only=True)
class OutcomeAlone:
    """Says that everything moves, and leaves positions as they are."""

    def perceive(self, percept, past, task, rng):
        return percept if percept.joint is None else replace(percept, outcome="moved")


@dataclass(frozen=True, kw_only=True)
class TextBefore:
    """Says something before the words are made."""

    def perceive(self, percept, past, task, rng):
        return replace(percept, text="Well.")


@dataclass(frozen=True, kw_only=True)
class Unreliable:
    """Declares that it leaves no report out, and does."""

    always_tells = True

    def perceive(self, percept, past, task, rng):
        return percept if percept.joint is None else replace(percept, joint=None, outcome=None, positions=None)


SEEN: list[str] = []


@dataclass(frozen=True)
class Keeps:
    """Keeps something between calls."""

    def act(self, joint, past, task, rng):
        SEEN.append(joint)
        return task.joints[len(SEEN) % len(task.joints)]


@dataclass(frozen=True)
class Always:
    """Acts at dose 0."""

    doses = ("p",)
    p: float = 0.0

    def act(self, joint, past, task, rng):
        return task.joints[0]


UNSEEN = "and no report in symbolic.tell=state shows that: .* shows joint and pos"


@pytest.mark.parametrize(
    ("one", "said"),
    [
        (OutcomeAlone(), f"OutcomeAlone changes outcome, {UNSEEN}"),
        (TextBefore(), f"TextBefore changes text, {UNSEEN}"),
        (Unreliable(), "Unreliable leaves a report out: it must not have always_tells"),
        (Keeps(), "keeps something"),
        (Always(), "as in truth"),
    ],
)
def test_interventions_that_break_it(one, said):
    with pytest.raises(AssertionError, match=said):
        check_intervention(one)


@pytest.mark.parametrize("spec", ["flip?p=0", "flip?p=1&at=1000", "drop?p=0", "history?last=1000", "nudge?after=9"])
def test_interventions_that_have_nothing_to_do_or_show_what_they_do_keep_it(spec):
    check_intervention(*interventions_of(spec))
    check_intervention(OutcomeAlone(), modality="symbolic")


def test_a_measure_that_keeps_it():
    check_measure("solved")


def grows(trial):
    """Another number whenever it is asked."""
    return next(NUMBERS)


def writes(trial):
    """Leaves something in the trial."""
    trial.facts["seen"] = True
    return 1.0


def silent(trial):
    """Applies to nothing."""


def both(trial):
    """Yes or no where it was solved, else a number."""
    return True if trial.solved else 0.5


@pytest.mark.parametrize(
    ("measure", "error", "said"),
    [
        (grows, AssertionError, "another number when it is asked for again"),
        (writes, AssertionError, "changes the trial"),
        (silent, AssertionError, "applies to no trial"),
        (both, AssertionError, "a number of one trial, and yes or no of another"),
        (lambda trial: 1 / len(trial.steps), ZeroDivisionError, "division by zero"),  # a trial may have no steps
        (lambda trial: "many", BadValue, "expected a finite number"),
        ("many", UserMistake, "no measure is called"),
    ],
)
def test_measures_that_break_it(measure, error, said):
    with pytest.raises(error, match=said):
        check_measure(measure)


def test_plants_that_keep_it():
    check_plant("symbolic")


class Plain(SymbolicPlant):
    def __init__(self, *, box, labels, rng):
        super().__init__(box)
        self.box, self.rng, self.labels = box, rng, labels


class Sticks(Plain):
    """A joint that is free sometimes does not move."""

    def attempt(self, joint):
        moving = self.rng.random() < 0.8
        return super().attempt(joint) if moving else replace(self.observe(), joint=joint, outcome="blocked")


class Lies(Plain):
    def attempt(self, joint):
        return replace(super().attempt(joint), outcome="moved")


class Shared(Plain):
    """All of its boxes are one."""

    now = None

    def observe(self):
        if Shared.now is None:
            Shared.now = self.box.initial
        return replace(super().observe(), configuration=Shared.now)

    def attempt(self, joint):
        done = super().attempt(joint)
        Shared.now = done.configuration
        return done


class Another(Plain):
    def attempt(self, joint):
        return replace(super().attempt(joint), joint=0)


class Reports(Plain):
    def observe(self):
        return replace(super().observe(), joint=1, outcome="moved")


class Senses(Plain):
    def attempt(self, joint):
        return replace(super().attempt(joint), sensed={"force": [1.0, 2.0]})


@pytest.mark.parametrize(
    ("plant", "said"),
    [
        (Sticks, "does not obey the interlock on chain-4, where the interlock lets joint"),
        (Lies, "wrong outcome on chain-4, where the interlock does not let joint"),
        (Shared, "does not start as chain-4 does"),
        (Another, "reports another joint"),
        (Reports, "reports an attempt before the first"),
        (Senses, "what it senses, is no text"),
        (lambda **given: object(), "has no `facts`"),
    ],
)
def test_plants_that_break_it(plant, said):
    with pytest.raises(AssertionError, match=said):
        check_plant(plant, boxes=["chain-4"])


def test_a_trial_attempts_what_it_is_told_as_the_box_reacts():
    trial = make_trial([3, 3, 0, 3, 2, 1, 0], false_at=[3], claims=[None, "moved", "blocked"])
    assert [step.moved for step in trial.steps] == [True, True, False, True, True, True, True]
    assert [step.told_falsely for step in trial.steps] == [False, False, True, False, False, False, False]
    assert [step.decision.claimed for step in trial.steps[:4]] == [None, "moved", "blocked", None]
    assert (trial.solved, trial.budget, trial.labels) == (True, 7, tuple("ABCD"))
    assert trial_from_json(trial_to_json(trial)) == trial


def test_a_trial_ends_with_its_list_or_breaks():
    assert (make_trial([0, 1]).ending, make_trial([3, 2, 1, 0, 0]).actions[-1]) == ("budget", "revolute-left")
    broken = make_trial([0, 1], broken=True)
    assert (broken.ending, broken.error.boundary, len(broken.steps)) == ("error", "model", 2)
    assert make_trial([], broken=True).steps == ()
    slipping = make_trial([0] * 9, box="fork", condition=[Tremble(p=1)])
    assert slipping.box == "fork"
    assert all(step.chosen == "revolute-left" for step in slipping.steps)

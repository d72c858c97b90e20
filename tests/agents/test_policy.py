"""What every policy has in common: a memory that is a value, and one draw from its probabilities, which are checked."""

import asyncio
from bisect import bisect_right
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe import Policy, propagate, run_trial
from lockprobe.agents.catalogue import resolve
from lockprobe.agents.local import LocalModel
from lockprobe.agents.policy import Told, running_sums, tell
from lockprobe.agents.strategies import STRATEGIES
from lockprobe.foundation.errors import BadValue, UserMistake
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.record import Decision, Percept, Situation, Task, Turn

POLICIES = (
    *STRATEGIES,
    "human-inspired:proximity?lapse=0.2",
    "cognitive:softmax-memory?target=1&closed=0.5&failure=2&decay=0.8&reset=0.5&recent=-1&stay=0.5&position=0.3",
)
TASK = Task(joints=("C", "A", "B"), target="B", budget=20, places=((0.1, 0.5), (0.5, 0.5), (0.9, 0.5)))
REPORT = st.tuples(st.sampled_from("ABC"), st.booleans(), st.sets(st.sampled_from("ABC")))


def situation(reports, positions=True):
    """The situation after these reports: (label, moved, shifted joints)."""
    start = (True, False, False)
    percepts = [Percept(positions=start if positions else None)]
    for label, moved, shifted in reports:
        now = tuple(at ^ (joint in shifted) for joint, at in zip(TASK.joints, start, strict=True))
        outcome = "moved" if moved else "blocked"
        percepts.append(Percept(joint=label, outcome=outcome, positions=now if positions else None))
    past = tuple(Turn(percept=percept, decision=Decision(joint=after.joint)) for percept, after in pairwise(percepts))
    return Situation(task=TASK, past=past, percept=percepts[-1])


OPENING = Percept(positions=(True, False, False))
MOVED = Percept(joint="A", positions=(True, True, False))
SILENT = Percept(joint="B")


@pytest.mark.parametrize(
    ("percept", "past", "told"),
    [
        (MOVED, [OPENING], Told(joint=1, moved=True, shifted=0b010, states_only=True)),
        (MOVED, [OPENING, MOVED, SILENT], Told(joint=1, moved=False, shifted=0b010, states_only=True)),
        (SILENT, [OPENING], None),
        (MOVED, [SILENT], None),  # where it stood before is not known
        (OPENING, [], None),
        (replace(MOVED, outcome="moved"), [OPENING], Told(joint=1, moved=True, shifted=0b010)),
        (Percept(joint="C", outcome="blocked"), [Percept()], Told(joint=0, moved=False)),
    ],
)
def test_a_report_in_numbers(percept, past, told):
    assert tell(TASK, percept, [Turn(percept=one, decision=Decision(joint="A")) for one in past]) == told


@given(
    st.lists(st.floats(0, 1), min_size=1, max_size=8).filter(lambda w: sum(w) > 0), st.floats(0, 1, exclude_max=True)
)
def test_a_draw_inverts_the_running_sum_and_never_takes_the_impossible(weights, number):
    probabilities = [weight / sum(weights) for weight in weights]
    joint = bisect_right(running_sums(probabilities), number)
    assert probabilities[joint] > 0
    assert sum(probabilities[:joint]) <= number + 1e-9
    assert number <= sum(probabilities[: joint + 1]) + 1e-9


@settings(max_examples=60)
@given(
    spec=st.sampled_from(POLICIES),
    reports=st.lists(REPORT, max_size=8),
    otherwise=st.lists(REPORT, max_size=2),
    positions=st.booleans(),
)
def test_a_memory_is_a_value_and_recalled_the_same_step_by_step_at_once_and_after_another_trial(
    spec, reports, otherwise, positions
):
    agent, fresh = resolve(spec).make(), resolve(spec).make()
    for i in range(len(reports) + 1):
        found = agent.recall(situation(reports[:i], positions))
    assert found == fresh.recall(situation(reports, positions))
    hash(found.memory)
    other = situation([*reports[:-1], *otherwise], positions)
    assert agent.recall(other) == resolve(spec).make().recall(other)


SEEN = Situation(task=TASK, past=(), percept=Percept(pictures=(Picture(kind="rgb", png=b"a box"),)))


def test_who_reads_reports_refuses_pictures_alone_in_one_line_and_who_heeds_none_plays_on():
    readers = {"HumanInspired": resolve("human-inspired").make(), "a local model": LocalModel.__new__(LocalModel)}
    for name, agent in readers.items():
        expected = f"reports: {name} cannot read pictures; viewer:STRATEGY can"
        with pytest.raises(BadValue, match=f"^modality: got 'pictures', expected {expected}$"):
            asyncio.run(agent.decide(SEEN, np.random.default_rng(1)))
    assert asyncio.run(resolve("random").make().decide(SEEN, np.random.default_rng(1))).joint in "ABC"


class Returning(Policy[None]):
    """Returns one value again and again."""

    exact = True

    def __init__(self, value):
        self.value = value

    def probabilities(self, view, memory):
        return self.value


@pytest.mark.parametrize(
    "value",
    [(0.5, 0.2, 0.2, 0.2), (0.5, 0.5), (2, -1, 0, 0), (float("nan"), 1, 0, 0), (1 + 2e-6, 0, 0, 0), (), 0.25, None],
)
def test_a_return_that_is_no_probabilities_stops_in_one_line(value):
    for using in (lambda policy: run_trial(agent=policy), lambda policy: propagate(policy, "chain-4", p=0)):
        with pytest.raises(UserMistake) as caught:
            using(Returning(value))
        said = f"Returning.probabilities returned {value}: 4 numbers >= 0 that sum to 1 are expected"
        assert str(caught.value) == said


@pytest.mark.parametrize("value", [np.array([0.5, 0.5, 0, 0], np.float32), [Fraction(1, 3), Fraction(2, 3), 0, 0]])
def test_probabilities_of_any_kind_of_number_stand_as_floats_in_the_record(value):
    (step,) = run_trial(agent=Returning(value), max_steps=1).steps
    assert {type(number) for number in step.decision.probabilities} == {float}
    assert step.decision.probabilities == tuple(map(float, value))

"""What every policy has in common: a memory that is a value, and one draw from its probabilities."""

import asyncio
from bisect import bisect_right
from itertools import pairwise

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe import run_trial
from lockprobe.agents.catalogue import resolve
from lockprobe.agents.policy import Told, draw, opened_after, running_sums, tell, view_of
from lockprobe.trial.record import Decision, Percept, Situation, Task, Turn

POLICIES = (
    "random",
    "random-no-repeat",
    "round-robin",
    "human-inspired",
    "human-inspired:proximity?lapse=0.2",
    "human-inspired:per-configuration",
    "cognitive:softmax-memory?target=1&closed=0.5&failure=2&decay=0.8&reset=0.5&recent=-1&stay=0.5&position=0.3",
    "cognitive:random-map?window=2&avoid=failed&lapse=0.1",
)
TASK = Task(joints=("C", "A", "B"), target="B", budget=20, places=((0.1, 0.5), (0.5, 0.5), (0.9, 0.5)))


def situation(reports, positions=True):
    """The situation after these reports: (label, moved, shifted joints)."""
    start = (True, False, False)
    percepts = [Percept(positions=start if positions else None)]
    for label, moved, shifted in reports:
        now = tuple(at ^ (joint in shifted) for joint, at in zip(TASK.joints, start, strict=True))
        percepts.append(
            Percept(joint=label, outcome="moved" if moved else "blocked", positions=now if positions else None)
        )
    past = tuple(Turn(percept=percept, decision=Decision(joint=after.joint)) for percept, after in pairwise(percepts))
    return Situation(task=TASK, past=past, percept=percepts[-1])


def turn(percept):
    return Turn(percept=percept, decision=Decision(joint="A"))


def test_a_report_of_positions_alone_tells_what_moved():
    opening, first = Percept(positions=(True, False, False)), Percept(joint="A", positions=(True, True, False))
    silent = Percept(joint="B")
    assert tell(TASK, first, [turn(opening)]) == Told(joint=1, moved=True, shifted=0b010, states_only=True)
    assert tell(TASK, first, [turn(opening), turn(first), turn(silent)]) == Told(
        joint=1, moved=False, shifted=0b010, states_only=True
    )
    assert tell(TASK, silent, [turn(opening)]) is None
    assert tell(TASK, first, [turn(silent)]) is None  # where it stood before is not known
    assert tell(TASK, opening, []) is None


def test_a_report_in_numbers():
    opening = Percept(positions=(True, False, False))
    percept = Percept(joint="A", outcome="moved", positions=(True, True, False))
    assert tell(TASK, percept, [turn(opening)]) == Told(joint=1, moved=True, shifted=0b010)
    assert tell(TASK, Percept(joint="C", outcome="blocked"), [turn(Percept())]) == Told(
        joint=0, moved=False, shifted=None
    )
    assert (view_of(TASK).joints, view_of(TASK).target) == (3, 2)


def test_what_is_open_is_as_told_else_as_the_outcomes_imply():
    assert opened_after(0b001, Told(joint=1, moved=True, shifted=0b100)) == 0b100
    assert opened_after(0b001, Told(joint=1, moved=True)) == 0b011
    assert opened_after(0b011, Told(joint=1, moved=True)) == 0b001
    assert opened_after(0b001, Told(joint=1, moved=False)) == 0b001


@given(
    st.lists(st.floats(0, 1), min_size=1, max_size=8).filter(lambda w: sum(w) > 0), st.floats(0, 1, exclude_max=True)
)
def test_a_draw_inverts_the_running_sum_and_never_takes_the_impossible(weights, number):
    probabilities = [weight / sum(weights) for weight in weights]
    joint = draw(probabilities, number)
    assert joint == bisect_right(running_sums(probabilities), number)  # as the kernel draws
    assert probabilities[joint] > 0
    assert sum(probabilities[:joint]) <= number + 1e-9
    assert number <= sum(probabilities[: joint + 1]) + 1e-9


@settings(max_examples=40, deadline=None)
@given(
    spec=st.sampled_from(POLICIES),
    reports=st.lists(st.tuples(st.sampled_from("ABC"), st.booleans(), st.sets(st.sampled_from("ABC"))), max_size=8),
    positions=st.booleans(),
)
def test_a_memory_is_a_value_and_recalled_the_same_step_by_step_and_at_once(spec, reports, positions):
    stepwise, fresh = resolve(spec).make(), resolve(spec).make()
    for i in range(len(reports) + 1):
        found = stepwise.recall(situation(reports[:i], positions))
    at_once = fresh.recall(situation(reports, positions))
    assert found == at_once
    hash(found[1])


def test_agents_that_look_at_nothing_say_nothing():
    for spec, looks in (("random", False), ("round-robin", False), ("human-inspired", True)):
        decision = asyncio.run(resolve(spec).make().decide(situation([("A", True, "A")]), np.random.default_rng(1)))
        assert decision.claimed == ("moved" if looks else None)


def test_trials_that_are_played_in_turns_are_played_as_one_by_one():
    agent = resolve(POLICIES[-1]).make()
    alone = [run_trial(agent=POLICIES[-1], trial=i, p=0.4).actions for i in (1, 2, 3)]
    assert [run_trial(agent=agent, trial=i, p=0.4).actions for i in (1, 2, 3)] == alone


@settings(max_examples=60, deadline=None)
@given(
    spec=st.sampled_from(POLICIES),
    reports=st.lists(st.tuples(st.sampled_from("ABC"), st.booleans(), st.sets(st.sampled_from("ABC"))), max_size=4),
    last=st.lists(st.tuples(st.sampled_from("ABC"), st.booleans(), st.sets(st.sampled_from("ABC"))), max_size=2),
)
def test_a_trial_that_was_told_otherwise_last_is_another_trial(spec, reports, last):
    agent, fresh = resolve(spec).make(), resolve(spec).make()
    agent.recall(situation(reports, True))
    other = situation([*reports[:-1], *last], True)
    assert agent.recall(other) == fresh.recall(other)


def test_random_no_repeat_never_repeats():
    for trial in [run_trial(agent="random-no-repeat", trial=i) for i in range(1, 21)]:
        assert all(a != b for a, b in zip(trial.actions, trial.actions[1:], strict=False))


def test_round_robin_goes_through_the_listing_and_always_solves_chain_4():
    for trial in [run_trial(agent="round-robin", trial=i, p=0.6) for i in range(1, 31)]:
        labels = dict(zip(trial.joints, trial.labels, strict=True))
        told = [labels[joint] for joint in trial.actions]
        assert told == (list(trial.listing) * 5)[: len(told)]
        assert trial.solved
        assert len(trial.steps) <= 13

"""The strategies by their own rules: written anew from their docstrings, choice by choice."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lockprobe import population
from lockprobe.agents.ideal_observer import IdealObserver
from lockprobe.agents.policy import Told, View
from lockprobe.agents.strategies import CHARACTERS, STRATEGIES, LoopBreaker, SoftmaxMemory
from lockprobe.simulation.exact import propagate

FOUR = View(joints=4, target=0)
REPORTS = st.lists(st.tuples(st.integers(0, 3), st.booleans()), max_size=15)


def remembered(agent, reports, view=FOUR):
    """The memory after these reports: joint, whether it moved, and which joints are open if that is told."""
    memory = agent.begin(view)
    for joint, moved, *shifted in reports:
        memory = agent.remember(view, memory, Told(joint=joint, moved=moved, shifted=shifted[0] if shifted else None))
    return memory


def after(agent, reports, view=FOUR):
    return agent.probabilities(view, remembered(agent, reports, view))


LINE = View(joints=4, target=0, places=((0.0, 0.5), (0.3, 0.5), (0.5, 0.5), (0.6, 0.5)))
FROM_RIGHT = View(joints=4, target=0, places=((0.6, 0.5), (0.3, 0.5), (0.0, 0.5), (0.5, 0.5)))
BACK = [(1, False, 0), (2, True, 0b100), (2, True, 0)]


@pytest.mark.parametrize(
    ("name", "view", "reports", "choices"),
    [
        ("random-no-repeat", FOUR, [(2, True)], [0, 1, 3]),
        ("round-robin", LINE, [(0, False), (1, True), (2, False), (3, False), (0, True)], [1]),
        ("right-to-left", FROM_RIGHT, [(0, False), (3, True)], [1]),
        ("human-inspired:target-first", FOUR, [], [0]),
        ("human-inspired:target-first", FOUR, [(0, False)], [1, 2, 3]),
        ("human-inspired:target-first", FOUR, [(0, False), (2, True)], [0]),
        ("human-inspired:target-first", FOUR, [(0, False), (2, True), (0, False)], [1, 3]),
        ("human-inspired:target-last", FOUR, [], [1, 2, 3]),
        ("human-inspired:target-last", FOUR, [(1, False), (3, False)], [2]),
        ("human-inspired:target-last", FOUR, [(1, False), (3, False), (2, False)], [0]),
        ("human-inspired:target-last", FOUR, [(1, False), (3, False), (2, False), (0, False)], [0, 1, 2, 3]),
        ("human-inspired:proximity", LINE, [], [0, 1, 2, 3]),
        ("human-inspired:proximity", LINE, [(2, False)], [0, 1, 3]),
        ("human-inspired:proximity", LINE, [(2, True)], [3]),
        ("human-inspired:proximity", LINE, [(2, True), (3, False)], [1]),
        ("human-inspired:proximity", LINE, [(2, True), (3, True)], [1]),
        ("human-inspired:proximity", View(joints=3, target=0, places=((0.2, 0.5), (0.4, 0.5), (0.6, 0.5))), [(1, True)], [0, 2]),
        ("human-inspired:per-configuration", FOUR, BACK[:1], [0, 2, 3]),
        ("human-inspired:per-configuration", FOUR, BACK[:2], [0, 1, 3]),
        ("human-inspired:per-configuration", FOUR, BACK, [0, 3]),
        ("human-inspired:per-configuration", FOUR, [*BACK, (0, False, 0), (3, False, 0)], [0, 1, 2, 3]),
        ("human-inspired:per-configuration", FOUR, [(2, True, 0b100), (0, False, 0b100)], [1, 3]),
        ("human-inspired:per-configuration", FOUR, [(2, True, 0b100), *((j, False, 0b100) for j in (0, 1, 3))], [2]),
    ],
)  # fmt: skip
def test_each_chooses_among_what_its_rules_leave(name, view, reports, choices):
    chances = after(STRATEGIES[name], reports, view)
    assert [joint for joint, chance in enumerate(chances) if chance > 0] == choices


@given(
    preset=st.sampled_from([name for name in STRATEGIES if name.startswith("human")]),
    lapse=st.sampled_from([0.0, 0.3, 1.0]),
    reports=REPORTS,
)
def test_human_inspired_always_has_a_choice_and_lapses_are_equal_for_all(preset, lapse, reports):
    agent = replace(STRATEGIES[preset], lapse=lapse)
    sure = after(STRATEGIES[preset], reports, LINE)
    choices = [joint for joint, chance in enumerate(sure) if chance > 0]
    assert choices
    expected = [lapse / 4 + (1 - lapse) * (joint in choices) / len(choices) for joint in range(4)]
    assert after(agent, reports, LINE) == pytest.approx(expected)


@given(pulls=st.tuples(*[st.floats(-5, 5)] * 6), decay=st.floats(0, 1), reset=st.floats(0, 1), reports=REPORTS)
def test_the_softmax_is_its_formula(pulls, decay, reset, reports):
    """From the whole past at once."""
    names = ("target", "closed", "failure", "recent", "stay", "position")
    target, closed, failure, recent, stay, position = pulls
    weights = []
    for j in range(4):
        trace = 0.0
        for i, (joint, moved) in enumerate(reports):
            if joint == j and not moved:
                later = reports[i + 1 :]
                trace = decay ** len(later) * (1 - reset) ** sum(m for _, m in later)
        was_opened = sum(moved for joint, moved in reports if joint == j) % 2
        pull = target * (j == FOUR.target) + closed * (not was_opened) - failure * trace - position * j / 3
        if reports and reports[-1][0] == j:
            pull += recent + stay * reports[-1][1]
        weights.append(math.exp(pull))
    agent = SoftmaxMemory(**dict(zip(names, pulls, strict=True)), decay=decay, reset=reset)
    assert after(agent, reports) == pytest.approx([weight / sum(weights) for weight in weights], abs=1e-12)


@pytest.mark.slow
def test_lies_hurt_one_character_help_another_and_of_the_third_a_few_help_and_many_hurt():
    at = {name: [population(name, p=p, trials=1000, seed=5).success for p in (0.0, 0.4, 1.0)] for name in CHARACTERS}
    assert at["cognitive:careful"][0] > at["cognitive:careful"][1] > at["cognitive:careful"][2] + 0.05
    assert at["cognitive:perseverant"][0] + 0.2 < at["cognitive:perseverant"][1] < at["cognitive:perseverant"][2]
    assert at["cognitive:insistent"][0] + 0.02 < at["cognitive:insistent"][1] > at["cognitive:insistent"][2] + 0.15


FALSE, TRUE = Told(joint=1, moved=True), Told(joint=1, moved=False)


@pytest.mark.parametrize(
    ("told", "free"), [(FALSE, 3), (replace(TRUE, odd=True), 3), (replace(FALSE, odd=True), 3), (TRUE, 0)]
)
def test_any_odd_report_frees_a_loop_breaker_which_forgets_and_draws_a_new_cycle(told, free):
    policy = LoopBreaker()
    round_ = remembered(policy, [(1, False), (2, False), (3, False)])
    assert policy.probabilities(FOUR, round_) == (0, 1, 0, 0)
    assert policy.remember_silence(FOUR, round_, 1).free == 3
    memory = policy.remember(FOUR, round_, told)
    assert memory.free == free
    for joint in range(free):
        assert policy.probabilities(FOUR, memory)[memory.last] == 0
        memory = policy.remember(FOUR, memory, Told(joint=joint, moved=joint == 1))
    assert memory == policy.begin(FOUR) or not free
    two = View(joints=2, target=0)
    assert policy.probabilities(two, remembered(policy, [(1, False), (0, False)], two)) == (0, 1)


@pytest.mark.parametrize(
    ("options", "steps", "by_80", "last"),
    [
        ("prior=chains&noise=naive", 5.5, 6, 7),
        ("prior=single-parent&noise=naive", 8.5, 9, 10),
        ("noise=aware", 25 / 3, 9, 10),
    ],
)
def test_the_ideal_observer_solves_the_papers_chain_when_told_the_truth(options, steps, by_80, last):
    course = propagate(f"ideal-observer?{options}")
    assert course.steps == pytest.approx(steps)
    assert (course.by(0.8), course.by(1)) == (by_80, last)


@pytest.mark.parametrize(
    ("options", "attempt", "claimed"),
    [
        ({}, (0, True), "blocked"),  # a target that moved would have ended the trial
        ({"noise": "naive"}, (1, True), "moved"),
        ({"noise": "naive"}, (1, False), "blocked"),
        ({"noise": "1"}, (1, False), "moved"),  # reports that are always false are turned round
        ({"noise": "0.5", "prior": "chains"}, (1, True), "blocked"),  # it says nothing, and one chain of three moves
    ],
)  # fmt: skip
def test_the_ideal_observer_says_what_it_thinks_its_action_did(options, attempt, claimed):
    agent, (joint, moved) = IdealObserver(**options), attempt
    told = Told(joint=joint, moved=moved, shifted=moved << joint)
    assert agent.claim(agent.remember(FOUR, agent.begin(FOUR), told), told) == claimed

"""Cognitive models as agents: their formulas, choice by choice."""

import math
from collections import Counter

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe import population, run_trial
from lockprobe.agents.cognitive import CHARACTERS, LoopBreaker, RandomMap, SoftmaxMemory
from lockprobe.agents.policy import Told, View
from lockprobe.foundation.errors import BadValue

FOUR = View(joints=4, target=2)
REPORTS = st.lists(st.tuples(st.integers(0, 3), st.booleans()), max_size=15)


def after(agent, reports, view=FOUR):
    memory = agent.begin(view)
    for joint, moved in reports:
        memory = agent.remember(view, memory, Told(joint=joint, moved=moved))
    return agent.probabilities(view, memory)


def share(agent, n, **settings):
    """Of the trials of a study, played without records."""
    return population(agent, trials=n, seed=5, **settings).success


@settings(max_examples=60, deadline=None)
@given(
    pulls=st.tuples(*[st.floats(-5, 5)] * 6),
    decay=st.floats(0, 1),
    reset=st.floats(0, 1),
    reports=REPORTS,
)
def test_the_softmax_is_its_formula(pulls, decay, reset, reports):
    """Written anew from the docstring, from the whole past at once."""
    target, closed, failure, recent, stay, position = pulls
    agent = SoftmaxMemory(
        target=target,
        closed=closed,
        failure=failure,
        recent=recent,
        stay=stay,
        position=position,
        decay=decay,
        reset=reset,
    )
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
    expected = [weight / sum(weights) for weight in weights]
    assert after(agent, reports) == pytest.approx(expected, abs=1e-12)


@settings(max_examples=60, deadline=None)
@given(reports=REPORTS, window=st.integers(0, 3), avoid=st.sampled_from(["none", "last", "failed"]))
def test_the_map_repeats_what_it_did_first(reports, window, avoid):
    if avoid == "last" and not window:
        return
    agent = RandomMap(window=window, avoid=avoid, lapse=0.1)
    seen = {}
    for i in range(len(reports) + 1):
        past = reports[:i]
        failed = set()
        for joint, moved in past:
            failed = set() if moved else failed | {joint}
        state = (tuple(past[len(past) - min(window, len(past)) :]), frozenset(failed) if avoid == "failed" else None)
        found = after(agent, past)
        if state in seen:
            assert found == pytest.approx([0.025 + 0.9 * (j == seen[state]) for j in range(4)])
        else:
            barred = failed if avoid == "failed" else {past[-1][0]} if avoid == "last" and past else set()
            allowed = [j for j in range(4) if j not in barred] or list(range(4))
            assert found == pytest.approx([0.025 + 0.9 * (j in allowed) / len(allowed) for j in range(4)])
        if i < len(reports):
            seen.setdefault(state, reports[i][0])


def test_a_map_is_drawn_anew_for_every_trial_and_kept_within_it():
    firsts = Counter(
        run_trial(agent="cognitive:random-map", trial=i, shuffle="never").actions[0] for i in range(1, 200)
    )
    assert min(firsts.values()) > 25
    for i in range(1, 11):
        trial = run_trial(agent="cognitive:random-map?window=0", trial=i)
        done = {}
        for step in trial.steps:
            assert done.setdefault(step.state, step.joint) == step.joint


def test_the_record_holds_the_probabilities_that_were_drawn_from():
    trial = run_trial(agent="cognitive:softmax-memory?failure=2&target=1", p=0.3)
    assert all(sum(step.decision.probabilities) == pytest.approx(1) for step in trial.steps)
    assert trial.facts["failure"] == 2


def test_lies_rescue_a_map_and_mislead_it():
    """What the paper finds in a model (Sec. 3.2), in an agent without any thought: up, and down again at p = 1."""
    told_truth, half, all_lies = (
        share("cognitive:random-map?window=1&avoid=last", p=p, flip="outcome-only", n=300) for p in (0.0, 0.5, 1.0)
    )
    assert half > told_truth + 0.1
    assert half > all_lies + 0.1


@pytest.mark.slow
def test_characters_are_helped_hurt_and_both():
    at = {name: [share(f"cognitive:{name}", p=p, n=1000) for p in (0.0, 0.4, 1.0)] for name in CHARACTERS}
    assert at["careful"][0] > at["careful"][1] > at["careful"][2] + 0.05
    assert at["perseverant"][0] + 0.2 < at["perseverant"][1] < at["perseverant"][2]
    assert at["insistent"][0] + 0.02 < at["insistent"][1] > at["insistent"][2] + 0.15


BOX_OF_FOUR = View(joints=4, target=0)
FALSE, TRUE = Told(joint=1, moved=True), Told(joint=1, moved=False)


def going_round(policy):
    """A memory in which joint 1 was blocked, and comes next."""
    memory = policy.begin(BOX_OF_FOUR)
    for joint in (1, 2, 3):
        memory = policy.remember(BOX_OF_FOUR, memory, Told(joint=joint, moved=False))
    assert policy.probabilities(BOX_OF_FOUR, memory) == (0, 1, 0, 0)
    return memory


@pytest.mark.parametrize(
    ("told", "free"),
    [
        (FALSE, 3), (Told(joint=1, moved=False, corrects=TRUE), 3), (Told(joint=1, moved=False, corrects=FALSE), 3),
        (Told(joint=1, moved=True, corrects=TRUE), 3), (Told(joint=1, moved=False, remarked=True), 3), (TRUE, 0),
    ],
)  # fmt: skip
def test_any_odd_report_frees_a_loop_breaker(told, free):
    policy = LoopBreaker()
    assert policy.remember(BOX_OF_FOUR, going_round(policy), told).free == free
    assert policy.remember_silence(BOX_OF_FOUR, going_round(policy), 1).free == 3


def test_once_free_a_loop_breaker_has_forgotten_and_draws_a_new_cycle():
    policy = LoopBreaker()
    memory = policy.remember(BOX_OF_FOUR, going_round(policy), FALSE)
    for joint in (0, 1, 2):
        assert policy.probabilities(BOX_OF_FOUR, memory)[memory.last] == 0
        memory = policy.remember(BOX_OF_FOUR, memory, Told(joint=joint, moved=joint == 1))
    assert memory == policy.begin(BOX_OF_FOUR)
    with pytest.raises(BadValue, match="at least 3 joints"):
        policy.begin(View(joints=2, target=0))

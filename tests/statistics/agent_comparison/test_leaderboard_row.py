"""One agent over all p: counts by hand, regret between optimum and chance, luck that is shared."""

from dataclasses import replace

import pytest
from builders import SOLUTION, make_trial, play_study, small_study

from lockprobe.boxes.families import box
from lockprobe.statistics.summary import summarise


def only(trials, known=True):
    summary = summarise(trials, box("chain-4") if known else None)
    (row,) = summary.standings
    return row, summary.agents[0].conditions


def solved_at(step, p=0.0, trial=1, **more):
    return make_trial([0] * (step - 4) + list(SOLUTION), agent="llm:a", p=p, trial=trial, **more)


def test_counts_by_hand():
    trials = [solved_at(4 + i % 3, p, trial=i + 1) for p in (0.0, 0.4) for i in range(9)]
    trials += [make_trial((0,) * 20, agent="llm:a", p=0.4, trial=10)]
    row, _ = only(trials)
    assert (row.success.count, row.success.n, row.success.clusters) == (18, 19, 10)
    assert row.steps_to_80 == 6
    assert row.loops.count == 1
    assert row.loops.n == 19


def test_the_shortest_plan_has_no_regret_and_failure_more_than_chance():
    best, _ = only([solved_at(4, p, i) for p in (0.0, 0.3) for i in (1, 2, 3)])
    assert best.regret.value == 0.0
    worst, _ = only([make_trial((0,) * 20, agent="llm:a", trial=i) for i in (1, 2, 3)])
    assert worst.regret.value > 1
    assert only([solved_at(4)], known=False)[0].regret is None


def test_random_agents_have_a_regret_of_about_one():
    row, _ = only(play_study(small_study(["random"], (0.0,), 3, 60)))
    assert row.regret.value == pytest.approx(1, abs=0.12)
    assert row.regret.high - row.regret.low < 0.2


def test_regret_at_one_p_is_that_of_the_condition():
    row, (condition,) = only([solved_at(4 + i, trial=i + 1) for i in range(10)])
    assert row.regret.value == pytest.approx(1 - condition.relative.value)


def test_copies_over_p_make_an_agent_no_surer():
    once, _ = only([solved_at(4 + i, p=0.0, trial=i + 1) for i in range(10)])
    often, _ = only([solved_at(4 + i, p=p, trial=i + 1) for p in (0.0, 0.2, 0.4) for i in range(10)])
    assert often.regret.high - often.regret.low == pytest.approx(once.regret.high - once.regret.low)


def test_chance_is_that_of_the_lengths_played():
    long = [make_trial((0,) * 20, agent="llm:a", p=0.4, trial=i) for i in (1, 2, 3)]
    row, (short, other) = only([solved_at(4, trial=1), *long])
    assert (short.behaviour.chance_uniform, other.behaviour.chance_uniform) == pytest.approx((0.0, 0.8008), abs=1e-4)
    assert row.chance == pytest.approx(0.75 * other.behaviour.chance_uniform)


def test_misreadings_are_pooled_and_trials_that_were_not_asked_counted():
    trials = [solved_at(6, trial=i, claims=[None, "moved", "blocked"]) for i in (1, 2)]
    row, _ = only([*trials, replace(solved_at(5, trial=3), assessment=False)])
    assert (row.misread.count, row.misread.n, row.not_asked) == (2, 4, 1)

"""Who is faster, and whether doses change how long trials take, whatever became of broken trials."""

import pytest
from builders import SOLUTION, make_trial, play_study, small_study

from lockprobe.statistics.conditions.axis_trials import on_axis
from lockprobe.statistics.inference.mean_steps import mean_steps
from lockprobe.statistics.outcomes import broken_off, outcomes
from lockprobe.statistics.pace import pace, steps_over_doses


def of(members):
    (found,) = on_axis(members)
    return found


def trials(agent, count=8):
    return of(play_study(small_study([agent], (0.0,), 1, count)))


def test_the_faster_agent_is_found_whichever_comes_first_and_an_agent_is_as_fast_as_itself():
    slow, fast = trials("random", 30), trials("human-inspired", 30)
    found, turned = pace(slow, fast), pace(fast, slow)
    assert found.ratio > 2
    assert found.ratio * turned.ratio == pytest.approx(1)
    assert found.p_value == pytest.approx(turned.p_value)
    assert found.p_value < 0.01
    alike = pace(slow, slow)
    assert (alike.p_value, alike.ratio) == (1.0, pytest.approx(1))


def test_without_trials_there_is_no_comparison_and_without_successes_no_ratio():
    solved, unsolved = (of([make_trial(joints, agent="other")]) for joints in (SOLUTION, [0] * 20))
    assert pace(of([make_trial([0], broken="model")]), solved) is None
    assert pace(of([make_trial([0] * 20)]), unsolved).ratio is None


def test_where_trials_broke_the_slower_agent_may_have_been_the_faster():
    """Of one agent all trials but ten break in step 2: it is called slower only if they could not have been solved."""
    quick = [make_trial(SOLUTION, trial=i) for i in range(30)]
    slow = [make_trial([0] * 20, agent="other", trial=i) for i in range(30)]
    broke = [make_trial([0], agent="other", trial=i, broken="model") for i in range(20)]
    assert pace(of(quick), of(slow)).p_value < 0.001
    assert pace(of(quick), of([*broke, *slow[20:]])).p_value == 1.0


def over_doses(played):
    return steps_over_doses(outcomes(played), broken_off(played), 20)


def test_a_change_of_steps_holds_at_both_ends_of_what_broken_trials_can_have_become():
    quick = [make_trial(SOLUTION, trial=i) for i in range(30)]
    slow = [make_trial([0] * 10 + [*SOLUTION], p=0.4, trial=i) for i in range(30)]
    broke = [make_trial([0, 0], p=0.4, trial=i, broken="model") for i in range(30)]
    whole, few, many = (over_doses([*quick, *broke[:n], *slow[n:]]) for n in (0, 2, 28))
    assert whole == mean_steps(outcomes([*quick, *slow]), 20)
    assert (whole.value, few.value, many.value) == (10, 10, 10)
    solved = [make_trial([0, *SOLUTION][-3:], p=0.4, trial=i) for i in range(2)]
    never = [make_trial([0] * 20, p=0.4, trial=i) for i in range(2)]
    ends = [mean_steps(outcomes([*quick, *gone, *slow[2:]]), 20) for gone in (solved, never)]
    assert few.low == pytest.approx(min(one.low for one in ends))
    assert few.high == pytest.approx(max(one.high for one in ends))
    assert few.p_value == pytest.approx(max(one.p_value for one in ends))
    assert few.p_value < 0.05
    assert many.p_value == 1.0  # those that broke may have been solved at once
    assert over_doses([*quick, *broke]).note == "fewer than two doses"

"""Two agents on the same boxes: who is faster."""

import pytest
from builders import SOLUTION, make_trial, play_study, small_study

from lockprobe.statistics.conditions.axis_trials import on_axis
from lockprobe.statistics.pace import pace


def trials(agent, count=8):
    played = play_study(small_study([agent], (0.0,), 1, count))
    return of([trial for trial in played if trial.p == 0])


def of(members):
    (found,) = on_axis(members)
    return found


def test_the_faster_agent_is_found_whichever_comes_first():
    slow, fast = trials("random", 30), trials("human-inspired", 30)
    found, turned = pace(slow, fast), pace(fast, slow)
    assert found.hazard_ratio > 2
    assert found.hazard_ratio * turned.hazard_ratio == pytest.approx(1)
    assert found.p_value == pytest.approx(turned.p_value)
    assert max(found.p_value, found.independent, found.gehan) < 0.01
    assert (found.first[0], found.second[0], found.dose) == ("random", "human-inspired", 0.0)


def test_an_agent_is_as_fast_as_itself():
    found = pace(trials("round-robin"), trials("round-robin"))
    assert found.p_value == 1.0
    assert found.hazard_ratio == pytest.approx(1)


def test_without_trials_there_is_no_comparison():
    assert pace(of([make_trial([0], broken="model")]), of([make_trial(SOLUTION)])) is None
    none = pace(of([make_trial([0] * 20)]), of([make_trial([0] * 20, agent="other")]))
    assert none.hazard_ratio is None
    assert none.independent is None


def test_where_trials_broke_the_slower_agent_may_have_been_the_faster():
    """Of one agent all trials but ten break in step 2: it is called slower only if they could not have been solved."""
    quick = [make_trial(SOLUTION, trial=i) for i in range(30)]
    slow = [make_trial([0] * 20, agent="other", trial=i) for i in range(30)]
    broke = [make_trial([0], agent="other", trial=i, broken="model") for i in range(20)]
    whole, bounded = pace(of(quick), of(slow)), pace(of(quick), of([*broke, *slow[20:]]))
    assert whole.p_value < 0.001
    assert (bounded.p_value, bounded.independent, bounded.gehan) == (1.0, None, None)

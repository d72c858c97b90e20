"""Steps of agents for each step of people: on the same trials, unsolved ones never lost, bounds where a median is out."""

from dataclasses import replace

import pytest
from builders import SOLUTION, make_trial, play_study, played_by_people, small_study

from lockprobe.statistics.people import people

BUDGET = 20


def waiting(agent, wait, trial, p=0.0, who=None):
    """A trial that is solved after so many blocked steps at the target; not at all where that is None."""
    steps = (0,) * BUDGET if wait is None else (*(0,) * wait, *SOLUTION)
    return make_trial(steps, agent=f"participant:{who or trial:0>4}" if agent is None else agent, p=p, trial=trial)


def found(human, agent, **more):
    trials = [waiting(None, wait, i + 1) for i, wait in enumerate(human)]
    trials += [waiting("llm:a", wait, i + 1, **more) for i, wait in enumerate(agent)]
    (one,) = people(trials).relative
    return one


def test_the_median_of_all_trials_over_the_human_one():
    one = found([0, 2, 2, 4, None] * 6, [4, 8, 8, 12, None] * 6)
    assert (one.agent, one.trials, one.steps, one.people) == ("llm:a", 30, 12, 6)
    assert one.ratio == 2.0
    assert one.low <= 2.0 <= one.high
    assert one.mean_ratio == pytest.approx((8 + 12 + 12 + 16 + 20) / (4 + 6 + 6 + 8 + 20))


def test_failing_often_makes_nobody_fast():
    assert found([4] * 10, [0] * 4 + [None] * 6).ratio is None
    assert found([4] * 10, [0] * 4 + [None] * 6).least == 21 / 8


def test_where_people_fail_there_is_an_upper_bound_only():
    one = found([0] * 4 + [None] * 6, [6] * 10)
    assert (one.ratio, one.least, one.most) == (None, None, 10 / 21)
    assert one.low is None
    neither = found([None] * 10, [None] * 10)
    assert (neither.ratio, neither.least, neither.most, neither.low, neither.high) == (None,) * 5
    assert neither.mean_ratio == 1.0


def test_equal_trials_are_one_whatever_is_drawn():
    one = found([0, 3, 5, 9, 12], [0, 3, 5, 9, 12])
    assert (one.low, one.ratio, one.high) == (1.0, 1.0, 1.0)
    assert (one.mean_low, one.mean_high) == pytest.approx((1.0, 1.0))


def test_steps_are_compared_under_the_same_condition_alone():
    """An agent that was nudged is compared with people who were nudged, whatever others did at the same flip rate."""
    nudged = {"condition": "nudge", "specs": ("nudge?after=2",)}
    trials = [waiting(None, 2, i) for i in (1, 2)] + [waiting("llm:a", 2, i) for i in (1, 2)]
    trials += [replace(waiting(agent, wait, i), **nudged) for i in (1, 2) for agent, wait in ((None, 0), ("llm:a", 4))]
    rows = {row.condition: (row.trials, row.steps, row.people) for row in people(trials).relative}
    assert rows == {"truth": (2, 6, 6), "nudge": (2, 8, 4), "": (4, 6, 4)}


def test_only_trials_that_both_finished_count():
    trials = [waiting(None, 2, i) for i in (1, 2, 3)] + [waiting("llm:a", 2, i) for i in (1, 2)]
    trials += [waiting("llm:a", 16, i) for i in (4, 5, 6, 7)] + [replace(waiting("llm:a", 0, 3), ending="error")]
    (one,) = people(trials).relative
    assert (one.trials, one.ratio) == (2, 1.0)


def test_boxes_of_one_person_are_less_than_as_many_people():
    """Three people, ten boxes each, who differ much: how fast people are is not known from thirty boxes."""
    waits = [0] * 10 + [4] * 10 + [12] * 10
    agent = [waiting("llm:a", 4, i + 1) for i in range(30)]
    few = people([*agent, *(waiting(None, wait, i + 1, who=i // 10) for i, wait in enumerate(waits))])
    many = people([*agent, *(waiting(None, wait, i + 1) for i, wait in enumerate(waits))])
    assert few.relative[0].ratio == many.relative[0].ratio == 1.0
    assert (few.relative[0].low, few.relative[0].high) == (0.5, 2.0)
    assert few.relative[0].high / few.relative[0].low >= many.relative[0].high / many.relative[0].low
    (over,) = few.over
    assert (over.steps.low, over.steps.median, over.steps.high) == (4, 8, 16)


def test_one_person_gives_no_interval():
    trials = [waiting(None, 2, i, who=1) for i in (1, 2, 3)] + [waiting("llm:a", 2, i) for i in (1, 2, 3)]
    (one,) = people(trials).relative
    assert (one.low, one.high, one.mean_low, one.mean_high) == (None,) * 4


def test_every_agent_under_every_condition_and_over_all_of_them_in_the_order_of_the_study():
    study = small_study(("participant",), (0.0, 0.4), 1, 3)
    trials = play_study(small_study(("random", "round-robin"), (0.0, 0.4), 1, 3)) + played_by_people(study)
    rows = people(trials).relative
    assert [(row.agent, row.condition) for row in rows] == [
        (agent, condition) for agent in ("random", "round-robin") for condition in ("truth", "flip?p=0.4", "")
    ]
    assert [row.trials for row in rows] == [3, 3, 6] * 2
    assert people(trials[::-1]).relative[0].agent in ("random", "round-robin")

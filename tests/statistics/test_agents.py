"""Two agents on the same boxes: which are compared, counts by hand, people, broken trials, what noise changes."""

from itertools import product

import numpy as np
import pytest
from builders import SOLUTION, make_trial
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe.statistics.agents import STEPS, SUCCESS, compared
from lockprobe.statistics.course import cells_of, courses
from lockprobe.trial.record import STATES

FAILED = (0,) * 20


def trials(agent, solved, of=12, p=(0.0, 0.3), modality=STATES):
    """So many trials solved at every p, those with the lowest numbers; at once, or not at all."""
    return [
        make_trial(SOLUTION if i < n else FAILED, agent=agent, p=value, trial=i + 1, modality=modality)
        for value, n in zip(p, solved, strict=True)
        for i in range(of)
    ]


def pair(*groups):
    """The only pair; its second agent is that of the first group."""
    (found,) = compared(courses(cells_of([trial for group in groups for trial in group]).values()))
    return found


def names(found):
    return [(one.second.agent, one.first.agent, one.baseline) for one in found]


def test_models_are_compared_with_each_other_and_with_baselines_in_one_modality():
    agents = ("llm:a", "llm:b", "human-inspired?lapse=0.1", "random", "round-robin")
    found = compared(courses(cells_of([trial for agent in agents for trial in trials(agent, (5, 5))]).values()))
    baselines = [(model, other, True) for model in agents[:2] for other in agents[2:4]]
    assert names(found) == [("llm:a", "llm:b", False), *baselines]
    assert names(compared(courses(cells_of([*trials("random", (3, 3)), *trials("round-robin", (9, 9))]).values()))) == [
        ("random", "round-robin", False)
    ]
    made = [t for a in ("llm:a", "llm:b") for m in ("rgb", STATES) for t in trials(a, (9, 9), modality=m)]
    found = compared(courses(cells_of([*made, *trials("random", (9, 9))]).values()))
    assert [(one.first.modality, one.second.modality) for one in found if not one.baseline] == [
        ("rgb", "rgb"), (STATES, STATES)
    ]  # fmt: skip
    assert len(found) == 6
    apart = [*trials("llm:a", (3,), p=(0.0,)), *trials("llm:b", (3,), p=(0.3,))]
    assert compared(courses(cells_of(apart).values())) == []


played = st.lists(st.tuples(*[st.sampled_from([True, False, None])] * 4), min_size=2, max_size=8)


@settings(max_examples=25, deadline=None)
@given(played)
def test_two_agents_are_compared_over_the_trials_that_both_finished(blocks):
    """Counted again from the table of who solved what (None: no trial); called in the other order, signs turn."""

    def of(agent, columns):
        return [
            make_trial(SOLUTION if row[column] else FAILED, agent=agent, p=p, trial=i + 1)
            for column, p in zip(columns, (0.0, 0.3), strict=True)
            for i, row in enumerate(blocks)
            if row[column] is not None
        ]

    one, two = of("llm:a", (0, 1)), of("llm:b", (2, 3))
    found, turned = (
        compared(courses(cells_of([*one, *two]).values())),
        compared(courses(cells_of([*two, *one]).values())),
    )
    both = {p: [(r[i], r[i + 2]) for r in blocks if None not in (r[i], r[i + 2])] for i, p in ((0, 0.0), (1, 0.3))}
    every = both[0.0] + both[0.3]
    assert bool(found) == bool(every)
    for first, other in zip(found, turned, strict=True):
        assert [one.mean() for one in first.solved] == np.mean(every, axis=0)[::-1].tolist()
        mean = first.mean(SUCCESS)
        assert (mean.value, mean.n) == (pytest.approx(np.mean([a - b for a, b in every])), len(every))
        assert first.mean(STEPS).value == pytest.approx(-16 * mean.value)  # 4 steps, or 20
        for quantity in (SUCCESS, STEPS):
            own, its = first.mean(quantity), other.mean(quantity)
            assert (own.value, own.p_value) == pytest.approx((-its.value, its.p_value))
            assert own.low is its.high is None or own.low == pytest.approx(-its.high)
        changed = [(r[0] - r[2], r[1] - r[3]) for r in blocks if None not in r]
        if first.changes:
            assert first.changes[0.3].value == pytest.approx(np.mean([after - before for before, after in changed]))


def test_agents_that_act_the_same_play_alike_unless_one_trial_differs_or_broke():
    one, two = trials("llm:a", (3, 6)), trials("llm:b", (3, 6))
    assert pair(one, two).plays_alike
    other = make_trial((1,) * 20, agent="llm:b", p=0.3, trial=12)  # fails too, by another joint
    broken = make_trial((0,), agent="llm:b", p=0.3, trial=12, broken="model")
    for last in (other, broken):
        found = pair(one, [*two[:-1], last])
        assert not found.plays_alike


def test_agents_beside_people_are_compared_with_both_kept_together():
    own = trials("llm:a", (12, 12), p=(0.0, 0.4))
    people = [
        make_trial(SOLUTION if p else FAILED, agent=f"participant:{(block - i) % 12:0>4}", p=p, trial=block + 1)
        for block in range(12)
        for i, p in enumerate((0.0, 0.4))
    ]
    found = pair(people, own)
    assert found.people
    assert found.mean(SUCCESS).value == -0.5
    assert found.changes[0.4].value == 1.0
    assert found.changes[0.4].p_value < 0.01


# Broken trials


def with_broken(agent, solved, broken=(), n=40, p=0.0):
    """Trials at one p: those of the given numbers solved or broken, all others failed."""
    return [
        make_trial((0, 1, 2), agent=agent, trial=i, p=p, broken="reply")
        if i in broken
        else make_trial(SOLUTION if i in solved else FAILED, agent=agent, trial=i, p=p)
        for i in range(n)
    ]


def some(n, seed):
    return set(np.random.default_rng(seed).permutation(40)[:n].tolist())


def test_intervals_hold_however_the_broken_trials_of_both_agents_ended_at_both_doses():
    made = {
        (i, way): with_broken(
            f"llm:{agent}", some(n, i) | {39} if way else some(n, i) - {39}, [39] * (way is None), p=p
        )
        for i, (agent, p, n) in enumerate(zip("bbaa", (0, 0.3) * 2, (12, 28, 22, 16), strict=True))
        for way in (True, False, None)
    }
    held, *ends = (
        pair(*(made[at] for at in enumerate(ways))) for ways in [(None,) * 4, *product((True, False), repeat=4)]
    )
    for of in (lambda one: one.mean(SUCCESS), lambda one: one.changes[0.3]):
        own = [of(end) for end in ends]
        assert of(held).low == pytest.approx(min(one.low for one in own))
        assert of(held).high == pytest.approx(max(one.high for one in own))

"""Agents of several studies: pairs only where luck is shared, and the numbers of an independent implementation."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from builders import SOLUTION, make_trial
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binomtest, fisher_exact
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.proportion import confint_proportions_2indep

from lockprobe.report.compare import Sample, study_differences

RNG = np.random.default_rng(5)


@cache
def one_trial(solved, agent, number):
    return make_trial(
        SOLUTION if solved else (0,) * 20, agent=agent, trial=number, broken="model" if solved is None else None
    )


def trials(solved, agent="llm:a", start=1):
    return [one_trial(None if one is None else bool(one), agent, start + i) for i, one in enumerate(solved)]


def sample(study, solved, luck=1, agent="llm:a", condition="truth", played=None):
    played = trials(solved, agent) if played is None else played
    return Sample(study=f"study {study}", agent=agent, condition=condition, luck=luck, trials=played)


def only(*samples):
    """What was found of the only two samples."""
    (one,) = study_differences(samples)
    return one.found


def random_outcomes(n=30):
    return RNG.random(n) < RNG.uniform(0.2, 0.8)


outcome = st.sampled_from([True, False, None])


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(outcome, outcome), min_size=1, max_size=30), st.randoms(use_true_random=False))
def test_one_seed_means_pairs_and_two_mean_independent_samples(solved, random):
    """None is a trial that was not played. Against scipy and statsmodels; which trial is which says nothing of two."""

    def of(study, column, luck):
        made = [one_trial(row[column], "llm:a", i) for i, row in enumerate(solved) if row[column] is not None]
        return sample(study, (), luck, played=made)

    both = np.array([row for row in solved if None not in row], dtype=int).reshape(-1, 2)
    found = study_differences([of(0, 0, 1), of(1, 1, 1)])
    assert bool(found) == bool(len(both))
    for one in found:
        gained, lost = int(np.sum(both[:, 1] > both[:, 0])), int(np.sum(both[:, 1] < both[:, 0]))
        assert (one.paired, one.found.value) == (True, pytest.approx((gained - lost) / len(both)))
        assert one.found.exchange == pytest.approx(binomtest(gained, gained + lost).pvalue if gained + lost else 1)
        assert [one.found.first.count, one.found.second.count] == both.sum(axis=0).tolist()
    first, second = ([row[i] for row in solved if row[i] is not None] for i in (0, 1))
    found = study_differences([of(0, 0, 1), of(1, 1, 2)])
    assert bool(found) == bool(first and second)
    for one in found:
        low, high = confint_proportions_2indep(sum(second), len(second), sum(first), len(first), method="newcomb")
        table = [[sum(own), len(own) - sum(own)] for own in (second, first)]
        assert (one.paired, one.found.low, one.found.high) == (False, pytest.approx(low), pytest.approx(high))
        assert one.found.p_value == pytest.approx(fisher_exact(table).pvalue)
        assert only(sample(0, random.sample(first, len(first))), sample(1, second, luck=2)) == one.found


def test_p_values_are_corrected_within_a_kind_and_a_family_as_statsmodels_does():
    samples = [
        replace(sample(study, random_outcomes(), agent=agent, condition=name), family=family)
        for name, family in (("truth", "flip rate"), ("nudge", ""), ("warn", ""))
        for study in range(3)
        for agent in ("llm:a", "random")
    ]
    samples = [replace(one, luck=7 if one.study == "study 2" else 1) for one in samples]
    found = study_differences(samples)
    kinds = [one.kind for one in found]
    assert [(kind, kinds.count(kind)) for kind in dict.fromkeys(kinds)] == [
        ("between", 9), ("between-baselines", 27), ("within-baselines", 9)
    ]  # fmt: skip
    for family in {one.family for one in found}:
        own = [one for one in found if one.family == family]
        alone = [only(one.first, one.second).p_value for one in own]
        expected = multipletests(alone, method="holm")[1]
        assert [one.found.p_value for one in own] == pytest.approx(list(expected))


@pytest.mark.parametrize("luck", [1, 2])
def test_broken_trials_that_could_turn_the_difference_leave_nothing_shown(luck):
    whole = only(sample(0, [False] * 20), sample(1, [True] * 10 + [False] * 10, luck=luck))
    few = only(sample(0, [False] * 20), sample(1, [True] * 10 + [False] * 9 + [None], luck=luck))
    turned = only(sample(0, [False] * 8 + [None] * 12), sample(1, [True] * 3 + [False] * 17, luck=luck))
    assert whole.detected()
    assert few.detected()
    assert few.p_value >= whole.p_value
    assert (turned.p_value, turned.detected()) == (1.0, False)
    assert (turned.first.count, turned.first.broken) == (0, 12)
    assert turned.first.high > 0.6  # all that broke may have been solved


def test_people_count_once_however_many_boxes_they_play():
    """The same trials, played by forty people or by eight: eight say less. They are never pairs."""

    def people(of, solved, number):
        return [
            make_trial(SOLUTION if one else (0,) * 20, agent=f"participant:{number}{i % of:02d}", trial=i + 1)
            for i, one in enumerate(solved)
        ]

    def groups(of, agent=False):
        first = sample(0, (), played=people(of, [i % of < of // 4 for i in range(40)], "a"), agent="participant")
        second = people(of, [i % of < 3 * of // 4 for i in range(40)], "b")
        other = sample(1, (), played=trials([t.solved for t in second]) if agent else second, agent="participant")
        return only(first, other)

    for agent in (False, True):
        many, few = groups(40, agent), groups(8, agent)
        assert many.value == few.value == 0.5
        assert few.high - few.low > many.high - many.low
        assert few.p_value > many.p_value

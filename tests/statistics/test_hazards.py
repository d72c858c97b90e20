"""Log-rank tests: against brute force and the library, of the right size when luck is shared, and strong."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from known_truth import Design, simulated
from scipy import stats
from solved import columns

from lockprobe.statistics.hazards import log_rank, looping

GROUP = st.lists(st.tuples(st.integers(1, 12), st.booleans()), min_size=1, max_size=15)


@given(GROUP, GROUP)
def test_the_ratio_is_observed_over_expected_events_of_the_second_over_the_first(first, other):
    last, happened = np.array([*first, *other]).T
    second, happened = np.repeat([False, True], [len(first), len(other)]), happened.astype(bool)
    expected = np.zeros(2)
    for step in range(1, last.max() + 1):
        running = last >= step
        share = np.sum(happened & (last == step)) / running.sum()
        expected += share * np.array([np.sum(running & ~second), np.sum(running & second)])
    events = np.array([np.sum(happened & ~second), np.sum(happened & second)])
    found = log_rank(last, happened, second, np.arange(len(last)))
    if events[0] and expected.min() > 1e-9:
        assert found.value == pytest.approx((events[1] / expected[1]) / (events[0] / expected[0]))
    if abs(events[1] - expected[1]) > 1e-9:
        assert found.direction == np.sign(events[1] - expected[1])


P = np.array([0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
RISING = (0.23, 0.4, 0.53, 0.63, 0.67, 0.6, 0.5)
TRAP = (0.4, 0.3, 0.2, 0.1, 0.05, 0.05, 0.05)
BUDGET = 20


def world(rng, success=RISING, trap=(0.0,) * 7, n=30, shared=0.0):
    """Trials that may fall into a cycle, and a clock that solves them and knows nothing of the actions."""
    design = Design(repetitions=1, trials=n)
    return simulated("no-effect", rng, design, success=success, trap=trap, shared=shared)


def of_rows(rows):
    """Trials from rows of (p, trial, length, onset)."""
    p, trial, length, onset = zip(*rows, strict=True)
    return columns(p, trial, length=length, onset=onset)


def test_onset_is_censored_where_the_trial_ends():
    short = of_rows([(0.0, i, 6, 0) for i in range(1, 9)] + [(0.4, i, 20, 8) for i in range(1, 9)])
    found = looping(short)  # nobody at p = 0 ran on to step 8
    assert (found.p_value, found.value) == (1.0, None)


@pytest.mark.parametrize("clusters", [2, 6, 7, 19])
def test_a_test_that_could_never_reject_is_none(clusters):
    """However clear: all loop at once under noise, none ever without. The statistic never exceeds the clusters."""
    clear = [row for i in range(clusters) for row in ((0.0, i, 20, 0), *((p, i, 6, 6) for p in P[1:].tolist()))]
    found = looping(of_rows(clear))
    assert (found.p_value is None) == (clusters <= 6)
    assert found.p_value is None or found.p_value < 0.05
    assert found.direction == 1


@pytest.mark.parametrize("shared", [0.0, 0.5])
def test_nothing_is_found_where_nothing_is_and_what_there_is_is_found(shared):
    """Loops and success have nothing to do with each other, and success differs over p; then loops trap."""
    rng = np.random.default_rng(21)
    alone, trapped = ([looping(world(rng, shared=shared, trap=trap)) for _ in range(80)] for trap in ((0.0,) * 7, TRAP))
    assert sum(one.p_value is not None and one.p_value < 0.05 for one in alone) <= stats.binom.ppf(0.999, 80, 0.06)
    assert sum(one.p_value < 0.05 and one.direction == -1 for one in trapped) >= 72

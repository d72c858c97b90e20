"""Hazard ratios: observed over expected events, counted once more, and with the worst of both ends where trials broke."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lockprobe.statistics.inference.hazard import Hazard, log_rank, worst

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
        assert found.ratio == pytest.approx((events[1] / expected[1]) / (events[0] / expected[0]))
    if abs(events[1] - expected[1]) > 1e-9:
        assert found.direction == np.sign(events[1] - expected[1])


@pytest.mark.parametrize(
    ("ends", "p_value"),
    [(((1, 0.2), (1, 0.01)), 0.2), (((1, 0.01), (-1, 0.01)), 1.0), (((1, 0.01), (1, None)), None)],
)
def test_of_both_ends_the_worse_counts(ends, p_value):
    found = Hazard(ratio=2.0, direction=1, p_value=0.02)
    of = [Hazard(ratio=None, direction=way, p_value=p) for way, p in ends]
    assert worst(found, of) == Hazard(ratio=2.0, direction=1, p_value=p_value)

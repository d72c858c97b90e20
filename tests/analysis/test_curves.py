"""Proportions and success curves have known values, stay in range, and leave errors out."""

import math

import pytest
from builders import SOLUTION, make_trial

from lockprobe.analysis.curves import success_curve
from lockprobe.analysis.outcomes import ended
from lockprobe.analysis.proportions import difference, proportion


@pytest.mark.parametrize(
    ("count", "n", "low", "high"),
    [(7, 30, 0.118, 0.409), (20, 30, 0.488, 0.808), (8, 10, 0.490, 0.943), (10, 10, 0.722, 1.0), (0, 30, 0.0, 0.114)],
)
def test_wilson_intervals_are_those_of_the_notes(count, n, low, high):
    share = proportion(count, n)
    assert share.value == count / n
    assert (share.low, share.high) == (pytest.approx(low, abs=6e-4), pytest.approx(high, abs=6e-4))


def test_nothing_counted_means_nothing_known():
    share = proportion(0, 0)
    assert math.isnan(share.value)
    assert (share.low, share.high) == (0.0, 1.0)


def test_the_papers_difference():
    found = difference(proportion(7, 30), proportion(20, 30))
    assert found.value == pytest.approx(13 / 30)
    assert (found.low, found.high) == (pytest.approx(0.182, abs=1e-3), pytest.approx(0.616, abs=1e-3))
    assert found.p_value == pytest.approx(0.0016, abs=1e-4)
    assert difference(proportion(0, 0), proportion(20, 30)) is None


def trials():
    detour = (0, 0, *SOLUTION)
    return [
        make_trial(SOLUTION, trial=1),
        make_trial(SOLUTION, trial=2),
        make_trial(detour, trial=3),
        make_trial([0] * 20, trial=4),
        make_trial([0], trial=5, broken="model"),
    ]


def test_curve_counts_by_hand():
    curve = success_curve(trials())
    assert (curve.n, curve.errors, curve.solved_at) == (4, 1, (4, 4, 6))
    assert curve.steps == tuple(range(21))
    assert curve.share[3:7] == (0.0, 0.5, 0.5, 0.75)
    assert (curve.steps_to(0.5), curve.steps_to(0.75), curve.steps_to(0.8)) == (4, 6, None)
    assert (curve.median_steps, curve.mean_steps) == (4.0, pytest.approx(14 / 3))


def test_curve_rises_within_its_band():
    curve = success_curve(trials())
    assert list(curve.share) == sorted(curve.share)
    assert all(
        0 <= low <= share <= high <= 1 for low, share, high in zip(curve.low, curve.share, curve.high, strict=True)
    )


def test_an_error_is_not_a_failure():
    assert len(ended(trials())) == 4
    assert success_curve(trials()).share[-1] == success_curve(trials()[:4]).share[-1]


def test_curve_of_nothing_solved():
    curve = success_curve([make_trial([0] * 20)])
    assert set(curve.share) == {0.0}
    assert curve.median_steps is None
    assert success_curve([]).n == 0

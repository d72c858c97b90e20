"""A figure of the paper beside one of ours."""

import pytest

from lockprobe.report.claims.claim_tests import pattern, same_step, verdict_of
from lockprobe.statistics.summary import summarise


def test_a_step_outside_of_its_interval_is_not_compatible(modal):
    symbolic = summarise(modal).agents[2].conditions[0]
    assert same_step(symbolic, 15)[1] == "compatible"
    assert same_step(symbolic, 9)[1] == "not compatible"


def test_a_verdict_needs_the_figure_and_the_pattern():
    assert [verdict_of(0.5, also) for also in ("shown", "open", "opposite")] == [
        "compatible", "not decided", "not compatible",
    ]  # fmt: skip
    assert [verdict_of(0.01, also) for also in ("shown", "open", "opposite")] == ["not compatible"] * 3


@pytest.mark.parametrize(
    ("p_value", "direction", "expected"),
    [(0.04, 1, "shown"), (0.04, -1, "opposite"), (0.05, 1, "open"), (None, 1, "open"), (0.01, 0, "open")],
)
def test_a_pattern_is_shown_by_a_test_that_rejects_in_its_direction(p_value, direction, expected):
    assert pattern(p_value, direction) == expected

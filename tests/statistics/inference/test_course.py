"""How success goes over p, in one word."""

import numpy as np
import pytest

from lockprobe.statistics.inference import ushape
from lockprobe.statistics.inference.course import course
from lockprobe.statistics.inference.difference import any_difference
from lockprobe.statistics.inference.ushape import TwoLines, corrected, two_lines
from lockprobe.statistics.outcomes import Outcomes, points

TENTHS = tuple(i / 10 for i in range(11))


def drawn(shares, n=300, seed=1):
    """Trials with these shares solved over p from 0 to 1, luck not shared."""
    p = np.repeat(TENTHS[: len(shares)], n)
    solved = np.random.default_rng(seed).random(len(p)) < np.repeat(shares, n)
    trial = np.tile(np.arange(1, n + 1), len(shares))
    ones = np.ones(len(p), dtype=np.int64)
    return Outcomes(dose=p, repetition=ones, trial=trial, length=10 * ones, solved=solved, onset=0 * ones)


@pytest.fixture
def without_slopes(monkeypatch):
    """The two-lines test without the slopes of its lines, for speed: p-values and directions do not use them."""
    monkeypatch.setattr(ushape, "logit_fit", lambda *_: None)


def found(shares, permutations=2000, **settings):
    outcomes = drawn(shares, **settings)
    return course(
        points(outcomes, by_repetition=False),
        any_difference(outcomes, np.random.default_rng(2), permutations),
        two_lines(outcomes.dose, outcomes.solved),
    )


@pytest.mark.parametrize(
    ("shares", "kind"),
    [
        ([0.5] * 11, "no change detectable"),
        ([0.3, 0.4, 0.5, 0.55, 0.6, 0.62, 0.63, 0.64, 0.64, 0.64, 0.64], "rises"),
        ([1.0, 0.86, 0.74, 0.67, 0.63, 0.62, 0.6, 0.5, 0.5, 0.5, 0.5], "falls"),
        ([0.2, 0.3, 0.4, 0.5, 0.55, 0.6, 0.55, 0.5, 0.4, 0.3, 0.2], "rises and falls"),
        ([0.3, 0.4, 0.5, 0.6, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.0], "rises and falls"),
        ([0.9, 0.7, 0.5, 0.4, 0.3, 0.2, 0.3, 0.4, 0.5, 0.7, 0.9], "falls and rises"),
        ([0.5], "not tested"),
    ],
)
def test_each_course_is_told_from_the_others(shares, kind):
    assert found(shares).kind == kind


def test_a_course_names_its_ends_and_extremes():
    seen = found([0.2, 0.5, 0.9, 0.5, 0.3])
    assert (seen.highest_dose, seen.lowest_dose) == (0.2, 0.0)
    assert abs(seen.first - 0.2) < 0.08
    assert abs(seen.last - 0.3) < 0.1
    assert seen.highest > 0.8


def test_where_nothing_happens_a_course_is_rarely_seen(without_slopes):
    """Two tests at 5 %, one of them cautious: at most a tenth of studies, here 100 of them."""
    seen = [found([0.5] * 7, 199, n=30, seed=seed).kind for seed in range(100)]
    assert sum(kind != "no change detectable" for kind in seen) <= 15


def test_without_trials_there_is_no_course():
    outcomes = drawn([0.5]).at(np.zeros(300, dtype=bool))
    assert (
        course([], any_difference(outcomes, np.random.default_rng(2)), two_lines(outcomes.dose, outcomes.solved))
        is None
    )


def many(agents, study, shares=(0.5,) * 7, n=20):
    """The courses of agents that play alike, each judged by itself, and judged together."""
    kinds = [], []
    for agent in range(agents):
        drawing = drawn(list(shares), n=n, seed=1000 * study + agent)
        lines = two_lines(drawing.dose, drawing.solved)
        for size, found in zip((1, agents), kinds, strict=True):
            difference = any_difference(drawing, np.random.default_rng(study), 199, agents=size)
            found.append(course(points(drawing, by_repetition=False), difference, corrected(lines, size)).kind)
    return kinds


def test_over_many_agents_a_course_is_seldom_said_that_is_none(without_slopes):
    """Thirteen agents to whom p does nothing: without correction some course is seen in half of the studies."""
    seen = [[any(kind != "no change detectable" for kind in kinds) for kinds in many(13, study)] for study in range(25)]
    alone, together = zip(*seen, strict=True)
    assert np.mean(alone) > 0.25
    assert np.mean(together) <= 0.05 + 2.5 * np.sqrt(0.05 * 0.95 / 25)


def test_many_agents_that_rise_are_still_seen_to(without_slopes):
    assert many(10, 1, (0.2, 0.6, 0.8), 60)[1] == ["rises"] * 10


def test_two_lines_are_corrected_for_the_agents():
    found = TwoLines(p_value=0.02, direction="inverted U")
    assert corrected(found, 1) is found
    assert (corrected(found, 2).p_value, corrected(found, 2).direction) == (0.04, "inverted U")
    assert (corrected(found, 3).p_value, corrected(found, 3).direction) == (0.06, None)
    assert corrected(TwoLines(), 9).p_value is None

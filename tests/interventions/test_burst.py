"""As many false reports as of a flip, in runs."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.burst import Burst
from lockprobe.trial.record import Moment, Percept, Task

TRUTH = Percept(joint="A", outcome="blocked", positions=(False, False))
TASK = Task(joints=("A", "B"), target="B", budget=20)
STEPS = 20_000


def false_ones(burst, seed=1):
    """Which of many reports in one trial are false."""
    rng = np.random.default_rng(seed)
    past = (Moment(was=replace_joint(None), told=replace_joint(None)),)
    found = np.zeros(STEPS, bool)
    for at in range(STEPS):
        told = burst.perceive(TRUTH, past[-2:] if at else past, TASK, rng)
        found[at] = told.outcome == "moved"
        past = (past[0], Moment(was=TRUTH, told=told, chosen="A", attempted="A"))
    return found


def replace_joint(joint):
    return Percept(joint=joint, positions=(False, False))


@pytest.mark.parametrize(("p", "length"), [(0.2, 3.0), (0.4, 4.0), (0.3, 1.0)])
def test_rate_runs_and_correlation_are_as_stated(p, length):
    found = false_ones(Burst(p=p, length=length))
    correlation = 1 - 1 / length - p / (length * (1 - p))
    spread = np.sqrt(p * (1 - p) * (1 + correlation) / (1 - correlation) / STEPS)
    assert abs(found.mean() - p) < 4 * spread
    assert np.corrcoef(found[:-1], found[1:])[0, 1] == pytest.approx(correlation, abs=4 / np.sqrt(STEPS))
    ends = np.flatnonzero(np.diff(np.concatenate([[0], found.astype(int), [0]])))
    runs = ends[1::2] - ends[::2]
    assert runs.mean() == pytest.approx(length, rel=4 * runs.std() / runs.mean() / np.sqrt(len(runs)) + 1e-9)


def test_runs_of_one_length_are_independent_reports():
    found = false_ones(Burst(p=0.5, length=2.0))
    assert abs(np.corrcoef(found[:-1], found[1:])[0, 1]) < 4 / np.sqrt(STEPS)


def test_a_rate_that_such_runs_cannot_have_is_refused():
    with pytest.raises(BadValue, match=r"at most 0.5 in runs of 1"):
        Burst(p=0.6, length=1.0)
    with pytest.raises(BadValue, match="length"):
        Burst(length=0.5)


class Fixed:
    """A stream that always gives one number."""

    def __init__(self, number):
        self.number = number

    def random(self):
        return self.number


def lies(burst, after_false, number):
    """Whether the report after a false or a true one is false where this number is drawn."""
    before = replace(TRUTH, outcome="moved") if after_false else TRUTH
    first = Moment(was=replace_joint(None), told=replace_joint(None))
    past = (first, Moment(was=TRUTH, told=before, chosen="A", attempted="A"))
    return burst.perceive(TRUTH, past, TASK, Fixed(number)).outcome == "moved"


@given(st.floats(0.01, 0.6), st.floats(2, 50))
def test_the_chain_has_the_stated_rate_and_correlation_exactly(p, length):
    """The chances are those at which the numbers drawn begin to make no lie; rate and correlation follow from them."""
    burst = Burst(p=p, length=length)
    stay, begin = 1 - 1 / length, p / (length * (1 - p))
    for after_false, chance in ((True, stay), (False, begin)):
        assert lies(burst, after_false, chance * (1 - 1e-12))
        assert not lies(burst, after_false, chance * (1 + 1e-12))
    assert p * stay + (1 - p) * begin == pytest.approx(p, abs=1e-12)
    assert (p * stay - p * p) / (p * (1 - p)) == pytest.approx(1 - 1 / length - p / (length * (1 - p)), abs=1e-9)
    assert burst.perceive(TRUTH, (Moment(was=TRUTH, told=TRUTH),), TASK, Fixed(p * (1 - 1e-12))).outcome == "moved"
    assert burst.perceive(TRUTH, (Moment(was=TRUTH, told=TRUTH),), TASK, Fixed(p * (1 + 1e-12))).outcome == "blocked"

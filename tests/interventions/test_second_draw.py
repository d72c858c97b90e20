"""The second number of a draw: the same for a number and for arrays, even, and another one for every joint."""

import numpy as np
import pytest

from lockprobe.interventions.second_draw import survival

DRAWN = np.random.default_rng(1).random(20_000)


def test_an_array_has_the_numbers_of_its_entries():
    assert survival(DRAWN[:50], 3).tolist() == [survival(one, 3) for one in DRAWN[:50].tolist()]
    assert survival(0.0, 0) == survival(np.zeros(1), 0)[0]


def test_the_numbers_are_even_and_tell_nothing_of_the_draw_or_of_another_joint():
    found = np.array([DRAWN, *(survival(DRAWN, place) for place in range(4))])
    assert found[1:].min() >= 0
    assert found[1:].max() < 1
    assert found.mean(axis=1) == pytest.approx(np.full(5, 0.5), abs=0.01)
    assert np.corrcoef(found) == pytest.approx(np.eye(5), abs=0.03)

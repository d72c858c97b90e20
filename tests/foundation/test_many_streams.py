"""Many streams at once give what each gives alone."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lockprobe.foundation.many_streams import FEW, first_numbers, generators
from lockprobe.foundation.seeds import trial_stream

names = st.sampled_from(["channel-0", "labels", "agent"])
one = st.tuples(st.integers() | st.integers(0, 2**63), st.integers(1, 10**6), st.integers(1, 10**6))


@pytest.mark.parametrize("size", [1, FEW, FEW + 1, 40])
@given(st.data(), names, st.integers(1, 30))
def test_numbers_are_those_of_the_trials(size, data, name, count):
    trials = data.draw(st.lists(one, min_size=size, max_size=size))
    each = [trial_stream(*trial, name).random(count).tolist() for trial in trials]
    assert first_numbers(trials, name, count).tolist() == each


@pytest.mark.parametrize("size", [1, FEW, FEW + 1, 40])
@given(st.data(), names)
def test_a_generator_draws_as_its_trial_does(size, data, name):
    trials = data.draw(st.lists(one, min_size=size, max_size=size))
    for rng, trial in zip(generators(trials, name), trials, strict=True):
        alone = trial_stream(*trial, name)
        for count in (4, 7):  # an odd number of draws of 32 bits, of which two come from one of 64
            assert rng.permutation(count).tolist() == alone.permutation(count).tolist()
        assert rng.random() == alone.random()


def test_of_no_trial_there_is_nothing():
    assert first_numbers([], "agent", 3).shape == (0, 3)
    assert list(generators([], "agent")) == []

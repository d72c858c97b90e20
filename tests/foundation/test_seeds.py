"""The seed matters, it suffices, and many streams at once give what each gives alone."""

import hashlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lockprobe.foundation.many_streams import FEW, first_numbers, generators
from lockprobe.foundation.seeds import generator, integer_seed, trial_stream


def test_every_part_of_the_path_matters():
    places = [(1, "a", 2), (2, "a", 2), (1, "b", 2), (1, "a", 3), (1, "a"), (1, "a2"), (1, "a", "2", "x")]
    assert len({generator(*place).random() for place in [*places, *places]}) == len(places)


def test_the_streams_are_pinned():
    """Records of an earlier release must be reproducible: these numbers must not be changed."""
    assert generator(1, "rep", 1, "trial", 1, "labels").random() == 0.7618068731319974
    assert integer_seed(1, "x") == integer_seed(1, "x")
    assert 0 <= integer_seed(1, "x") < 2**31


def test_a_stream_is_seeded_by_the_first_128_bits_of_a_hash():
    for number in range(300):  # some of them begin or end with a word of few bits
        digest = hashlib.sha256(f"1/{number}".encode()).digest()
        seeded = np.random.Generator(np.random.PCG64(int.from_bytes(digest[:16], "little")))
        assert generator(1, number).bit_generator.state == seeded.bit_generator.state


def test_words_of_zeros_are_words_of_a_number():
    for number in (0, 1, 1 << 32, 1 << 96, (1 << 96) - 1):
        words = np.frombuffer(number.to_bytes(16, "little"), dtype="<u4")
        assert np.random.PCG64(words).state == np.random.PCG64(number).state


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

"""Many trials at once, and long sequences: the same numbers as alone."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from loop_definition import copies

from lockprobe.foundation.errors import BadValue
from lockprobe.statistics.loops import any_loop, any_loop_batch, cover, measure, onset, onset_batch
from lockprobe.statistics.loops.covering import TRIAL_LENGTH

COLUMNS = ("n", "any_loop", "covered", "onset")

TRIALS = st.lists(st.integers(0, 3), max_size=30) | st.tuples(
    st.lists(st.integers(0, 3), min_size=1, max_size=6), st.integers(2, 6)
).map(lambda cycle: cycle[0] * cycle[1])


@settings(deadline=None, max_examples=60)
@given(trials=st.lists(TRIALS, max_size=8), overlap=st.booleans(), min_length=st.integers(1, 5))
def test_a_batch_is_its_trials_one_by_one(trials: list[list[int]], overlap: bool, min_length: int) -> None:
    given_ = {"overlap": overlap, "min_length": min_length}
    found = measure(trials, **given_)
    assert len(found) == len(trials)
    covers = [cover(trial, **given_) for trial in trials]
    assert found.n.tolist() == [one.n for one in covers]
    assert found.any_loop.tolist() == [any_loop(trial, **given_) for trial in trials]
    assert found.covered.tolist() == [one.covered for one in covers]
    assert found.share.tolist() == [one.share for one in covers]
    assert found.onset.tolist() == [onset(trial, **given_) for trial in trials]


def test_short_pieces_cover_as_much_as_long_ones(monkeypatch) -> None:
    rng = np.random.default_rng(11)
    trials = [rng.integers(0, k, n).tolist() for k in (2, 4, 30) for n in (5, 50, 200)]
    trials += [rng.integers(0, 4, 9).tolist() * 5, rng.integers(0, 50, 60).tolist() * 2]
    for overlap in (False, True):
        whole = [cover(trial, overlap=overlap) for trial in trials]
        with monkeypatch.context() as patch:
            patch.setattr("lockprobe.statistics.loops.covering.TRIAL_LENGTH", 0)
            short = [cover(trial, overlap=overlap) for trial in trials]
        assert [found.covered for found in short] == [found.covered for found in whole]
        for trial, found in zip(trials, short, strict=True):
            assert all(3 <= length <= 5 for _, length in found.intervals)
            assert set(found.words) <= copies(trial, 3, overlap).keys()


@given(trials=st.lists(st.lists(st.integers(0, 2), min_size=12, max_size=12), min_size=1, max_size=9))
def test_an_array_a_list_and_names_are_measured_alike(trials: list[list[int]]) -> None:
    array = np.array(trials, dtype=np.int8)
    found = measure(array)
    assert found.onset.tolist() == onset_batch(array).tolist()
    for other in (trials, list(array), ["".join("xyz"[a] for a in trial) for trial in trials], array - 2):
        for column in COLUMNS:
            assert np.array_equal(getattr(measure(other), column), getattr(found, column)), column


def test_bad_batches_are_refused() -> None:
    for sequences in (np.zeros(3, dtype=int), np.zeros((2, 2, 2), dtype=int)):
        with pytest.raises(BadValue, match="trials, n"):
            measure(sequences)
    with pytest.raises(BadValue, match="at least 1"):
        measure(["ABC"], min_length=0)
    for rows in (2, TRIAL_LENGTH + 1):
        for least in (1, 3, rows + 1):
            with pytest.raises(BadValue, match=r"\(n,\)"):
                cover(np.zeros((rows, 2), dtype=int), min_length=least)
    assert len(measure([])) == len(measure(np.zeros((0, 20), dtype=int))) == 0
    assert measure(np.zeros((2, 0), dtype=int)).n.tolist() == [0, 0]


@pytest.mark.parametrize("overlap", [False, True])
def test_no_trial_holds_a_loop_longer_than_itself(overlap: bool) -> None:
    sequence = [1, 2, 3] * TRIAL_LENGTH
    for least in (len(sequence) + 1, 10**20):
        found = cover(sequence, min_length=least, overlap=overlap)
        assert (found.any_loop, found.intervals) == (False, ())
        assert not measure([sequence, [1, 2, 1, 2]], min_length=least, overlap=overlap).any_loop.any()


@pytest.mark.parametrize("overlap", [False, True])
def test_long_shortest_loops_in_a_batch(overlap: bool) -> None:
    trials = np.random.default_rng(9).integers(0, 2, (40, 12)).repeat(2, axis=1)
    for least in range(1, 14):
        expected = [onset(trial, min_length=least, overlap=overlap) for trial in trials]
        assert onset_batch(trials, min_length=least, overlap=overlap).tolist() == expected
        assert any_loop_batch(trials, min_length=least, overlap=overlap).tolist() == [step > 0 for step in expected]


NAN = float("nan")


@pytest.mark.parametrize("length", [7, 5007])
@pytest.mark.parametrize("of_one", [cover, any_loop, onset])
def test_what_is_not_itself_is_no_action_in_any_container(of_one, length) -> None:
    numbers = [1.0, 2.0, NAN, 1.0, 2.0, NAN, *range(length - 6)]
    days = np.array(["NaT", *["2024-01-01"] * (length - 1)])
    kept = [numbers, tuple(numbers), np.array(numbers), np.array(numbers, dtype=object)]
    for sequence in [*kept, days.astype("datetime64[D]"), days.astype("datetime64[ns]")]:
        with pytest.raises(BadValue, match="sequence: got 'NaN', expected one action per step; give trials of"):
            of_one(sequence)
        with pytest.raises(BadValue, match="NaN"):
            of_one(sequence, min_length=length + 1)


def test_nor_in_many_trials_at_once() -> None:
    padded = [[1.0, 2.0, NAN, NAN], [1.0, 2.0, 3.0, 4.0]]
    for of_many in (measure, any_loop_batch, onset_batch):
        for sequences in (np.array(padded), np.array(padded).astype("datetime64[s]")):
            with pytest.raises(BadValue, match="trials of different length as a list"):
                of_many(sequences)
    with pytest.raises(BadValue, match="trials of different length as a list"):
        measure(padded)


def test_floats_are_actions_like_others() -> None:
    trial = [0.5, 1.5, 2.5] * 2
    assert cover(np.array(trial)) == cover(trial)
    assert measure(np.array([trial])).onset.tolist() == onset_batch(np.array([trial])).tolist() == [6]

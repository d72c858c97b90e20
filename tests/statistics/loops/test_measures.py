"""Many trials at once, long sequences, compiled or not: all the same numbers."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from loop_definition import copies, patterns

from lockprobe.foundation.errors import BadValue
from lockprobe.statistics.loops import (
    any_loop,
    any_loop_batch,
    cover,
    kernels,
    longest_loop,
    measure,
    onset,
    onset_batch,
)
from lockprobe.statistics.loops.words import TRIAL_LENGTH

COLUMNS = ("n", "any_loop", "covered", "redundant", "onset", "longest")

TRIALS = st.lists(st.integers(0, 3), max_size=30) | st.tuples(
    st.lists(st.integers(0, 3), min_size=1, max_size=6), st.integers(2, 6)
).map(lambda cycle: cycle[0] * cycle[1])


@pytest.fixture
def at_once(monkeypatch):
    """Compiles whatever can be compiled."""
    pytest.importorskip("numba")
    monkeypatch.setattr(kernels, "WORTH_COMPILING", 0)


@pytest.fixture(autouse=True)
def first_call(monkeypatch):
    """Nothing was asked before."""
    monkeypatch.setattr(kernels, "_ASKED", Counter())


@contextmanager
def without_numba() -> Iterator[None]:
    """A machine without numba, whatever was compiled before."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(kernels, "_COMPILED", {})
        patch.setitem(sys.modules, "numba", None)
        patch.setattr(kernels, "WORTH_COMPILING", 0)
        yield


def long_sequences() -> list[list[int]]:
    """Just above a trial's length: random over few and many actions, a cycle, halves, one action, all distinct."""
    rng = np.random.default_rng(3)
    n = TRIAL_LENGTH + 101
    half = rng.integers(0, 2**40, n // 2).tolist()
    return [
        *(rng.integers(-k, k, n).tolist() for k in (1, 2, 40)),
        list(range(7)) * (n // 7),
        half + half,
        [5] * n,
        list(range(n)),
    ]


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
    assert found.redundant.tolist() == [one.redundant for one in covers]
    assert found.share.tolist() == [one.share for one in covers]
    assert found.onset.tolist() == [onset(trial, **given_) for trial in trials]
    assert found.longest.tolist() == [longest_loop(trial, **given_) for trial in trials]


@pytest.mark.parametrize("overlap", [False, True])
@pytest.mark.parametrize("min_length", [1, 2, 3, 5])
def test_compiled_and_plain_measures_are_the_same(at_once, overlap: bool, min_length: int) -> None:
    trials = [*patterns(2, 8), *patterns(4, 5)]
    rng = np.random.default_rng(min_length)
    trials += [tuple(rng.integers(0, 3, n)) for n in range(0, 60, 3)]
    trials += [tuple(rng.integers(0, 9, 1 + n % 7)) * (n % 6) for n in range(42)]
    with without_numba():
        plainly = measure(trials, overlap=overlap, min_length=min_length)
    compiled = measure(trials, overlap=overlap, min_length=min_length)
    assert "free_measures" in kernels._COMPILED
    for column in COLUMNS:
        assert np.array_equal(getattr(compiled, column), getattr(plainly, column)), column


@pytest.mark.parametrize("overlap", [False, True])
@pytest.mark.parametrize("min_length", [1, 3])
def test_compiled_and_plain_covers_of_long_sequences_are_the_same(at_once, overlap: bool, min_length: int) -> None:
    with without_numba():
        plainly = [cover(sequence, overlap=overlap, min_length=min_length) for sequence in long_sequences()]
    assert [found.covered for found in plainly[-4:]] == [*(found.n for found in plainly[-4:-1]), 0]
    assert [cover(sequence, overlap=overlap, min_length=min_length) for sequence in long_sequences()] == plainly
    assert "free_cover" in kernels._COMPILED


def test_short_pieces_cover_as_much_as_long_ones(monkeypatch) -> None:
    rng = np.random.default_rng(11)
    trials = [rng.integers(0, k, n).tolist() for k in (2, 4, 30) for n in (5, 50, 200)]
    trials += [rng.integers(0, 4, 9).tolist() * 5, rng.integers(0, 50, 60).tolist() * 2]
    for overlap in (False, True):
        whole = [cover(trial, overlap=overlap) for trial in trials]
        with monkeypatch.context() as patch:
            patch.setattr("lockprobe.statistics.loops.exact_cover.TRIAL_LENGTH", 0)
            short = [cover(trial, overlap=overlap) for trial in trials]
        assert [found.covered for found in short] == [found.covered for found in whole]
        for trial, found in zip(trials, short, strict=True):
            assert all(3 <= length <= 5 for _, length in found.intervals)
            assert set(found.words) <= copies(trial, 3, overlap).keys()


def test_long_sequences_in_a_batch_are_measured_as_alone(at_once) -> None:
    sequences = long_sequences()
    found = measure([[1, 2, 3] * 2, *sequences, []])
    assert found.n.tolist() == [6, *map(len, sequences), 0]
    assert found.covered.tolist() == [6, *(cover(one).covered for one in sequences), 0]
    assert found.redundant.tolist() == [3, *(cover(one).redundant for one in sequences), 0]
    assert found.onset.tolist() == [6, *(onset(one) for one in sequences), 0]
    assert found.longest.tolist() == [3, *(longest_loop(one) for one in sequences), 0]


def test_the_longest_loop_of_long_sequences() -> None:
    n = TRIAL_LENGTH + 101
    _, _, _, cycle, halves, alike, distinct = long_sequences()
    assert longest_loop(halves) == n // 2
    assert longest_loop(alike) == n // 2
    assert longest_loop(alike, overlap=True) == n - 1
    assert longest_loop(cycle) == len(cycle) // 14 * 7
    assert longest_loop(distinct) == 0
    assert longest_loop(halves, min_length=n // 2 + 1) == 0


@pytest.mark.parametrize("overlap", [False, True])
def test_the_longest_loop_is_found_by_both_ways(monkeypatch, overlap: bool) -> None:
    rng = np.random.default_rng(5)
    trials = [*patterns(3, 6), *(tuple(rng.integers(0, 2, n).tolist()) for n in range(40))]
    expected = [max(map(len, copies(trial, 2, overlap)), default=0) for trial in trials]
    assert [longest_loop(trial, overlap=overlap, min_length=2) for trial in trials] == expected
    monkeypatch.setattr("lockprobe.statistics.loops.words.TRIAL_LENGTH", 0)
    trials, expected = trials[1:], expected[1:]
    assert [longest_loop(trial, overlap=overlap, min_length=2) for trial in trials] == expected


@given(trials=st.lists(st.lists(st.integers(0, 2), min_size=12, max_size=12), min_size=1, max_size=9))
def test_an_array_a_list_and_names_are_measured_alike(trials: list[list[int]]) -> None:
    array = np.array(trials, dtype=np.int8)
    found = measure(array)
    assert found.onset.tolist() == onset_batch(array).tolist()
    for other in (trials, list(array), ["".join("xyz"[a] for a in trial) for trial in trials], array - 2):
        for column in COLUMNS:
            assert np.array_equal(getattr(measure(other), column), getattr(found, column)), column


@pytest.mark.parametrize("numba", [True, False])
def test_what_kind_of_sequence_it_is_does_not_matter(numba: bool, request) -> None:
    if numba:
        request.getfixturevalue("at_once")
    rng = np.random.default_rng(2)
    for n in (40, 100, 300, TRIAL_LENGTH + 1):
        numbers = rng.integers(0, 5, n)
        expected = cover(numbers.tolist())
        assert cover(numbers) == expected
        assert cover(tuple(numbers.tolist())) == expected
        assert cover("".join(chr(65 + a) for a in numbers)).intervals == expected.intervals
        assert cover([f"joint {a}" for a in numbers]).intervals == expected.intervals
        assert cover([a or "none" for a in numbers.tolist()]).intervals == expected.intervals
        assert cover([a or (1, 2) for a in numbers.tolist()]).intervals == expected.intervals
        assert cover([a or 2**70 for a in numbers.tolist()]).intervals == expected.intervals
        assert cover(np.array([f"joint {a}" for a in numbers])).words[0][0].startswith("joint")
        assert all(type(action) is int for word in cover(numbers).words for action in word)


def test_a_trial_imports_no_compiler() -> None:
    import subprocess

    program = (
        "import sys; from lockprobe.statistics.loops import cover, measure; "
        "[cover('ABCDABCDABCDABCDABCD', rule=rule) for rule in ('free', 'repeat', 'whole')]; measure(['ABCABC'] * 30); "
        "assert not {'numba', 'scipy.optimize'} & sys.modules.keys()"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


def test_what_is_compiled_depends_on_all_work_so_far(monkeypatch) -> None:
    pytest.importorskip("numba")
    monkeypatch.setattr(kernels, "_COMPILED", {})
    monkeypatch.setattr(kernels, "WORTH_COMPILING", 1000)
    for _ in range(100):
        cover("ABCD" * 5)  # too short to gain
    for _ in range(9):
        cover("ABCD" * 25)
    assert not kernels._COMPILED
    cover("ABCD" * 25)
    assert list(kernels._COMPILED) == ["free_cover"]


def test_without_numba_nothing_is_compiled() -> None:
    with without_numba():
        assert kernels.compiled(kernels.free_cover, 10**9) is None
        assert kernels._COMPILED == {"free_cover": None}  # so it is looked for once
        assert measure(["ABCABC"]).covered.tolist() == [6]


def test_where_nothing_can_be_kept_it_is_compiled_all_the_same(at_once, monkeypatch) -> None:
    numba = pytest.importorskip("numba")

    def njit(function=None, *, cache=False):
        if cache:
            raise RuntimeError("cannot cache function: no locator available")
        return function  # as it stands, in plain Python

    trials = [*patterns(2, 7), tuple(range(4)) * 5]
    expected = measure(trials).redundant.tolist()
    monkeypatch.setattr(kernels, "_COMPILED", {})
    monkeypatch.setattr(numba, "njit", njit)
    assert measure(trials).redundant.tolist() == expected
    assert {"free_measures": kernels.free_measures} == kernels._COMPILED


def test_bad_batches_are_refused() -> None:
    for sequences in (np.zeros(3, dtype=int), np.zeros((2, 2, 2), dtype=int)):
        with pytest.raises(BadValue, match="trials, n"):
            measure(sequences)
    with pytest.raises(BadValue, match="at least 1"):
        measure(["ABC"], min_length=0)
    for rows in (2, 100, TRIAL_LENGTH + 1):
        for least in (1, 3, rows + 1):
            with pytest.raises(BadValue, match=r"\(n,\)"):
                cover(np.zeros((rows, 2), dtype=int), min_length=least)
    assert len(measure([])) == len(measure(np.zeros((0, 20), dtype=int))) == 0
    assert measure(np.zeros((2, 0), dtype=int)).n.tolist() == [0, 0]


@pytest.mark.parametrize("overlap", [False, True])
def test_no_trial_holds_a_loop_longer_than_itself(at_once, overlap: bool) -> None:
    sequence = [1, 2, 3] * TRIAL_LENGTH
    for least in (len(sequence) + 1, 10**20):
        found = cover(sequence, min_length=least, overlap=overlap)
        assert (found.any_loop, found.intervals, longest_loop(sequence, min_length=least, overlap=overlap)) == (
            False,
            (),
            0,
        )
        assert not measure([sequence, [1, 2, 1, 2]], min_length=least, overlap=overlap).any_loop.any()


@pytest.mark.parametrize("overlap", [False, True])
def test_long_shortest_loops_in_a_batch(overlap: bool) -> None:
    trials = np.random.default_rng(9).integers(0, 2, (40, 12)).repeat(2, axis=1)
    for least in range(1, 14):
        expected = [onset(trial, min_length=least, overlap=overlap) for trial in trials]
        assert onset_batch(trials, min_length=least, overlap=overlap).tolist() == expected
        assert any_loop_batch(trials, min_length=least, overlap=overlap).tolist() == [step > 0 for step in expected]

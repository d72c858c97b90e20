"""Action loops against their definition: brute force on every short trial, laws on longer ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from loop_definition import copies

from lockprobe.foundation.errors import BadValue
from lockprobe.statistics.loops import (
    LONGEST_ILP,
    LoopCover,
    Solver,
    any_loop,
    any_loop_batch,
    cover,
)

SOLVERS: tuple[Solver, ...] = ("dp", "ilp")

TRIALS = st.integers(2, 4).flatmap(lambda k: st.lists(st.integers(0, k - 1), max_size=20)).map(tuple)
CYCLES = st.tuples(st.lists(st.integers(0, 3), min_size=1, max_size=6), st.integers(2, 6)).map(
    lambda cycle: tuple(cycle[0] * cycle[1])[:20]
)


def assert_lawful(trial: Sequence[int], found: LoopCover, overlap: bool, min_length: int) -> None:
    """What holds of every cover: disjoint pieces, each a copy of a loop."""
    words = copies(trial, min_length, overlap)
    assert found.n == len(trial)
    assert found.any_loop == bool(words)
    assert found.covered == sum(length for _, length in found.intervals)
    ends = [0] + [start + length for start, length in found.intervals]
    assert all(start >= end for (start, _), end in zip(found.intervals, ends, strict=False))
    assert ends[-1] <= found.n
    chosen = dict.fromkeys(tuple(trial[start : start + length]) for start, length in found.intervals)
    assert tuple(chosen) == found.words
    assert chosen.keys() <= words.keys()


@settings(deadline=None, max_examples=60)
@given(trial=TRIALS | CYCLES, overlap=st.booleans(), min_length=st.integers(1, 5))
def test_both_solvers_cover_equally_much(trial: tuple[int, ...], overlap: bool, min_length: int) -> None:
    exact, literal = (cover(trial, overlap=overlap, min_length=min_length, solver=solver) for solver in SOLVERS)
    assert exact.covered == literal.covered
    assert exact.any_loop == literal.any_loop
    assert_lawful(trial, exact, overlap, min_length)
    assert_lawful(trial, literal, overlap, min_length)


@pytest.mark.parametrize("kind", ["random", "loopy"])
@pytest.mark.parametrize(("n", "trials"), [(20, 12), (40, 4), (60, 1)])
def test_both_solvers_cover_equally_much_of_longer_trials(kind: str, n: int, trials: int) -> None:
    rng = np.random.default_rng(n)
    for _ in range(trials):
        trial = rng.integers(0, 4, n).tolist() if kind == "random" else loopy(rng, n)
        exact, literal = (cover(trial, solver=solver) for solver in SOLVERS)
        assert exact.covered == literal.covered
        assert_lawful(trial, exact, False, 3)


def loopy(rng: np.random.Generator, n: int) -> list[int]:
    """Cycles of two to six actions, each a few times, and one action in ten another."""
    trial: list[int] = []
    while len(trial) < n:
        trial += rng.integers(0, 4, rng.integers(2, 7)).tolist() * int(rng.integers(1, 5))
    return [int(rng.integers(0, 4)) if rng.random() < 0.1 else action for action in trial[:n]]


@settings(deadline=None)
@given(trial=TRIALS | CYCLES, overlap=st.booleans(), names=st.permutations(range(4)))
def test_the_names_of_the_actions_and_the_direction_of_time_do_not_matter(
    trial: tuple[int, ...], overlap: bool, names: list[int]
) -> None:
    found = cover(trial, overlap=overlap)
    renamed = cover([f"joint {names[action]}" for action in trial], overlap=overlap)
    assert renamed.intervals == found.intervals
    assert renamed.any_loop == found.any_loop
    assert cover(trial[::-1], overlap=overlap).covered == found.covered


@given(trial=TRIALS | CYCLES, overlap=st.booleans(), min_length=st.integers(1, 5))
def test_a_trial_is_covered_if_and_only_if_it_loops(trial: tuple[int, ...], overlap: bool, min_length: int) -> None:
    found = cover(trial, overlap=overlap, min_length=min_length)
    looping = any_loop(trial, overlap=overlap, min_length=min_length)
    assert looping == found.any_loop == (found.covered > 0) == (found.share > 0)


@pytest.mark.parametrize("solver", SOLVERS)
def test_worked_examples(solver: Solver) -> None:
    for trial, covered in {"001001010": 9, "000010010000": 12, "010101010": 9, "AAAA": 0, "ABCDABDC": 0}.items():
        assert cover(trial, solver=solver).covered == covered


@pytest.mark.parametrize("period", [3, 4, 5, 7])
@pytest.mark.parametrize("times", [2, 3, 9])
def test_any_cycle_is_reported_as_its_period(period: int, times: int) -> None:
    found = cover(list(range(period)) * times)
    assert found.words == (tuple(range(period)),)
    assert found.intervals == tuple((at * period, period) for at in range(times))


@pytest.mark.parametrize("times", [3, 4, 5])
def test_the_linear_programme_reports_the_period_too(times: int) -> None:
    assert cover("ABC" * times, solver="ilp") == cover("ABC" * times)


def test_of_the_fewest_pieces_the_first_are_longest() -> None:
    assert cover("ABCABCABCAB").intervals == ((0, 5), (5, 3), (8, 3))


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize(("trial", "pieces"), [("AABBBAABABBBABBB", 4), ("BBBABBBBABBAAB", 3), ("AABABBABABBBBB", 2)])
def test_fewest_pieces_are_chosen_where_more_would_cover_as_much(trial: str, pieces: int, solver: Solver) -> None:
    assert len(cover(trial, solver=solver).intervals) == pieces


def test_two_copies_that_share_actions_count_only_on_request() -> None:
    assert not any_loop("AAAA")
    assert any_loop("AAAA", overlap=True)
    assert cover("AAAA", overlap=True).intervals == ((0, 3),)


def test_a_trial_of_thousands_of_steps_is_covered_exactly() -> None:
    rng = np.random.default_rng(5)
    half = rng.integers(0, 1000, 1500).tolist()
    found = cover(half + half)
    assert found.intervals == ((0, 1500), (1500, 1500))


def test_an_empty_trial_has_no_share() -> None:
    assert cover(()) == LoopCover(n=0, any_loop=False, covered=0, words=(), intervals=())
    assert cover(()).share == 0.0
    assert any_loop_batch(np.zeros((2, 0), dtype=int)).tolist() == [False, False]


def test_trials_too_long_for_the_programme_are_refused_with_a_way_out() -> None:
    with pytest.raises(BadValue, match=f"got {LONGEST_ILP + 1}, expected at most {LONGEST_ILP}; dp has no limit"):
        cover("A" * (LONGEST_ILP + 1), solver="ilp")


def test_bad_settings_are_refused() -> None:
    with pytest.raises(BadValue, match="dp or ilp"):
        cover("ABC", solver="cp")  # type: ignore[arg-type]
    for refuse in (cover, any_loop):
        with pytest.raises(BadValue, match="at least 1"):
            refuse("ABC", min_length=0)
    with pytest.raises(BadValue, match="trials, n"):
        any_loop_batch(np.zeros(4, dtype=int))
    with pytest.raises(FrozenInstanceError):
        cover("ABC").n = 4  # type: ignore[misc]

"""Action loops: brute force over their definition on every short trial, the paper's programme and laws on longer ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from loop_definition import copies, patterns, truth

from lockprobe.foundation.errors import BadValue
from lockprobe.statistics.loops import LoopCover, Solver, cover, onset, onset_batch

SOLVERS: tuple[Solver, ...] = ("dp", "ilp")

TRIALS = st.integers(2, 4).flatmap(lambda k: st.lists(st.integers(0, k - 1), max_size=20)) | st.tuples(
    st.lists(st.integers(0, 3), min_size=1, max_size=6), st.integers(2, 6)
).map(lambda cycle: (cycle[0] * cycle[1])[:20])


@pytest.mark.parametrize(("actions", "longest"), [(2, 10), (3, 9), (4, 7)])
def test_every_short_trial_is_as_brute_force_has_it(actions: int, longest: int) -> None:
    trials = list(patterns(actions, longest))
    covered, pieces, first = np.array([truth(trial) for trial in trials]).T
    assert [cover(trial).covered for trial in trials] == covered.tolist()
    assert [onset(trial) for trial in trials] == first.tolist()
    full = [trial for trial in trials if len(trial) == longest]
    assert np.array_equal(onset_batch(np.array(full)), first[-len(full) :])
    if actions == 2:
        assert [len(cover(trial).intervals) for trial in trials] == pieces.tolist()


def assert_lawful(trial: Sequence[int], found: LoopCover) -> None:
    """What holds of every cover: disjoint pieces, each a copy of a loop."""
    words = copies(trial)
    assert found.n == len(trial)
    assert found.any_loop == bool(words) == (onset(trial) > 0)
    assert found.covered == sum(length for _, length in found.intervals)
    ends = [0] + [start + length for start, length in found.intervals]
    assert all(start >= end for (start, _), end in zip(found.intervals, ends, strict=False))
    chosen = dict.fromkeys(tuple(trial[start : start + length]) for start, length in found.intervals)
    assert tuple(chosen) == found.words
    assert chosen.keys() <= words.keys()


@settings(deadline=None, max_examples=60)
@given(trial=TRIALS, names=st.permutations("wxyz"))
def test_both_solvers_cover_equally_much_whatever_actions_are_called(trial, names) -> None:
    exact, literal = (cover(trial, solver=solver) for solver in SOLVERS)
    assert exact.covered == literal.covered
    for found in (exact, literal):
        assert_lawful(trial, found)
    assert cover([names[action] for action in trial]).intervals == exact.intervals
    assert cover(trial[::-1]).covered == exact.covered
    assert onset(trial) == onset(np.array(trial, dtype=np.int8))


@pytest.mark.parametrize("solver", SOLVERS)
def test_worked_examples(solver: Solver) -> None:
    for trial, covered in {"001001010": 9, "000010010000": 12, "010101010": 9, "AAAA": 0, "ABCDABDC": 0}.items():
        assert cover(trial, solver=solver).covered == covered
    for trial, pieces in {"AABBBAABABBBABBB": 4, "BBBABBBBABBAAB": 3, "AABABBABABBBBB": 2}.items():
        assert len(cover(trial, solver=solver).intervals) == pieces  # as few as any greatest cover
    assert cover("ABCDE" * 3, solver=solver).intervals == ((0, 5), (5, 5), (10, 5))  # a cycle as its period


def test_sequences_far_beyond_a_trial() -> None:
    half = np.random.default_rng(5).integers(0, 1000, 1500).tolist()
    assert cover(half + half).intervals == ((0, 1500), (1500, 1500))
    assert cover("ABC" * 70_000).covered == 210_000


def test_what_is_no_trial_is_refused() -> None:
    for call, said in {
        lambda: cover("ABC", solver="cp"): "dp or ilp",  # type: ignore[arg-type]
        lambda: cover("A" * 121, solver="ilp"): "got 121, expected at most 120; dp has no limit",
    }.items():
        with pytest.raises(BadValue, match=said):
            call()
    assert cover(()).share == 0

"""The automaton against the definition of loops, in Python and on arrays, and covers by every way to find loops."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from loop_definition import copies, patterns

from lockprobe.statistics.loops import LoopCover, cover, kernels, measure
from lockprobe.statistics.loops.automaton import automaton, loops_from

TRIALS = st.lists(st.integers(0, 3), max_size=40) | st.tuples(
    st.lists(st.integers(0, 3), min_size=1, max_size=9), st.integers(2, 6)
).map(lambda cycle: cycle[0] * cycle[1])


def longest_at(trial: Sequence[int], overlap: bool) -> list[int]:
    """The longest loop at each start by the definition, and 0 at the end of the trial."""
    words = copies(tuple(trial), 1, overlap)
    longest = [0] * (len(trial) + 1)
    for word, starts in words.items():
        for start in starts:
            longest[start] = max(longest[start], len(word))
    return longest


def on_arrays(trial: Sequence[int], overlap: bool) -> list[int]:
    """The same by the functions that are compiled, here in plain Python."""
    reach = np.full(len(trial) + 1, -1)
    kernels.loops_from(np.array(trial, dtype=np.int64), overlap, reach)
    return reach.tolist()


@pytest.mark.parametrize("overlap", [False, True])
def test_the_longest_loops_are_those_of_the_definition(overlap: bool) -> None:
    for trial in [*patterns(2, 9), *patterns(3, 6)]:
        expected = longest_at(trial, overlap)
        assert loops_from(trial, overlap=overlap) == expected, trial
        assert on_arrays(trial, overlap) == expected, trial


@settings(deadline=None, max_examples=100)
@given(trial=TRIALS, overlap=st.booleans())
def test_both_automata_find_the_same(trial: list[int], overlap: bool) -> None:
    assert loops_from(trial, overlap=overlap) == on_arrays(trial, overlap) == longest_at(trial, overlap)


@given(trial=TRIALS)
def test_a_state_is_the_words_that_end_at_the_same_places(trial: list[int]) -> None:
    found = automaton(trial)
    ends: dict[tuple[int, ...], list[int]] = {(): list(range(len(trial) + 1))}
    for end in range(1, len(trial) + 1):
        for start in range(end):
            ends.setdefault(tuple(trial[start:end]), []).append(end)
    states: dict[tuple[int, ...], int] = {}
    for word, places in ends.items():
        state = 0
        for action in word:
            state = found.after[state][action]
        assert states.setdefault(tuple(places), state) == state
        assert found.first[state] == places[0]
        assert found.size[found.shorter[state]] < len(word) <= found.size[state] or not word


@pytest.mark.parametrize("min_length", [1, 3, 4])
@pytest.mark.parametrize("overlap", [False, True])
def test_every_way_to_find_loops_gives_the_same_cover(monkeypatch, min_length: int, overlap: bool) -> None:
    rng = np.random.default_rng(7)
    cycles = [np.resize(rng.integers(0, 4, k), n) for k, n in ((5, 60), (7, 160), (40, 300), (1, 200))]
    noisy = [np.where(rng.random(len(one)) < 0.05, rng.integers(0, 4, len(one)), one) for one in cycles]
    trials = [one.tolist() for one in (*cycles, *noisy, *(rng.integers(0, k, 200) for k in (2, 4, 100)))]

    def covers() -> list[LoopCover]:
        return [cover(trial, min_length=min_length, overlap=overlap) for trial in trials]

    with monkeypatch.context() as patch:
        patch.setattr(kernels, "WORTH_COMPILING", 10**9)
        patch.setattr(kernels, "_COMPILED", {})
        found = covers()
        for searched, longest_named in ((10**9, 16), (0, 0), (0, 10**9)):  # all searched, automata, all named
            patch.setattr("lockprobe.statistics.loops.exact_cover.SEARCHED", searched)
            patch.setattr(kernels, "NAMED", longest_named)
            assert covers() == found
    pytest.importorskip("numba")
    monkeypatch.setattr(kernels, "WORTH_COMPILING", 0)
    monkeypatch.setattr("lockprobe.statistics.loops.exact_cover.SHORT", 0)
    assert covers() == found
    batch = measure(trials, min_length=min_length, overlap=overlap)
    assert batch.covered.tolist() == [one.covered for one in found]
    assert batch.redundant.tolist() == [one.redundant for one in found]

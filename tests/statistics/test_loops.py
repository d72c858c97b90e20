"""Action loops and their chance levels: brute force over the definition, the paper's programme, laws, and counting."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from itertools import combinations, pairwise
from math import perm
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe.foundation.errors import BadValue
from lockprobe.statistics.loops import LONGEST_WITH_ALL, LoopCover, Solver, chance, cover, onset, onset_batch
from lockprobe.statistics.loops.chance import Null, chance_level, expected_loop_rate

ROOT = Path(__file__).parents[2]
NULLS: tuple[Null, ...] = ("uniform", "no-repeat")
SOLVERS: tuple[Solver, ...] = ("dp", "ilp")


class Truth(NamedTuple):
    """What brute force finds. ``pieces`` are the fewest of a greatest cover."""

    covered: int
    pieces: int
    onset: int


def patterns(actions: int, longest: int) -> Iterator[tuple[int, ...]]:
    """Every trial up to ``longest`` steps, up to the names of its actions."""
    layer: list[tuple[int, ...]] = [()]
    for _ in range(longest + 1):
        yield from layer
        layer = [(*p, a) for p in layer for a in range(min(len(set(p)) + 1, actions))]


def copies(trial: Sequence[int]) -> dict[tuple[int, ...], list[int]]:
    """Every run that stands twice, and all places where it stands."""
    places: dict[tuple[int, ...], list[int]] = {}
    for start, end in combinations(range(len(trial) + 1), 2):
        if end - start >= 3:
            places.setdefault(tuple(trial[start:end]), []).append(start)
    return {word: at for word, at in places.items() if at[-1] - at[0] >= len(word)}


def truth(trial: tuple[int, ...]) -> Truth:
    """Tries every set of disjoint pieces."""
    words = copies(trial)
    if not words:
        return Truth(0, 0, 0)
    pieces = sorted((start, start + len(word)) for word, at in words.items() for start in at)
    best, fewest = 0, 0

    def choose(begin: int, end: int, covered: int, chosen: int) -> None:
        nonlocal best, fewest
        if (covered, -chosen) > (best, -fewest):
            best, fewest = covered, chosen
        for k in range(begin, len(pieces)):
            start, stop = pieces[k]
            if start >= end:
                choose(k + 1, stop, covered + stop - start, chosen + 1)

    choose(0, 0, 0, 0)
    ends = [b + len(word) for word, at in words.items() for a, b in combinations(at, 2) if b - a >= len(word)]
    return Truth(best, fewest, min(ends))


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
        found = cover(trial, solver=solver)
        assert (found.covered, found.share) == (covered, covered / len(trial))
    for trial, pieces in {"AABBBAABABBBABBB": 4, "BBBABBBBABBAAB": 3, "AABABBABABBBBB": 2}.items():
        assert len(cover(trial, solver=solver).intervals) == pieces  # as few as any greatest cover
    assert cover("ABCABCA").intervals == ((0, 3), (3, 3))  # as early as can be
    for cycle, times in {"ABCDE": 3, "AAB": 5, "ABCD": 4}.items():  # a cycle as its period
        found = cover(cycle * times, solver=solver).intervals
        assert found == tuple((at, len(cycle)) for at in range(0, times * len(cycle), len(cycle)))


def test_sequences_far_beyond_a_trial() -> None:
    n = LONGEST_WITH_ALL // 2
    half = np.random.default_rng(5).integers(0, 1000, n).tolist()
    assert cover(half + half).intervals == ((0, n), (n, n))
    assert cover("ABC" * 2_000).covered == 6_000


def test_the_level_of_the_papers_trials() -> None:
    assert chance_level(20).probability == 1 - 219_018_772_080 / 4**20
    assert chance_level(20, null="no-repeat").probability == pytest.approx(0.9470, abs=5e-5)


@pytest.mark.parametrize("null", NULLS)
@pytest.mark.parametrize(("actions", "longest"), [(2, 9), (3, 8), (4, 7), (5, 6)])
def test_every_short_trial_counted_by_hand(null: Null, actions: int, longest: int) -> None:
    for length in range(longest + 1):
        trials = {
            trial: perm(actions, len(set(trial)))
            for trial in patterns(actions, length)
            if len(trial) == length and (null == "uniform" or all(a != b for a, b in pairwise(trial)))
        }
        looping = sum(n for trial, n in trials.items() if onset(trial))
        level = chance_level(length, actions, null=null)
        assert (level.probability, level.method) == (looping / sum(trials.values()), "exact"), length


def test_what_cannot_be_counted_is_simulated_alike_at_every_call_and_always_with_an_error() -> None:
    level = chance_level(24)
    assert level.probability > chance_level(20).probability
    assert 0 < level.error < 0.001
    chance._onsets.cache_clear()
    assert chance_level(24) == level


def test_beyond_the_decisive_length_nothing_is_left_to_decide() -> None:
    assert (always := chance_level(1200, 8)).probability == 1.0
    assert always.error > 0


@pytest.mark.skipif(shutil.which("cc") is None, reason="the table's program needs a C compiler")
def test_the_program_makes_the_shipped_table(tmp_path: Path) -> None:
    made, script = tmp_path / "table.json", ROOT / "scripts" / "make_chance_table.py"
    subprocess.run([sys.executable, script, "--quick", "--out", made], check=True, capture_output=True)
    table, counted = chance._table(), 0
    for name, rows in json.loads(made.read_text()).items():
        for row, shipped in zip(rows, table[name], strict=True):
            for cell, kept in zip(row, shipped, strict=True):
                assert cell is None or cell == kept
                counted += cell is not None
    assert counted > 150


def test_the_level_of_trials_is_the_mean_over_their_lengths() -> None:
    level = expected_loop_rate([(20, 4), (8, 4), (20, 4), (0, 4)], "uniform")
    by_hand = (2 * chance_level(20).probability + chance_level(8).probability) / 4
    assert level.probability == pytest.approx(by_hand, abs=1e-12)
    assert (level.method, level.error) == ("exact", 0.0)
    level = expected_loop_rate([(4, 5), (20, 5), (24, 5)], "uniform")
    parts = [chance_level(length, 5) for length in (4, 20, 24)]
    assert [part.method for part in parts] == ["exact", "simulation", "simulation"]
    assert level.probability == pytest.approx(np.mean([part.probability for part in parts]))
    assert level.error == pytest.approx(sum(part.error for part in parts) / 3)


def test_what_has_no_cover_or_no_level_is_refused() -> None:
    for call, said in {
        lambda: cover("ABC", solver="cp"): "dp or ilp",  # type: ignore[arg-type]
        lambda: cover("A" * 121, solver="ilp"): "got 121, expected at most 120; dp has no limit",
        lambda: chance_level(-1): "length",
        lambda: chance_level(5, 0): "actions",
        lambda: chance_level(5, 1, null="no-repeat"): "at least 2",
        lambda: chance_level(5, null="markov"): "uniform or no-repeat",  # type: ignore[arg-type]
    }.items():
        with pytest.raises(BadValue, match=said):
            call()
    assert cover(()).share == 0

"""Chance levels against the notes, against enumeration, and against simulation."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Iterator
from itertools import pairwise
from math import perm
from pathlib import Path

import numpy as np
import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.statistics.loops import any_loop, chance, onset_batch
from lockprobe.statistics.loops.chance import Null, chance_level, expected_loop_rate, first_loops

ROOT = Path(__file__).parents[3]
LENGTHS = (6, 8, 9, 10, 11, 12, 14, 15, 16, 18, 20)
NOTES: dict[tuple[Null, bool], tuple[float, ...]] = {
    ("uniform", False): (.0156, .0803, .1277, .1832, .2450, .3113, .4498, .5184, .5843, .7035, .8008),
    ("uniform", True): (.0742, .1746, .2362, .3029, .3725, .4432, .5804, .6439, .7024, .8017, .8763),
    ("no-repeat", False): (.0247, .1331, .2090, .2946, .3865, .4785, .6518, .7266, .7912, .8882, .9470),
}  # fmt: skip
"""Chance levels over 4 actions as measured for the notes (notes/loops-and-statistics.md, section 3)."""

NULLS: tuple[Null, ...] = ("uniform", "no-repeat")


@pytest.mark.parametrize(("null", "overlap"), NOTES)
def test_the_levels_of_the_notes(null: Null, overlap: bool) -> None:
    for length, expected in zip(LENGTHS, NOTES[null, overlap], strict=True):
        level = chance_level(length, null=null, overlap=overlap)
        assert level.method == "exact"
        assert level.error == 0.0
        assert level.probability == pytest.approx(expected, abs=0.5001e-4), length


def test_the_level_of_the_papers_trials() -> None:
    assert chance_level(20).probability == 1 - 219_018_772_080 / 4**20
    assert chance_level(20, null="no-repeat", overlap=True).probability == pytest.approx(0.9741, abs=5e-5)


def patterns(length: int, actions: int) -> Iterator[tuple[int, ...]]:
    """Trials whose actions are numbered in order of first use."""
    if not length:
        yield ()
        return
    for head in patterns(length - 1, actions):
        for action in range(min(max(head, default=-1) + 2, actions)):
            yield (*head, action)


@pytest.mark.parametrize("null", NULLS)
@pytest.mark.parametrize("overlap", [False, True])
@pytest.mark.parametrize(("actions", "longest"), [(2, 9), (3, 8), (4, 7), (5, 6)])
def test_every_short_trial_counted_by_hand(null: Null, overlap: bool, actions: int, longest: int) -> None:
    for length in range(longest + 1):
        trials = {
            trial: perm(actions, len(set(trial)))
            for trial in patterns(length, actions)
            if null == "uniform" or all(a != b for a, b in pairwise(trial))
        }
        assert null == "no-repeat" or sum(trials.values()) == actions**length
        for min_length in (2, 3):
            looping = sum(n for trial, n in trials.items() if any_loop(trial, overlap=overlap, min_length=min_length))
            level = chance_level(length, actions, null=null, overlap=overlap, min_length=min_length)
            assert level.method == "exact"
            assert level.probability == looping / sum(trials.values()), length


def test_what_cannot_be_counted_is_simulated_with_its_error() -> None:
    level = chance_level(24)
    assert level.method == "simulation"
    assert level.probability > chance_level(20).probability
    assert 0 < level.error < 0.001
    chance._onsets.cache_clear()
    assert chance_level(24) == level


@pytest.mark.parametrize("null", NULLS)
@pytest.mark.parametrize("overlap", [False, True])
def test_one_simulation_answers_every_length(null: Null, overlap: bool) -> None:
    for length in range(6, 21, 2):
        exact = chance_level(length, null=null, overlap=overlap)
        simulated = chance._simulated(length, 4, null, 3, overlap=overlap)
        assert abs(exact.probability - simulated.probability) < 4 * simulated.error, length
        assert (exact.method, simulated.method) == ("exact", "simulation")
    assert chance._onsets(20, 4, null, 3, overlap=overlap).shape == (400_000,)


def test_first_loops_are_those_of_the_whole_trial() -> None:
    trials = np.random.default_rng(5).integers(0, 12, (200, 130))
    trials[:5] = np.arange(130)
    for overlap in (False, True):
        found = first_loops(trials, overlap=overlap)
        assert found.tolist() == onset_batch(trials, overlap=overlap).tolist()
        assert found[:5].tolist() == [0] * 5
        assert found.max() > 40


def test_beyond_the_decisive_length_nothing_is_left_to_decide() -> None:
    for actions in (4, 6, 10):
        steps = chance.decisive_length(actions, 3)
        trials = np.random.default_rng(6).integers(0, actions, (4_000, steps))
        assert first_loops(trials).min() > 0
    assert chance_level(10_000, 24).probability == 1.0


def test_a_simulation_that_always_loops_still_has_an_error() -> None:
    level = chance_level(100)
    assert (level.probability, level.method) == (1.0, "simulation")
    assert level.error > 0


@pytest.mark.parametrize(("overlap", "longest"), [(False, 3 * 8 + 2), (True, 8 + 2)])
def test_a_long_enough_trial_loops_for_certain(overlap: bool, longest: int) -> None:
    level = chance_level(longest + 1, 2, overlap=overlap)
    assert (level.probability, level.method) == (1.0, "exact")
    assert chance_level(10, 2, overlap=True).probability == 1 - 16 / 2**10  # de Bruijn: 2 cycles, 8 starts


def test_a_short_trial_cannot_loop() -> None:
    assert [chance_level(length, 1).probability for length in (0, 5, 6)] == [0, 0, 1]
    assert [chance_level(length, 1, overlap=True).probability for length in (3, 4)] == [0, 1]
    assert chance_level(1000, 4, min_length=600).probability == 0


def test_without_repeats_there_are_fewer_words_to_go_round() -> None:
    certain = 3 * 3 * 2 * 2 + 2 + 1
    assert chance_level(certain, 3, null="no-repeat").method == "exact"
    assert chance_level(certain - 1, 3, null="no-repeat").method == "simulation"
    assert chance_level(2, 2, null="no-repeat", min_length=1, overlap=True).probability == 0
    assert chance_level(3, 2, null="no-repeat", min_length=1, overlap=True).probability == 1


@pytest.mark.skipif(shutil.which("cc") is None, reason="the table's program needs a C compiler")
def test_the_program_makes_the_shipped_table(tmp_path: Path) -> None:
    made = tmp_path / "table.json"
    subprocess.run(
        [sys.executable, ROOT / "scripts" / "make_chance_table.py", "--quick", "--out", made],
        check=True,
        capture_output=True,
    )
    table = chance._table()
    counted = 0
    for name, rows in json.loads(made.read_text()).items():
        for row, shipped in zip(rows, table[name], strict=True):
            for cell, kept in zip(row, shipped, strict=True):
                assert cell is None or cell == kept
                counted += cell is not None
    assert counted > 250


def test_bad_settings_are_refused() -> None:
    with pytest.raises(BadValue, match="length"):
        chance_level(-1)
    with pytest.raises(BadValue, match="actions"):
        chance_level(5, 0)
    with pytest.raises(BadValue, match="at least 2"):
        chance_level(5, 1, null="no-repeat")
    with pytest.raises(BadValue, match="uniform or no-repeat"):
        chance_level(5, null="markov")  # type: ignore[arg-type]
    with pytest.raises(BadValue, match="shortest loop"):
        chance_level(5, min_length=0)


def test_words_beyond_the_floats_are_no_obstacle() -> None:
    assert chance.decisive_length(64, 1000) == chance.decisive_length(64, 900) + 200 > 10**100
    level = chance_level(2100, 64, min_length=1000)
    assert (level.probability, level.method) == (0.0, "simulation")


def test_the_level_of_trials_is_the_mean_over_their_lengths() -> None:
    level = expected_loop_rate(["ABCD" * 5, "ABCD" * 2, "ABCD" * 5, ""], "uniform", actions=4)
    by_hand = (2 * chance_level(20).probability + chance_level(8).probability) / 4
    assert level.probability == pytest.approx(by_hand, abs=1e-12)
    assert (level.method, level.error) == ("exact", 0.0)
    level = expected_loop_rate([range(6), range(19), [*range(6)] * 4], "no-repeat", actions=19)
    parts = [chance_level(length, 19, null="no-repeat") for length in (6, 19, 24)]
    assert level.probability == pytest.approx(np.mean([part.probability for part in parts]))
    assert level.error == pytest.approx(sum(part.error for part in parts) / 3)
    with pytest.raises(BadValue, match="trials"):
        expected_loop_rate([], "uniform", actions=4)
    with pytest.raises(BadValue, match="at least the 3"):
        expected_loop_rate(["ABC"], "uniform", actions=2)

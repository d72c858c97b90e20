"""Chance levels against the paper's length, against enumeration, and against simulation."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from itertools import pairwise
from math import perm
from pathlib import Path

import numpy as np
import pytest
from loop_definition import patterns

from lockprobe.foundation.errors import BadValue
from lockprobe.statistics.loops import chance, onset
from lockprobe.statistics.loops.chance import Null, chance_level, expected_loop_rate

ROOT = Path(__file__).parents[2]
NULLS: tuple[Null, ...] = ("uniform", "no-repeat")


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
    assert (always := chance_level(10_000, 24)).probability == 1.0
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
    level = expected_loop_rate(["ABCD" * 5, "ABCD" * 2, "ABCD" * 5, ""], "uniform", actions=4)
    by_hand = (2 * chance_level(20).probability + chance_level(8).probability) / 4
    assert level.probability == pytest.approx(by_hand, abs=1e-12)
    assert (level.method, level.error) == ("exact", 0.0)
    level = expected_loop_rate(["ABCD", "ABCDE" * 4, "ABCD" * 6], "uniform", actions=5)
    parts = [chance_level(length, 5) for length in (4, 20, 24)]
    assert [part.method for part in parts] == ["exact", "simulation", "simulation"]
    assert level.probability == pytest.approx(np.mean([part.probability for part in parts]))
    assert level.error == pytest.approx(sum(part.error for part in parts) / 3)


def test_settings_without_a_level_are_refused() -> None:
    for call, said in {
        lambda: chance_level(-1): "length",
        lambda: chance_level(5, 0): "actions",
        lambda: chance_level(5, 1, null="no-repeat"): "at least 2",
        lambda: chance_level(5, null="markov"): "uniform or no-repeat",  # type: ignore[arg-type]
        lambda: expected_loop_rate([], "uniform", actions=4): "trials",
        lambda: expected_loop_rate(["ABC"], "uniform", actions=2): "at least the 3",
    }.items():
        with pytest.raises(BadValue, match=said):
            call()

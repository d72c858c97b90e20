"""Every short trial, up to the names of its actions, against brute force over the definitions."""

from __future__ import annotations

import numpy as np
import pytest
from loop_definition import patterns, truth

from lockprobe.statistics.loops import any_loop_batch, cover, measure, onset_batch

ALL = [(2, 10, False), (3, 9, False), (4, 7, False), (2, 9, True), (3, 7, True), (4, 7, True)]
"""Number of actions, length up to which all trials are tried, and overlap of copies."""


@pytest.mark.parametrize(("actions", "longest", "overlap"), ALL)
def test_every_short_trial_is_as_brute_force_has_it(actions: int, longest: int, overlap: bool) -> None:
    trials = list(patterns(actions, longest))
    expected = [truth(trial, overlap) for trial in trials]
    for trial, true in zip(trials, expected, strict=True):
        found = cover(trial, overlap=overlap)
        assert (found.covered, found.any_loop) == (true.covered, true.covered > 0), trial
    batch = measure(trials, overlap=overlap)
    columns = np.array(expected).T
    assert np.array_equal(batch.covered, columns[0])
    assert np.array_equal(batch.onset, columns[2])
    full = np.array([trial for trial in trials if len(trial) == longest])
    assert np.array_equal(onset_batch(full, overlap=overlap), columns[2][-len(full) :])
    assert np.array_equal(any_loop_batch(full, overlap=overlap), columns[0][-len(full) :] > 0)


@pytest.mark.parametrize("min_length", [1, 2, 4])
def test_every_short_trial_with_other_shortest_loops(min_length: int) -> None:
    for trial in patterns(3, 7 if min_length < 4 else 9):
        assert cover(trial, min_length=min_length).covered == truth(trial, False, min_length).covered, trial


def test_of_all_greatest_covers_it_has_fewest_pieces() -> None:
    for trial in patterns(2, 10):
        assert len(cover(trial).intervals) == truth(trial, False).pieces, trial

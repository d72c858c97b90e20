"""Loops against chance: a verdict only where the interval of the rate lies outside both chance levels."""

from dataclasses import replace

import pytest
from builders import make_trial

from lockprobe.statistics.behaviour import behaviour
from lockprobe.statistics.loops.against_chance import against_chance, chance_range
from lockprobe.statistics.proportions import proportion


@pytest.mark.parametrize(
    ("loops", "levels", "verdict"),
    [
        ((95, 100), (0.5, 0.6), "more"),
        ((95, 100), (0.6, 0.5), "more"),
        ((5, 100), (0.5, 0.6), "less"),
        ((55, 100), (0.5, 0.6), "not detected"),
        ((60, 100), (0.3, 0.58), "not detected"),
        ((80, 100), (0.3, 0.75), "not detected"),
    ],
)
def test_the_interval_has_to_lie_outside_both_levels(loops, levels, verdict):
    played = behaviour([make_trial([0, 1, 0, 1])])
    nulls = dict(zip(("uniform", "no-repeat"), levels, strict=True))
    chance = {null: replace(one, probability=nulls.get(null, one.probability)) for null, one in played.chance.items()}
    found = replace(played, loops=proportion(*loops), chance=chance)
    assert against_chance(found) == verdict
    assert chance_range(found) == tuple(sorted(levels))


def test_without_trials_there_is_no_verdict():
    assert against_chance(behaviour([])) == "not detected"

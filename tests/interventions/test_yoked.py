"""Yoked reports are as often false as their source, at steps of another trial."""

import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.yoked import Yoked
from lockprobe.studies.running.single import run_trial


def lies(condition, trial):
    """For each step whether its report was false, where nothing that is told changes what is done."""
    played = run_trial(
        agent="round-robin", box="chain-7", max_steps=24, shuffle="never", condition=condition, trial=trial
    )
    assert len(played.steps) == 24
    return [step.told_falsely for step in played.steps]


@pytest.mark.parametrize("trial", range(1, 7))
def test_yoked_lies_where_the_flip_of_the_next_trial_does(trial):
    assert lies("yoked?p=0.4", trial) == lies("flip?p=0.4", trial + 1) != lies("flip?p=0.4", trial)


@pytest.mark.parametrize("trial", range(1, 7))
def test_yoked_has_the_dose_of_its_source(trial):
    """Shuffled within the trial, report by report in another order, exactly as many are false."""
    for p in (0.0, 0.2, 0.4, 1.0):
        source, shuffled = lies(f"flip?p={p}", trial), lies(f"yoked?p={p}&how=shuffle", trial)
        assert sum(shuffled) == sum(source)
        assert p in (0.0, 1.0) or shuffled != source


def test_the_order_is_the_same_at_every_dose():
    few, many = (lies(f"yoked?p={p}&how=shuffle", 1) for p in (0.2, 0.5))
    assert all(more or not fewer for fewer, more in zip(few, many, strict=True))


def test_a_flip_beside_it_keeps_its_luck():
    both = lies("flip?p=0.3 + yoked?p=0.4", 2)
    assert both == [a != b for a, b in zip(lies("flip?p=0.3", 2), lies("yoked?p=0.4", 2), strict=True)]


def test_bad_settings_are_named():
    with pytest.raises(BadValue, match="how: got 'random', expected one of next, shuffle"):
        Yoked(how="random")

"""Flips like misreadings: the rates of a confusion matrix, and the draws of ``flip``."""

from dataclasses import replace

import pytest

from lockprobe.foundation.errors import BadValue, TrialFault
from lockprobe.foundation.spec import Spec
from lockprobe.interventions.catalogue import interventions_of
from lockprobe.interventions.misread_flip import MisreadFlip
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.condition import spec_of

LABELS = "ABCDEFGH"


def like(hidden, invented, **options):
    """The intervention with the same two rates for every joint."""
    entries = tuple(f"{label}:{hidden}:{invented}" for label in LABELS)
    return replace(MisreadFlip(like="rgb"), by_label=entries, **options)


def played(condition, trial=1):
    """A trial of an agent that heeds nothing, so that outcomes are the same whatever it is told."""
    return run_trial(agent="random", box="gray-code-4", trial=trial, condition=condition)


def false(trial):
    return [step.told_falsely for step in trial.steps]


def test_at_one_rate_for_all_it_is_the_flip_of_that_rate():
    for trial in range(1, 9):
        assert false(played([like(0.4, 0.4)], trial)) == false(played("flip?p=0.4", trial))


def test_each_direction_has_its_own_rate():
    for trial in range(1, 9):
        moved = [step.moved for step in played("truth", trial).steps]
        assert false(played([like(1, 0)], trial)) == moved
        assert false(played([like(0, 1)], trial)) == [not one for one in moved]


def test_each_joint_has_its_own_rate():
    entries = ("A:1:1", *(f"{label}:0:0" for label in LABELS[1:]))
    trial = played([replace(MisreadFlip(like="rgb"), by_label=entries)], 3)
    joint = trial.joints[trial.labels.index("A")]
    assert any(step.joint == joint for step in trial.steps)
    assert false(trial) == [step.joint == joint for step in trial.steps]


def test_p_is_the_share_of_the_rates_that_acts():
    for trial in range(1, 9):
        assert false(played([like(0.8, 0.8, p=0.5)], trial)) == false(played("flip?p=0.4", trial))
        assert played([like(0.8, 0.8, p=0.0)], trial).steps == played("truth", trial).steps


def test_its_spec_leaves_out_what_is_filled_in():
    (one,) = interventions_of("flip?like=d/rgb&by=total&others=kept")
    assert spec_of(one) == "flip?p=1&others=kept&like=d/rgb&by=total"
    known = replace(one, rates=("slider:0.1:0.2",), size=7)
    assert interventions_of(spec_of(known)) == (known,)
    assert Spec.parse(spec_of(known)).options["rates"] == "slider:0.1:0.2"
    assert spec_of(replace(known, by_label=("A:0.1:0.2",))) == spec_of(known)


def test_alone_it_has_no_rates():
    with pytest.raises((BadValue, TrialFault), match="a study that has it, with the rates that it read"):
        run_trial(agent="random", condition="flip?like=rgb")


@pytest.mark.parametrize(
    ("spec", "said"),
    [
        ("flip?like=rgb&by=place", "by: got 'place', expected one of joint, direction, total"),
        ("flip?like=rgb&part=outcome", "none with others=noisy or part"),
        ("flip?like=rgb&rates=slider:0.1", "rates: got 'slider:0.1', expected joints with the rates"),
        ("flip?like=rgb&rates=slider:0.1:1.2", "rates: got 'slider:0.1:1.2'"),
        ("flip?like=", "DIR/CONDITION, with the directory of a finished study"),
    ],
)
def test_bad_settings_are_named(spec, said):
    with pytest.raises(BadValue, match=said):
        interventions_of(spec)

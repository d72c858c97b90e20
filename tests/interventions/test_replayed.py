"""Misreadings told again: at their step, or at the next attempt of the same joint with the same outcome."""

from dataclasses import replace

import pytest

from lockprobe.foundation.errors import BadValue, TrialFault
from lockprobe.interventions.catalogue import interventions_of
from lockprobe.interventions.replayed import NOTHING, Misreading, Replayed, misreading_entry
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.condition import spec_of


def replaying(*misread, **options):
    entries = tuple(misreading_entry(Misreading(*one)) for one in misread) or NOTHING
    return replace(Replayed(claims="rgb"), misread=entries, **options)


def played(condition, trial=1):
    """A trial of an agent that heeds nothing."""
    return run_trial(agent="random", box="gray-code-4", trial=trial, condition=condition)


TRUE = played("truth")
ATTEMPTS = [
    (step.step, TRUE.labels[TRUE.joints.index(step.joint)], "moved" if step.moved else "blocked") for step in TRUE.steps
]


def false(trial):
    return [step.step for step in trial.steps if step.told_falsely]


def test_each_is_told_at_its_step():
    chosen = ATTEMPTS[2::5]
    assert false(played([replaying(*chosen)])) == [step for step, _, _ in chosen]


def test_one_whose_joint_or_outcome_differs_waits_for_the_next_that_agrees():
    step, label, outcome = ATTEMPTS[9]
    earlier = [one for one in ATTEMPTS[:9] if one[1:] == (label, outcome)]
    since = max((one[0] for one in earlier), default=0)
    assert false(played([replaying((since + 1, label, outcome))])) == [step]
    assert false(played([replaying((since + 1, label, "moved" if outcome == "blocked" else "blocked"))])) != [step]


def test_two_of_one_kind_are_told_twice():
    _, label, outcome = ATTEMPTS[0]
    like = [one[0] for one in ATTEMPTS if one[1:] == (label, outcome)]
    assert len(like) > 2
    assert false(played([replaying((1, label, outcome), (1, label, outcome))])) == like[:2]


def test_nothing_misread_and_dose_0_are_the_truth():
    assert played([replaying()]).steps == TRUE.steps
    assert played([replaying(*ATTEMPTS, p=0.0)]).steps == TRUE.steps


def test_a_smaller_share_is_a_subset():
    few, more = ({*false(played([replaying(*ATTEMPTS, p=p)]))} for p in (0.3, 0.7))
    assert few < more < {*false(played([replaying(*ATTEMPTS)]))}


def test_shuffled_it_falls_on_the_given_steps_whatever_is_attempted():
    assert false(played([replace(Replayed(claims="rgb", how="shuffle"), at=(3, 8))])) == [3, 8]
    assert played([replace(Replayed(claims="rgb", how="shuffle"), at=(0,))]).steps == TRUE.steps


def test_a_flip_beside_it_keeps_its_luck():
    alone, both = false(played("flip?p=0.3")), false(played([*interventions_of("flip?p=0.3"), replaying(ATTEMPTS[3])]))
    assert {*both} ^ {*alone} <= {ATTEMPTS[3][0]}


def test_its_spec_leaves_out_what_a_study_fills_in():
    (one,) = interventions_of("yoked?claims=rgb&how=shuffle&others=kept")
    assert spec_of(one) == "yoked?p=1&claims=rgb&how=shuffle&others=kept"
    assert spec_of(replace(one, at=(3,))) == spec_of(one)


def test_alone_it_has_nothing_to_tell():
    with pytest.raises((BadValue, TrialFault), match="a study that has it: it follows its trials"):
        run_trial(agent="random", condition="yoked?claims=rgb")


@pytest.mark.parametrize(
    ("spec", "said"),
    [
        ("yoked?claims=rgb&how=next", "how: got 'next', expected one of same, shuffle"),
        ("yoked?claims=rgb&misread=4:B", "misread: got '4:B', expected step, joint and true outcome"),
        ("yoked?claims=", "CONDITION of this study, or STUDY/CONDITION"),
        ("yoked?claims=rgb&others=noisy", "others: got 'noisy'"),
    ],
)
def test_bad_settings_are_named(spec, said):
    with pytest.raises(BadValue, match=said):
        interventions_of(spec)

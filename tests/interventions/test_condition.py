"""A condition names what acts, in order; specs make it, and tell it."""

import pytest

from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.interventions.conditions import distinct, flips, interventions_in, read_condition, sweep
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.nudge import Nudge
from lockprobe.interventions.tremble import Tremble
from lockprobe.trial.condition import Condition, Recorded


def test_the_truth_is_the_empty_condition():
    assert read_condition("truth") == read_condition("") == Condition()
    assert Condition().label == "truth"
    assert Condition().p == 0
    assert Condition().does_nothing


@pytest.mark.parametrize("spec", ["tremble?p=0.1", "flip?p=0.4 + nudge", "nudge + flip?p=0.4", "drop?p=0.3 + rgb"])
def test_a_spec_makes_what_it_says_and_is_said_again(spec):
    assert read_condition(spec).spec == spec


def test_order_matters_and_names_do():
    assert read_condition("nudge + flip?p=0.4") != read_condition("flip?p=0.4 + nudge")
    named = read_condition("flip?p=0.4", "lies")
    assert (named.label, named.spec) == ("lies", "flip?p=0.4")
    assert named != read_condition("flip?p=0.4")


def test_how_the_box_is_shown_may_stand_last():
    shown = read_condition("warn + rgbd?depth=height")
    assert (shown.modality, shown.specs) == ("rgbd?depth=height", ("warn",))


@pytest.mark.parametrize(("spec", "p"), [("truth", 0), ("flip?p=0.25", 0.25), ("tremble?p=0", None), ("nudge", None)])
def test_only_flips_have_a_flip_rate(spec, p):
    assert read_condition(spec).p == p


def test_a_flip_rate_is_kept_to_the_last_digit():
    assert flips((0.1234567890123,))[0].p == 0.1234567890123


@pytest.mark.parametrize(
    ("spec", "nothing"),
    [
        ("truth", True), ("flip?p=0", True), ("tremble?p=0 + flip?p=0&others=kept", True), ("nudge", False),
        ("tremble?p=0.1", False), ("symbolic?tell=outcome", True),
    ],
)  # fmt: skip
def test_dose_0_does_nothing(spec, nothing):
    assert read_condition(spec).does_nothing is nothing


def test_the_paper_s_conditions_run_over_flip_rates_and_then_modalities():
    found = flips((0, 0.4), "integrated", ("symbolic", "rgb"))
    assert [(one.p, one.modality) for one in found] == [(0, "symbolic"), (0.4, "symbolic"), (0, "rgb"), (0.4, "rgb")]
    assert [one.spec for one in found] == [
        "symbolic", "flip?p=0.4&others=kept + symbolic", "rgb",
        "flip?p=0.4&others=kept + rgb",
    ]  # fmt: skip


def test_a_sweep_is_one_condition_for_each_dose():
    assert [one.spec for one in sweep("tremble?p=0,0.1, 0.2")] == ["tremble?p=0", "tremble?p=0.1", "tremble?p=0.2"]
    assert [one.spec for one in sweep("nudge?after=3 + drop?p=0.1,0.2&luck=flip")] == [
        "nudge?after=3 + drop?p=0.1&luck=flip", "nudge?after=3 + drop?p=0.2&luck=flip",
    ]  # fmt: skip


def test_several_doses_are_swept_in_every_combination_and_have_the_names_of_what_acts():
    found = sweep("flip?p=0,0.2,0.4 + nudge + tremble?p=0,0.1")
    assert [one.spec for one in found] == [
        "nudge", "nudge + tremble?p=0.1", "flip?p=0.2 + nudge", "flip?p=0.2 + nudge + tremble?p=0.1",
        "flip?p=0.4 + nudge", "flip?p=0.4 + nudge + tremble?p=0.1",
    ]  # fmt: skip
    assert len(sweep("flip?p=0,0.2,0.4 + tremble?p=0,0.1,0.2 + drop?p=0,0.1")) == 18


def test_a_sweep_of_what_is_kept_names_its_ends_by_their_words():
    assert [one.spec for one in sweep("flip?p=0.4&keep=0,0.5,1")] == [
        "flip?p=0.4", "flip?p=0.4&keep=0.5", "flip?p=0.4&others=kept",
    ]  # fmt: skip


def test_flips_of_outcomes_alone_are_shown_without_positions():
    found = flips((0, 0.4), "outcome-only", ("symbolic?form=json",))
    shown = "symbolic?form=json&tell=outcome"
    assert [one.spec for one in found] == [shown, f"flip?p=0.4 + {shown}"]
    for modality in ("symbolic?tell=state", "rgb"):
        with pytest.raises(BadValue, match="^flip: got 'outcome-only', expected .*, which shows positions$"):
            flips((0.4,), "outcome-only", (modality,))


def test_doses_of_pictures_are_crossed_with_others():
    assert [one.spec for one in sweep("flip?p=0,0.4 + rgb?blur=0,8")] == [
        "rgb", "rgb?blur=8", "flip?p=0.4 + rgb", "flip?p=0.4 + rgb?blur=8",
    ]  # fmt: skip


@pytest.mark.parametrize(
    "spec",
    [
        "tremble?p=0.1", "nudge?after=2,3", "truth", "tremble?p=0,0.1 + nudge?after=2,3",
        " + ".join(f"{name}?p={','.join('0' * 11)}" for name in ("flip", "drop", "tremble")),
    ],
)  # fmt: skip
def test_a_sweep_is_over_several_values_of_a_dose(spec):
    with pytest.raises(BadValue, match="sweep"):
        sweep(spec)


def test_what_does_not_exist_is_refused_with_what_does():
    with pytest.raises(UnknownName, match="tremble"):
        read_condition("trembel?p=0.1")


@pytest.mark.parametrize(
    ("kind", "modality", "spec"),
    [
        ("re-observed", "rgb", "rgb"), ("integrated", "rgb", "rgb"), ("integrated", "rgb?p=0", "rgb?p=0"),
        ("re-observed", "rgb?p=0.4", "rgb?p=0.4"), ("integrated", "rgb?p=0.4", "flip?p=0&others=kept + rgb?p=0.4"),
        ("integrated", "rgb?blur=2", "rgb?blur=2"), ("outcome-only", "symbolic", "symbolic?tell=outcome"),
    ],
)  # fmt: skip
def test_a_flip_at_rate_0_is_the_truth_unless_it_says_more(kind, modality, spec):
    (found,) = flips((0,), kind, (modality,))
    assert found.spec == spec


@pytest.mark.parametrize("name", [" a", "a\nb", "nud\u200bge", "x" * 201])
def test_a_name_can_stand_in_the_key_of_a_record(name):
    with pytest.raises(BadValue, match="condition"):
        Condition(interventions=(Nudge(),), name=name)


def test_settings_import_nothing_until_a_trial_is_played():
    stranger = Condition(interventions=(Recorded(spec="python:mine:Hush?x=1", doses=("x",)),))
    assert (stranger.label, stranger.dose_names) == ("python:mine:Hush?x=1", (("x",),))
    assert stranger.doses == {"python:mine:Hush.x": 1.0}
    with pytest.raises(BadValue, match="what a file or a directory names is data, and is not run"):
        interventions_in(stranger)
    known = Condition(interventions=(Recorded(spec="tremble?p=0.1", doses=("p",)),))
    assert (known.is_recorded, read_condition("tremble?p=0.1").is_recorded) == (True, False)
    assert known == Condition(interventions=(Tremble(p=0.1),))
    assert interventions_in(known) == (Tremble(p=0.1),)


def test_equal_conditions_stand_once_the_first_before():
    one, other = Condition(interventions=(OutcomeFlip(p=0.2),)), read_condition("nudge")
    assert distinct([one, other, read_condition("flip?p=0.2")]) == (one, other)


def test_doses_of_pictures_are_swept_too_and_0_is_no_dose():
    assert [one.modality for one in sweep("rgb?blur=0,8")] == ["rgb", "rgb?blur=8"]
    assert [one.spec for one in sweep("nudge + rgbd?depth=height&p=0.2,0.4")] == [
        "nudge + rgbd?depth=height&p=0.2", "nudge + rgbd?depth=height&p=0.4",
    ]  # fmt: skip
    with pytest.raises(BadValue, match="sweep"):
        sweep("rgbd?near=0.5,0.6")

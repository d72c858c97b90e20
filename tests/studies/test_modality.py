"""From a modality's spec to what stands between box and agent."""

import pytest

from lockprobe.errors import BadValue, Missing, UnknownName
from lockprobe.interventions.camera import CameraChannel
from lockprobe.interventions.condition import flips
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.words import TextChannel
from lockprobe.studies import modality
from lockprobe.studies.modality import camera, check_distinct, interventions_for, is_pictured, taken_in


def test_reports_are_flipped_and_put_into_words():
    assert interventions_for(flips((0.3,), "sticky")[0]) == (OutcomeFlip(p=0.3, persistence="sticky"), TextChannel())


@pytest.mark.parametrize(
    ("spec", "eye"),
    [
        ("rgb", CameraChannel(depth="none")),
        ("rgbd", CameraChannel(depth="turbo")),
        ("rgbd?depth=height", CameraChannel(depth="height")),
        ("rgbd?near=0.5&far=0.9", CameraChannel(depth="turbo", near=0.5, far=0.9)),
    ],
)
def test_pictures_come_from_the_camera_alone(spec, eye):
    assert is_pictured(spec)
    assert interventions_for(flips((0.0,), "sticky", (spec,))[0]) == (eye,)


def test_a_report_needs_no_camera():
    assert not is_pictured("symbolic")
    assert camera("symbolic") is None


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("depth", "no modality is called 'depth'; there are: symbolic, rgb, rgbd"),
        ("symbolic?depth=gray", r"modality: got 'symbolic\?depth=gray', expected symbolic without options"),
        ("rgbd?colour=red", "no option of rgbd is called 'colour'; there are: depth, near, far"),
        ("rgbd?depth=deep", "depth: got 'deep', expected one of none, turbo, gray, height, packed"),
        ("rgbd?depth=none", r"modality: got 'rgbd\?depth=none', expected rgbd with a kind of depth"),
        ("rgb?depth=turbo", "modality: got .*, expected rgb without options"),
        ("rgb?near=0.5", "modality: got .*, expected rgb without options"),
        ("rgbd?depth=height&near=0.5", "modality: got .*, expected depth=height without near and far"),
        ("rgbd?depth=packed&far=0.9", "modality: got .*, expected depth=packed without near and far"),
        ("rgbd?near=x", "near: got 'x', expected a number"),
    ],
)
def test_what_is_no_modality_is_refused(spec, message):
    with pytest.raises((BadValue, UnknownName), match="^" + message):
        camera(spec)


@pytest.mark.parametrize(
    ("first", "second"), [("rgbd", "rgbd?depth=turbo"), ("rgbd?near=0.5&far=0.9", "rgbd?far=0.9&near=0.50")]
)
def test_two_names_of_the_same_are_refused(first, second):
    with pytest.raises(
        BadValue, match="^modality: got .* another way to show the box than .*, which is the same$"
    ) as raised:
        check_distinct(("symbolic", first, "rgb", second))
    assert second in str(raised.value)
    assert f"than {first}," in str(raised.value)


def test_variants_of_a_modality_are_several():
    check_distinct(("symbolic", "rgb", "rgbd", "rgbd?depth=gray", "rgbd?near=0.5", "rgbd?depth=gray&near=0.5"))


def test_who_reads_reports_takes_in_no_pictures():
    shown = ("rgb", "rgbd?depth=gray", "symbolic")
    assert taken_in("human-inspired:proximity", shown) == ("symbolic",)
    assert taken_in("llm:local", ("rgb",)) == ()
    assert taken_in("viewer", shown) == shown
    assert taken_in("python:mine:Mine", shown) == shown
    with pytest.raises(UnknownName, match="no agent is called 'rando'"):
        taken_in("rando", shown)


def test_records_of_hosted_models_can_be_read_without_their_package(monkeypatch):
    def without(spec):
        raise Missing("hosted models need the package inspect_ai", "pip install it")

    monkeypatch.setattr(modality, "resolve", without)
    assert taken_in("llm:nowhere/never-seen", ("rgb", "symbolic")) == ("rgb", "symbolic")

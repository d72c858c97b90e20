"""The arms of a bridge are found by their specs, whatever the conditions are called."""

from dataclasses import replace

from lockprobe.statistics.bridge.arms import ARMS, PICTURES, WORDS, bridges_of
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.study_design import design_of

DESIGN = design_of(study("bridge"))


def test_the_study_has_all_of_them():
    assert bridges_of(DESIGN.arms) == [{arm: arm for arm in (WORDS, PICTURES, *ARMS)}]


def test_without_the_replay_or_the_words_there_is_none():
    for missing in ("replayed", WORDS, PICTURES):
        assert bridges_of([one for one in DESIGN.arms if one.label != missing]) == []


def test_names_do_not_matter_and_other_readings_are_another_bridge():
    called = study(
        agent="viewer",
        plant="fast-twin",
        condition=["seen=rgb", "one by one=yoked?claims=seen", "kept=yoked?claims=seen&others=kept", "yoked?p=0.4"],
    )
    found = bridges_of(design_of(called).arms)
    assert [(one[WORDS], one[PICTURES], one["replayed"]) for one in found] == [
        ("truth", "seen", "one by one"),
        ("truth", "seen", "kept"),
    ]


def test_half_of_the_misreadings_are_no_bridge():
    design = design_of(
        study("flips", agent="viewer", plant="fast-twin", condition=["seen=rgb", "yoked?p=0.5&claims=seen"])
    )
    assert bridges_of([replace(one) for one in design.arms]) == []

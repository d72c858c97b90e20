"""A study on several boxes: who plays which, with which luck, and what is refused."""

from collections import Counter

import pytest

from lockprobe import run_study
from lockprobe.boxes.families import ALIKE
from lockprobe.boxes.solve import optimum
from lockprobe.foundation.errors import UserMistake
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.directory import read_study

ASKED = {"agent": ["human-inspired", "random"], "p": [0, 0.4], "trials": 2, "repetitions": 1}


def test_trials_take_turns_on_the_boxes_each_with_luck_of_its_own(tmp_path):
    planned = study("flips", box="chain-4, fork,reset", **ASKED)
    trials = run_study(planned, tmp_path / "study")
    assert read_study(tmp_path / "study") == planned
    assert Counter((trial.group, trial.box) for trial in trials) == dict.fromkeys(
        ((agent, name) for agent in ("human-inspired", "random") for name in ("chain-4", "fork", "reset")), 4
    )
    assert {(trial.trial, trial.box) for trial in trials} == {
        (1, "chain-4"), (2, "fork"), (3, "reset"), (4, "chain-4"), (5, "fork"), (6, "reset"),
    }  # fmt: skip
    assert len({trial.labels for trial in trials}) > 3  # of equal trials of two boxes, too
    again = run_study(planned, tmp_path / "study")
    assert again == trials


def test_so_many_boxes_are_of_one_difficulty():
    planned = study("flips", boxes=6, agent="random", p=[0, 0.4])
    assert [optimum(one) for one in planned.boxes] == [4] * 6
    assert (planned.repetitions, planned.trials, planned.strategy_trials) == (1, 30, 120)
    assert planned.boxes == study("flips", boxes=9, agent="random").boxes[:6]
    assert {optimum(one) for one in study("why", box="random-5", boxes=3).boxes} == {5}


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"box": "chain-4,chain-4"}, "every one once"),
        ({"box": "chain-4,fork", "until": "decided"}, "none with several boxes"),
        ({"box": "chain-4", "boxes": 3}, "none with the box chain-4"),
        ({"box": "random-3", "boxes": 3}, "random-4 to random-8"),
        ({"box": []}, "at least one box"),
        ({"boxes": 1}, "boxes"),
        ({"box": "chain-4,nowhere"}, "nowhere"),
    ],
)
def test_what_has_no_meaning_is_refused(asked, said):
    with pytest.raises(UserMistake, match=said):
        study("flips", **asked)


def test_who_sees_places_learns_nothing_from_them():
    """People play several boxes of one difficulty, none of them twice; they and pictures have a new panel each trial."""
    people = study("flips", agent=["participant", "random"], p=[0, 0.4])
    assert (people.layout, [one.name for one in people.boxes]) == ("shuffled", list(ALIKE))
    assert study("flips", agent="participant", box="fork").layout == "shuffled"
    assert study("flips", agent="random", modality=["symbolic?places=yes"]).layout == "shuffled"
    assert study("flips", agent="viewer", modality=["rgb"], plant="fast-twin").layout == "shuffled"
    assert study("flips", agent="random").layout == "fixed"
    assert study("flips", agent="participant", layout="fixed", box="chain-4").layout == "fixed"

"""What suite-1 is, once and for all, and which directories are those of a suite."""

import json

import pytest

from lockprobe.boxes.beliefs.structures import interlocks
from lockprobe.boxes.families import box
from lockprobe.boxes.solve import optimum, random_success
from lockprobe.foundation.errors import BadFile, BadValue, UnknownName
from lockprobe.studies.file_names import is_suite
from lockprobe.studies.options.study_options import SUITE_NAMES
from lockprobe.studies.suites import SUITES, begin_suite, read_suite, suite_directories, suite_studies, suite_study
from lockprobe.trial.record import STATES

SUITE = SUITES["suite-1"]


def test_it_never_changes():
    """Its identity says that every setting is as when it was published."""
    studies = {name: suite_study(SUITE, name, ["random"]).identity for name in PUBLISHED}
    assert studies == PUBLISHED
    assert (SUITE.p, SUITE.trials, SUITE.looks, SUITE.seed) == ((0.0, 0.4), 36, 12, 1)


PUBLISHED = {
    "fork": "a3ff1ce0e82a",
    "chain-4": "7785c1d0511c",
    "reset": "fb005f74c157",
    "gray-code-4": "6b977c3bda93",
    "fork-pictures": "b004076d36c6",
    "gray-code-4-pictures": "9ed4fbe8fa42",
}


def test_the_command_line_knows_their_names():
    assert tuple(SUITES) == SUITE_NAMES


def test_levels_rise_as_they_are_said_to():
    boxes = [box(name) for name in SUITE.boxes]
    assert [round(100 * random_success(one, 20), 1) for one in boxes] == [56.5, 39.3, 23.1, 1.6]
    assert [optimum(one) for one in boxes] == [3, 4, 5, 8]
    assert [len(one.joints) for one in boxes] == [4] * 4


def test_exactly_the_boxes_that_are_judged_lie_in_the_prior_of_the_observer():
    def needs(one):
        """As the prior holds it: for each joint the one other that must be open; None if a box has no such form."""
        found, start = [], dict(zip(one.names, one.initial, strict=True))
        order = [one.target, *(name for name in one.names if name != one.target)]
        for name in order:
            clauses = one.interlock.get(name, ({},))
            if len(clauses) > 1 or len(clauses[0]) > 1 or any(at == start[other] for other, at in clauses[0].items()):
                return None
            found.append(next(((order.index(other), 1) for other in clauses[0]), None))
        return tuple(found)

    known = set(interlocks("single-parent", 4).needs)
    assert tuple(name for name in SUITE.boxes if needs(box(name)) in known) == SUITE.judged


def test_readers_and_lookers_play_equally_many_trials_each_in_studies_of_their_own():
    studies = suite_studies(SUITE, ["random", "viewer", "human-inspired"])
    assert list(studies) == [f"{name}{ending}" for name in SUITE.boxes for ending in ("", "-pictures")]
    assert studies["fork"].agents == ("random", "human-inspired")
    assert studies["fork"].modalities == (STATES,)
    assert studies["fork-pictures"].modalities == ("rgb", "rgbd", STATES)
    for ending in ("", "-pictures"):
        of_one = [
            study.size / len(study.agents) for name, study in studies.items() if name.endswith("s") == (ending > "")
        ]
        assert sum(of_one) == SUITE.size == 288


@pytest.mark.parametrize("agents", [[], ["random", "participant"], ["random", "random"], ["nobody"]])
def test_who_cannot_play_is_refused(agents):
    with pytest.raises((BadValue, UnknownName)):
        suite_studies(SUITE, agents)


def test_a_directory_says_which_suite_it_holds(tmp_path):
    directory = tmp_path / "new" / "suite"
    assert not is_suite(directory)
    begin_suite(directory, SUITE)
    begin_suite(directory, SUITE)
    assert is_suite(directory)
    assert read_suite(directory) is SUITE
    assert suite_directories(directory, SUITE) == []
    (directory / "reset").mkdir()
    (directory / "reset" / "study.json").write_text("{}")
    assert suite_directories(directory, SUITE) == ["reset"]


@pytest.mark.parametrize(
    "content",
    [
        "",
        "[",
        "[]",
        '{"suite": "suite-0"}',
        '{"suite": 3}',
        json.dumps({"suite": "x" * 999}),
        '{"suite": "suite-1", "until": "soon", "most": 3}',
        '{"suite": "suite-1", "until": "decided"}',
        '{"suite": "suite-1", "until": "decided", "most": 1e99}',
    ],
)
def test_a_damaged_or_unknown_one_is_refused_in_a_line(tmp_path, content):
    (tmp_path / "suite.json").write_text(content)
    with pytest.raises(BadFile) as refused:
        read_suite(tmp_path)
    assert "\n" not in str(refused.value)
    assert len(str(refused.value)) < 400


def test_neither_a_study_nor_another_suite_is_written_over(tmp_path):
    (tmp_path / "study.json").write_text("{}")
    with pytest.raises(BadFile, match="it holds a study"):
        begin_suite(tmp_path, SUITE)

"""Scores, page and verification of a suite's directory."""

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from builders import play_study, write_study

from lockprobe.boxes.families import box
from lockprobe.boxes.solve import random_success
from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.formatting import NONE, bracketed, percent, share
from lockprobe.report.suite.page import level_table, score_table, write_suite
from lockprobe.report.suite.results import suite_results
from lockprobe.report.verify.suite_verification import verify_suite
from lockprobe.statistics.suite.scores import LevelTrials, suite_score
from lockprobe.studies.suites import SUITES, begin_suite, suite_studies

SMALL = replace(SUITES["suite-1"], trials=3)


@pytest.fixture(autouse=True)
def small(monkeypatch):
    monkeypatch.setitem(SUITES, "suite-1", SMALL)


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    directory = tmp_path_factory.mktemp("suites") / "suite"
    begin_suite(directory, SMALL)
    for name, study in suite_studies(SMALL, ["random", "human-inspired"]).items():
        write_study(directory / name, study)
    with pytest.MonkeyPatch.context() as patched:
        patched.setitem(SUITES, "suite-1", SMALL)
        write_suite(suite_results(directory), directory)
    return directory


@pytest.fixture
def directory(played, tmp_path):
    return shutil.copytree(played, tmp_path / "suite")


def failing(directory):
    return [check.name for check in verify_suite(directory) if not check.holds]


def test_scores_are_those_of_the_trials_the_most_competent_first(played):
    found = suite_results(played)
    assert [(one.name, one.planned, one.partial) for one in found.entries] == [
        ("human-inspired", 24, False),
        ("random", 24, False),
    ]
    levels = []
    for name, study in suite_studies(SMALL, ["random"]).items():
        trials = play_study(study)
        told, misled = ([one for one in trials if one.p == p] for p in (0.0, 0.4))
        chance = random_success(box(name), 20)
        levels.append(LevelTrials(box=name, chance=chance, told=told, misled=misled, judged=name == "chain-4"))
    assert found.entries[1].scores == replace(suite_score(levels, together=2), ranks=(1, 2))


def test_the_file_holds_every_number_and_the_page_shows_it(played):
    found, written = suite_results(played), json.loads((played / "suite.json").read_text())
    assert written == found.plain()
    assert written["agents"][0]["competence"]["value"] == found.entries[0].scores.competence.value
    page = (played / "suite.html").read_text("utf-8")
    text = re.sub(r"\s+", " ", re.sub(r"<[^>]*>", "", page))
    for cell in {cell for table in (score_table(found), level_table(found)) for row in table for cell in row}:
        assert cell in text
    assert "<script" not in page
    assert page.count("<figure") == 1


def test_a_part_of_a_suite_says_so(tmp_path):
    begin_suite(tmp_path / "new", SMALL)
    nothing = write_suite(suite_results(tmp_path / "new"), tmp_path / "new").read_text("utf-8")
    assert "No agent has finished trials at every level yet." in nothing
    studies = suite_studies(SMALL, ["random"])
    for name in ("fork", "reset"):
        write_study(tmp_path / "new" / name, studies[name])
    found = suite_results(tmp_path / "new")
    assert (found.entries[0].partial, found.entries[0].scores.competence) == (True, None)
    assert "12 of 24 trials of random" in write_suite(found, tmp_path / "new").read_text("utf-8")


def test_agents_that_look_have_scores_of_each_modality(tmp_path):
    begin_suite(tmp_path, SMALL)
    study = suite_studies(SMALL, ["viewer"])["fork-pictures"]
    write_study(tmp_path / "fork-pictures", study, [])
    assert [one.name for one in suite_results(tmp_path).entries] == [
        "viewer (RGB)", "viewer (RGB-D)", "viewer (positions in words)",
    ]  # fmt: skip


def test_names_of_agents_are_text(tmp_path):
    begin_suite(tmp_path, SMALL)
    for name, study in suite_studies(SMALL, ["random"]).items():
        hostile = replace(study, agents=("python:a:<script>alert(1)</script>",))
        trials = [replace(one, agent=hostile.agents[0]) for one in play_study(study)]
        renamed = [replace(one, key=str(one.name)) for one in trials]
        write_study(tmp_path / name, hostile, renamed)
    found = suite_results(tmp_path)
    assert found.entries[0].scores.trials == 24
    assert "<script" not in write_suite(found, tmp_path).read_text("utf-8")


def test_what_was_played_holds(directory):
    assert failing(directory) == []
    assert len(verify_suite(directory)) == 3 + 4 * 7


def test_an_altered_score_is_found(directory):
    path = directory / "suite.json"
    path.write_text(path.read_text().replace('"trials": 24', '"trials": 25', 1))
    (found,) = [check for check in verify_suite(directory) if not check.holds]
    assert (found.name, found.failed) == ("scores", ("agents[0].trials",))


def test_a_dropped_trial_and_an_edited_record_are_found(directory):
    path = directory / "reset" / "trials.jsonl"
    lines = path.read_text("utf-8").splitlines(keepends=True)
    path.write_text("".join(lines[1:]), "utf-8")
    assert failing(directory) == ["reset: complete", "scores", "page"]
    path.write_text("".join(lines).replace('"ending":"budget"', '"ending":"solved"', 1), "utf-8")
    assert failing(directory)[0] == "reset: records"


@pytest.mark.parametrize(("setting", "value"), [("seed", 2), ("trials", 2), ("max_steps", 30)])
def test_a_study_of_other_settings_is_found(directory, setting, value):
    path = directory / "fork" / "study.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {setting: value}))
    assert failing(directory)[0] == "suite"


def test_a_level_that_is_missing_or_has_other_agents_is_found(directory):
    shutil.rmtree(directory / "fork")
    assert failing(directory) == ["suite", "scores", "page"]
    write_study(directory / "fork", suite_studies(SMALL, ["random"])["fork"])
    (first, *_) = verify_suite(directory)
    assert first.failed == ("the levels have different agents: random; random human-inspired",)


def test_a_suite_without_a_study_or_with_one_that_cannot_be_read_is_no_suite(directory, tmp_path):
    (directory / "reset" / "study.json").write_text("{")
    (first, *_) = verify_suite(directory)
    assert not first.holds
    assert "reset/study.json" in first.failed[0]
    begin_suite(tmp_path / "empty", SMALL)
    (first, *_) = verify_suite(tmp_path / "empty")
    assert (first.holds, first.failed) == (False, ("there is no study",))


def test_what_cannot_be_read_ends_in_a_line(directory):
    (directory / "suite.json").write_text("{")
    (only,) = verify_suite(directory)
    assert "not JSON" in only.said
    with pytest.raises(BadFile, match="not JSON"):
        suite_results(directory)


def test_the_table_of_agents_that_ship_is_that_of_the_file_next_to_it():
    docs = Path(__file__).parents[3] / "docs"
    scores, page = json.loads((docs / "suite-1.json").read_text("utf-8")), (docs / "suite.md").read_text("utf-8")
    for one in scores["agents"]:
        cells = [_cell(one[name], form) for name, form in FORMS.items()]
        (row,) = [line for line in page.splitlines() if line.startswith(f"| `{one['agent']}`") and cells[0] in line]
        assert [cell.partition(" (")[0] for cell in row.strip("| ").split(" | ")[1:]] == cells
        assert f"({percent(one['rationality']['chance'])})" in row


FORMS = {"competence": share, "robustness": bracketed, "misreading": share, "loops": bracketed, "rationality": share}


def _cell(found, form):
    return NONE if found is None else form(found["value"], found["low"], found["high"])


def test_a_row_of_that_table_is_played_again(monkeypatch, tmp_path):
    monkeypatch.setitem(SUITES, "suite-1", replace(SMALL, trials=36))
    begin_suite(tmp_path, SUITES["suite-1"])
    for name, study in suite_studies(SUITES["suite-1"], ["round-robin"]).items():
        write_study(tmp_path / name, study)
    (now,) = suite_results(tmp_path).plain()["agents"]
    docs = json.loads((Path(__file__).parents[3] / "docs" / "suite-1.json").read_text("utf-8"))
    (then,) = [one for one in docs["agents"] if one["agent"] == "round-robin"]
    assert json.dumps(now) == json.dumps(then)


@pytest.mark.parametrize(
    ("where", "name", "section"),
    [
        ("statistics.suite.scores", "_loops", "Loops of human-inspired"),
        ("statistics.suite.scores", "_robustness", "Robustness of random"),
        ("report.suite.results", "possible_ranks", "Ranks"),
        ("report.suite.page", "_picture", "Figure scores"),
        ("report.suite.page", "suite_said", "First sentence"),
        ("report.suite.page", "level_table", "Table levels"),
    ],
)
def test_no_score_table_or_figure_keeps_the_page_from_being_written(monkeypatch, directory, where, name, section):
    def broken(*_, **__):
        raise RuntimeError("broken on purpose")

    told = []
    with monkeypatch.context() as patched:
        patched.setattr(f"lockprobe.{where}.{name}", broken)
        page = write_suite(suite_results(directory), directory, left_out=told.append)
    assert section in [one.section for one in told]
    for one in told:
        assert f"{one.section} (RuntimeError: broken on purpose)" in page.read_text("utf-8")
    assert json.loads((directory / "suite.json").read_text())["sections_left_out"] == [
        {"section": one.section, "reason": one.reason} for one in told
    ]

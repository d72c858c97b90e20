"""Verification finds what was edited, dropped, altered or played with other luck, and nothing where nothing was."""

import json
import shutil

import pytest
from builders import play_study, small_study, with_right_checksums, write_study
from taking_part import take_part
from typed import typed
from typer.testing import CliRunner

from lockprobe import run_study, study
from lockprobe.cli import build
from lockprobe.foundation.storage.jsonl import with_checksum, without_checksum
from lockprobe.report.verify.verification import verify
from lockprobe.report.write import write_report


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    directory = tmp_path_factory.mktemp("study") / "out"
    agents = ["human-inspired", "cognitive:careful", "random"]
    run_study(study("flips", agent=agents, p=[0, 0.4], trials=3, repetitions=1, max_steps=8), directory)
    write_report(directory)
    return directory


@pytest.fixture
def directory(played, tmp_path):
    return shutil.copytree(played, tmp_path / "out")


def failing(directory):
    return {check.name: check.failed for check in verify(directory) if not check.holds}


def changed(directory, key, change):
    """Change one record and give it the checksum of what it says now."""
    path = directory / "trials.jsonl"
    lines = path.read_text("utf-8").splitlines()
    (place,) = [i for i, line in enumerate(lines) if f'"{key}"' in line]
    record = json.loads(without_checksum(lines[place].encode()))
    change(record)
    lines[place] = with_checksum(json.dumps(record, ensure_ascii=False, separators=(",", ":")).encode()).decode()
    path.write_text("\n".join(lines) + "\n", "utf-8")


def test_a_study_as_it_was_played_holds(directory):
    assert [check.name for check in verify(directory)] == [
        "records", "settings", "complete", "luck", "choices", "agents", "results", "report",
    ]  # fmt: skip
    assert failing(directory) == {}


def test_an_edited_record_is_found_by_its_checksum(directory):
    path = directory / "trials.jsonl"
    path.write_text(path.read_text("utf-8").replace('"ending":"budget"', '"ending":"solved"', 1), "utf-8")
    assert list(failing(directory)) == ["records"]


KEY = "flips/human-inspired/flip?p=0.4/rep=1/trial=2"


@pytest.mark.parametrize(
    ("change", "found"),
    [
        (lambda record: record["steps"][1].update(told_moved=not record["steps"][1]["told_moved"]), "step 2, told_moved"),
        (lambda record: record["steps"][1].update(told="Nothing."), "step 2, told"),
        (lambda record: record.update(opening="Nothing."), "opening"),
        (lambda record: record.update(listing=record["listing"][::-1]), "listing"),
    ],
    ids=["outcome", "words", "opening", "listing"],
)  # fmt: skip
def test_reports_that_do_not_follow_are_found_though_their_checksum_is_right(directory, change, found):
    changed(directory, KEY, change)
    fails = failing(directory)
    assert fails["luck"] == (f"{KEY}: {found}",)
    assert fails["choices"] == (f"{KEY}: {found}",)


def test_a_truth_that_contradicts_itself_is_no_record(directory):
    changed(directory, KEY, lambda record: record["steps"][2].update(moved=not record["steps"][2]["moved"]))
    assert failing(directory).keys() & {"records", "luck"}


def test_a_trial_cut_short_is_found(directory):
    changed(directory, KEY, lambda record: record["steps"].pop())
    assert failing(directory).keys() & {"records", "luck"}


def test_choices_that_a_strategy_does_not_make_are_found(directory):
    changed(directory, KEY, lambda record: record["steps"][0]["decision"].update(hypothesis="made up"))
    fails = failing(directory)
    assert fails["choices"] == (f"{KEY}: step 1, decision (hypothesis)",)
    assert "luck" not in fails


def test_a_dropped_trial_is_found(directory):
    path = directory / "trials.jsonl"
    lines = path.read_text("utf-8").splitlines(keepends=True)
    path.write_text("".join(line for line in lines if f'"{KEY}"' not in line), "utf-8")
    assert failing(directory)["complete"] == (KEY,)


def test_another_seed_is_found(directory):
    path = directory / "study.json"
    settings = json.loads(path.read_text("utf-8"))
    path.write_text(json.dumps(settings | {"seed": settings["seed"] + 1}), "utf-8")
    assert "settings" in failing(directory)


def test_a_diary_that_disagrees_with_its_record_is_found_without_a_report(tmp_path):
    take_part(tmp_path, small_study(["participant"], p=[0.0], trials=1), "aaaa01", [(0.0, 1, 1)])
    assert failing(tmp_path) == {}
    path = tmp_path / "people" / "aaaa01.jsonl"
    lines = [json.loads(line) for line in path.read_bytes().splitlines()]
    next(line for line in lines if line.get("box") == 1)["act"]["claimed"] = "moved"
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    with_right_checksums(path)
    (check,) = verify(tmp_path)
    assert (check.name, check.holds) == ("records", False)
    assert "trials.jsonl" in check.said


def test_an_altered_picture_is_found(tmp_path):
    shown = {
        "agent": ["viewer"],
        "modality": ["rgb"],
        "plant": "fast-twin?width=160&height=120",
        "trials": 1,
        "max_steps": 1,
    }
    run_study(study("modalities", repetitions=1, **shown), tmp_path)
    assert failing(tmp_path) == {}
    picture = next((tmp_path / "pictures").iterdir())
    picture.write_bytes(picture.read_bytes() + b" ")
    assert failing(tmp_path)["pictures"] == (picture.name,)


def test_an_altered_result_is_named(directory):
    path = directory / "results.json"
    written = json.loads(path.read_text("utf-8"))
    row = next(row for row in written["rows"] if row["quantity"] == "success" and row["condition"] == "flip?p=0.4")
    row["count"] += 1
    path.write_text(json.dumps(written), "utf-8")
    name = f"success, {row['agent']}, {row['modality']}, flip?p=0.4"
    assert failing(directory) == {
        "results": (f"rows: {name}: count {row['count']} written, {row['count'] - 1} computed",)
    }


def test_forks_that_are_newer_than_the_report_are_said_to_be(directory):
    assert typed("branch", directory, "flips/random/flip?p=0.4", "--at", "2", "--told", "lie").returncode == 0
    check, pages = [check for check in verify(directory) if not check.holds]
    assert (check.name, check.said) == (
        "results",
        "forks were played after results.json was written: lockprobe report first",
    )
    assert pages.said.endswith("; the records are newer: lockprobe report first")
    write_report(directory)
    assert failing(directory) == {}
    shutil.rmtree(directory / "forks")
    check, pages = [check for check in verify(directory) if not check.holds]
    assert "values of results.json differ" in check.said
    assert "tables/forks.csv: no file of this report" in pages.failed


def test_of_a_study_of_people_it_says_how_many_played(tmp_path):
    planned = small_study(("participant", "random"), (0.0,), 1, 3)
    path = write_study(tmp_path / "study", planned, [*play_study(small_study(("random",), (0.0,), 1, 3))])
    said = {check.name: (check.holds, check.said) for check in verify(path)}
    assert said["complete"] == (True, "every planned trial is there; of people 0 of 3, who owe none")


def test_the_command_ends_with_one_and_names_what_fails(directory):
    def verified(*more):
        return CliRunner().invoke(build(["verify"]), ["verify", str(directory), *more])

    assert verified().exit_code == 0
    (directory / "results.json").write_text("{", "utf-8")
    done = verified()
    assert done.exit_code == 1
    assert "FAILS  results   results.json is damaged" in done.stdout
    found = json.loads(verified("--json").stdout)
    assert (found["holds"], [one["name"] for one in found["checks"] if not one["holds"]]) == (False, ["results"])

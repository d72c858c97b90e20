"""Directories that the release before conditions made open, go on and report as before."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from lockprobe.report import write_report
from lockprobe.studies.journal import Journal, load
from lockprobe.studies.runner import run
from lockprobe.studies.settings import read_study
from lockprobe.studies.study_options import StudyOptions
from lockprobe.studies.studyfile import study

OLD = Path(__file__).parents[1] / "golden" / "studies_v1"
ASKED = StudyOptions(
    agent=["random", "human-inspired"], p=[0, 0.4], trials=3, repetitions=1, flip="sticky", max_steps=12
)
"""The options by which the older release made the flip study."""


@pytest.mark.parametrize("name", ["flips", "modalities"])
def test_settings_are_those_of_a_study_and_are_written_again_byte_for_byte(name):
    kept = (OLD / name / "study.json").read_text()
    assert json.dumps(read_study(OLD / name).settings(), indent=2) + "\n" == kept


@pytest.mark.parametrize("name", ["flips", "modalities"])
def test_every_record_is_one_of_the_study(name):
    planned, trials = read_study(OLD / name), load(OLD / name)
    assert len(trials) == planned.size
    assert all(map(planned.asks_for, trials))


@pytest.mark.parametrize("name", ["flips", "modalities"])
def test_the_report_says_what_it_said(name, tmp_path, monkeypatch):
    monkeypatch.setattr("lockprobe.figures.render", lambda figure, form: b"<svg/>")  # numbers are looked at here
    directory = shutil.copytree(OLD / name, tmp_path / name)
    write_report(directory)
    rows = json.loads((directory / "results.json").read_text())["conditions"]
    before = json.loads((OLD / name / "conditions.json").read_text())
    assert [{key: row[key] for key in old} for row, old in zip(rows, before, strict=True)] == before


def test_the_same_command_plays_what_is_owed_and_counts_what_was_changed(tmp_path):
    directory = shutil.copytree(OLD / "flips", tmp_path / "flips")
    lines = (OLD / "flips" / "trials.jsonl").read_bytes().splitlines(keepends=True)
    (directory / "trials.jsonl").write_bytes(b"".join(lines[:7]))
    planned = study(ASKED, modality=["symbolic"])
    assert planned == read_study(directory)
    with Journal.open(directory, planned) as journal:
        run(planned, journal)
    played, before = ({trial.key: trial for trial in load(one)} for one in (directory, OLD / "flips"))
    assert {key: replace(trial, changed={}, changed_steps=0) for key, trial in played.items()} == before
    assert any(trial.changed_steps for trial in played.values())

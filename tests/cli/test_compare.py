"""``lockprobe report`` of several studies, as it is typed."""

import json
from dataclasses import replace

import pytest
from builders import play_study, small_study, write_study

from lockprobe.interventions.conditions import read_condition

STUDY = small_study(agents=("cognitive:careful", "random"), p=(0.0, 0.3), repetitions=1)


@pytest.fixture(scope="module")
def labs(tmp_path_factory):
    root = tmp_path_factory.mktemp("labs")
    other = replace(STUDY, agents=("cognitive:perseverant",), seed=3)
    return write_study(root / "a", STUDY), write_study(root / "b", other)


def test_in_words(lockprobe, labs, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    status, said, _ = lockprobe("report", *labs)
    lines = said.splitlines()
    assert status == 0
    assert "difference" in lines[0]
    assert lines[-1] == "Comparison: compare.html"
    assert (tmp_path / "compare.html").is_file()
    assert not any(line.startswith(("Only in", "Partial", "Different")) for line in lines)
    success = [line.split() for line in lines if line.startswith("truth ")]
    assert [(row[1], row[2], row[5]) for row in success] == [
        ("a", "cognitive:careful", "4"),
        ("a", "random", "4"),
        ("b", "cognitive:perseverant", "4"),
    ]
    assert sum(line.startswith("cognitive:perseverant in b") for line in lines) == 2  # under two conditions


def test_what_is_unfinished_or_differs_is_said_before_the_numbers(lockprobe, labs, tmp_path):
    other = replace(STUDY, seed=3, conditions=tuple(map(read_condition, ("truth", "nudge", "tremble?p=0.2"))))
    played = [replace(trial, facts=trial.facts | {"noise": 0.25}) for trial in play_study(other)[:20]]
    half = write_study(tmp_path / "half", other, played)
    lines = lockprobe("report", labs[0], half, "--out", tmp_path)[1].splitlines()
    numbers = next(i for i, line in enumerate(lines) if "success" in line and "agent" in line)
    assert {*lines[1:numbers]} >= {
        f"Partial: 20 of {other.size} trials of half are finished.",
        "Only in a: flip?p=0.3.",
        "Only in half: nudge; tremble?p=0.2.",
        "Different settings: cognitive:careful: noise is None in a, 0.25 in half",
    }
    found = json.loads(lockprobe("report", *labs, "--json", "--out", tmp_path, "--agent", "random")[1])
    assert (found["page"], {row["agent"] for row in found["rows"]}) == (str(tmp_path / "compare.html"), {"random"})

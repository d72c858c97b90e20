"""``lockprobe list``: models with what is known of them and what they are sent; measures, and their means of a study."""

import io
import json
from contextlib import redirect_stdout

import pytest
import strangers
from builders import small_study, write_study
from typed import in_process

from lockprobe.agents.llm.model_facts import OWN_FACTS, price_of
from lockprobe.cli.printing import print_rows
from lockprobe.statistics.measures import MEASURES, find_measure, measured
from lockprobe.studies.records.read_records import load


@pytest.fixture(autouse=True)
def nothing_of_ones_own(monkeypatch):
    monkeypatch.delenv(OWN_FACTS, raising=False)


def show(*words):
    return in_process("list", "models", *words).stdout


def test_what_is_sent_stands_beside_what_is_known_and_the_price_has_its_date():
    lines = [line.split(maxsplit=2) for line in show("llm:openai/gpt-4o?temperature=0.5").splitlines()]
    assert ["sent", "temperature", "0.5"] in lines
    assert ["known", "most_output", "16384"] in lines
    assert ["known", "reasons", "false"] in lines
    (price,) = (value for _, what, value in lines[1:] if what == "price")
    assert price.startswith('{"input": 2.5, "cached": 1.25, "output": 10.0, "stored": 2.5, "date": "genai-prices ')


def test_json_has_every_fact_and_without_a_name_the_embedded_model_and_prices_are_listed():
    (line,) = show("openai/o1?effort=low", "--json").splitlines()
    found = json.loads(line)
    assert (found["model"], found["facts"]["reasons"], found["sent"]["effort"]) == ("openai/o1", True, "low")
    assert found["facts"]["price"]["output"] == price_of("openai/o1").output
    lines = show().splitlines()
    assert lines[0].startswith("llm:local  ")
    assert any(line.startswith("llm:openai/gpt-4o ") and "2.5 in, 10 out" in line for line in lines)


@pytest.fixture
def directory(tmp_path):
    return write_study(tmp_path / "S", small_study(["random", "human-inspired"], p=[0.0, 0.6], trials=3))


def test_every_measure_is_listed_with_what_it_is_and_its_means_of_a_study_are_those_of_its_conditions(
    lockprobe, directory
):
    rows = [json.loads(line) for line in lockprobe("list", "measures", "--json")[1].splitlines()]
    assert ([row["spec"] for row in rows], all(row["what"] for row in rows)) == (list(MEASURES), True)
    rows = [json.loads(line) for line in lockprobe("list", "measures", directory, "--json")[1].splitlines()]
    assert [row["name"] for row in rows] == ["solved"] * 4
    trials = [trial for trial in load(directory) if trial.agent == "random" and trial.p == 0.6]
    expected = measured(trials, find_measure("solved"))
    (row,) = (row for row in rows if (row["agent"], row["condition"]) == ("random", "flip?p=0.6"))
    assert (row["value"], row["low"], row["high"], row["n"]) == (expected.value, expected.low, expected.high, 6)
    status, out, err = lockprobe("list", "measures", directory, "--measure", "solved")
    assert (status, err, len(out.splitlines())) == (0, "", 5)
    assert [line.split()[:3] for line in out.splitlines()[1:3]] == [
        ["random", "truth", "solved"],
        ["random", "flip?p=0.6", "solved"],
    ]


def test_a_measure_of_one_s_own_is_named_on_the_command_line(lockprobe, directory, tmp_path, monkeypatch):
    strangers.install(tmp_path, monkeypatch)
    said = lockprobe(
        "list", "measures", directory, "--measure", "python:strange:hasty", "--measure", "untold?weight=2", "--json"
    )
    names = {json.loads(line)["name"]: json.loads(line)["kind"] for line in said[1].splitlines()}
    assert names == {"python:strange:hasty": "share", "untold?weight=2": "mean"}
    status, out, err = lockprobe("list", "measures", directory, "--measure", "python:strange:breaks")
    assert (status, out) == (2, "")
    assert err == "lockprobe: measure 'python:strange:breaks' does not work (ZeroDivisionError: by nothing)\n"


class Terminal(io.StringIO):
    """Looks like a terminal."""

    def isatty(self):
        return True


@pytest.mark.parametrize("kind", [Terminal, io.StringIO])
def test_no_number_is_cut(monkeypatch, kind):
    monkeypatch.setenv("COLUMNS", "80")
    names = ["the name of something that is told in many words, one after another", "x", "python:robot:Robot"]
    rows = [["name", *"abcde"], *([name, *["123456.789012"] * 5] for name in names), ["", *"12345"]]
    with redirect_stdout(kind()) as file:
        print_rows(rows)
    text = file.getvalue()
    assert text.count("123456.789012") == 15
    assert " ".join(text.split()).count("something") == 1
    lines = text.splitlines()
    if kind is io.StringIO:
        assert [" ".join(line.split()) for line in lines] == [" ".join(row).strip() for row in rows]
    else:
        assert max(map(len, lines)) <= len("something") + 2 * 5 + 13 * 5 + 10  # the longest word, and no more
    assert text.split()[:2] == ["name", "a"]

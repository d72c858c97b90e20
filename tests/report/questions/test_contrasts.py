"""What a study asks by itself: numbers that are those of the records, on the page and in the terminal before all else."""

import json

import numpy as np
import pytest
from builders import write_study
from reported import tables_of
from stored import records

import lockprobe
from lockprobe.foundation.errors import BadFile
from lockprobe.report.page import Page, parts_of
from lockprobe.report.primary import primary_lines
from lockprobe.report.results import results
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import load

FILE = """
agent = ["cognitive:perseverant", "human-inspired", "random"]
trials = 20
repetitions = 1
condition = ["kept=flip?p=0.4&others=kept", "odd=distract?p=0.4"]

[contrasts]
"a lie that stays" = { of = "kept", minus = "truth" }
"any odd report" = { of = ["kept", "odd"], minus = ["truth"] }
"""


@pytest.fixture(scope="module")
def asked(tmp_path_factory):
    """The directory of a study whose file declares contrasts, and its results."""
    under = tmp_path_factory.mktemp("contrasts")
    (under / "mine.toml").write_text(FILE)
    directory = write_study(under / "study", study(under / "mine.toml"))
    return directory, results(directory)


def test_a_contrast_is_a_mean_over_blocks_of_equal_luck(asked):
    directory, found = asked
    solved = {(one.agent, one.condition, one.trial): one.solved for one in load(directory)}
    rows = found.where("success_difference", family="contrasts")
    assert len(rows) == 6
    for row in rows:
        of = found.design.contrasts[row.of]
        blocks = [
            np.mean([solved[row.agent, name, trial] for name in of.of])
            - np.mean([solved[row.agent, name, trial] for name in of.minus])
            for trial in range(1, 21)
        ]
        assert (row.value, row.n) == (pytest.approx(np.mean(blocks)), 20)
        assert row.corrected_for == (2 if row.agent == "cognitive:perseverant" else 4)  # baselines apart


def test_the_first_screen_has_the_first_in_its_list_and_the_others_in_its_table(asked):
    _, found = asked
    table = Page(found=found).text().partition('class="changes"')[2].partition("</section>")[0]
    assert (table.count(">any odd report<"), table.count(">a lie that stays<")) == (3, 0)
    assert {line.cause for line in primary_lines(found)} == {"a lie that stays"}


def test_the_first_one_is_the_question_of_the_page_and_a_line_an_agent(asked):
    _, found = asked
    lines = primary_lines(found)
    assert [line.label for line in lines] == ["cognitive:perseverant", "human-inspired", "random"]
    for line in lines:
        assert line.change is found.one(
            "success_difference", family="contrasts", agent=line.agent, of="a lie that stays"
        )
        assert line.change.value == pytest.approx(line.second.value - line.first.value)
        assert line.first.low <= line.first.value <= line.first.high
    assert found.fact("overview", "question") == "Does a lie that stays change how agents open chain-4?"
    assert "a lie that stays" in found.answer.lower()
    (part,) = (one for one in parts_of(found) if one.name == "contrasts")
    assert part.answer.endswith("of 6 contrasts detected.")
    assert [row[1] for row in tables_of(found)["contrasts"][1:3]] == ["a lie that stays", "any odd report"]


def test_it_changes_no_trial_and_stands_in_the_settings_until_another_is_asked(tmp_path):
    of = {"of": "flip?p=0.4", "minus": "truth"}
    plain = study("flips", agent="random", p=[0, 0.4], trials=2, repetitions=1)
    first, other = (study("flips", agent="random", p=[0, 0.4], trials=2, repetitions=1, contrasts={name: of})
                    for name in ("lies", "false reports"))  # fmt: skip
    assert plain == first == other
    assert plain.identity == first.identity
    directory, played = tmp_path / "study", []
    for planned, there in ((first, ["lies"]), (plain, ["lies"]), (other, ["false reports"])):
        lockprobe.run_study(planned, directory)
        played.append(records(directory))
        assert list(read_study(directory).contrasts) == there
    assert played == [played[0]] * 3
    settings = json.loads((directory / "study.json").read_text())
    (directory / "study.json").write_text(
        json.dumps(settings | {"contrasts": {"x": {"of": ["no"], "minus": ["truth"]}}})
    )
    with pytest.raises(BadFile, match="no condition of the contrast x is called 'no'"):
        read_study(directory)


def test_the_page_says_what_changes_what_is_misread(tmp_path):
    (tmp_path / "mine.toml").write_text("""
agent = "cognitive:perseverant"
trials = 12
repetitions = 1
condition = ["lie=flip?p=0.4", "shaken=tremble?p=0.6"]
[contrasts]
lies = { of = "lie", minus = "truth", measure = "misreading" }
tremor = { of = "shaken", minus = "truth", measure = "misreading" }
""")
    found = results(write_study(tmp_path / "study", study(tmp_path / "mine.toml")))
    assert found.answer == "Misreading changes with lies."
    assert found.fact("overview", "question") == "Do lies and tremor change what agents misread of chain-4?"
    assert [line[0] for line in tables_of(found)["contrasts"]] == ["contrast", "lies", "tremor"]

"""Studies side by side: the numbers are those of the records, the conclusion says no more, and the page is inert."""

import re
from dataclasses import replace

import pytest
from builders import SOLUTION, make_trial, play_study, small_study, write_study

from lockprobe.interventions.conditions import read_condition
from lockprobe.report.compare import (
    Sample,
    compare_studies,
    conclusion,
    difference_table,
    study_differences,
    study_table,
    success_table,
    write_comparison,
)
from lockprobe.report.format import texts
from lockprobe.statistics.proportions import proportion
from lockprobe.studies.records.read_records import load

AGENTS = ("cognitive:careful", "random")
A = small_study(agents=AGENTS)
B = replace(A, agents=("cognitive:perseverant", "random"), conditions=small_study(p=(0.3, 0.0, 0.9)).conditions)
C = replace(B, seed=7)
NAMES = ["one/study", "two/study", "half"]


@pytest.fixture(scope="module")
def labs(tmp_path_factory):
    root = tmp_path_factory.mktemp("labs")
    half = play_study(C)[:20]
    return [
        write_study(root / "one" / "study", A),
        write_study(root / "two" / "study", B),
        write_study(root / "half", C, half),
    ]


@pytest.fixture(scope="module")
def found(labs):
    return compare_studies(labs)


@pytest.fixture(scope="module")
def page(found, tmp_path_factory):
    return write_comparison(found, tmp_path_factory.mktemp("page") / "compare.html").read_text("utf-8")


def sides(found):
    return [(one.condition, one.study) for one in found.samples]


def test_success_is_counted_from_the_records_of_the_conditions_that_two_studies_share(labs, found):
    counted = {}
    for name, directory in zip(NAMES, labs, strict=True):
        for trial in load(directory):
            condition = f"flip?p={trial.p:g}" if trial.p else "truth"
            if condition != "flip?p=0.6":
                counted.setdefault((condition, name, trial.agent), []).append(trial.solved)
    assert {(one.condition, one.study, one.agent): one.success for one in found.samples} == {
        key: proportion(sum(solved), len(solved)) for key, solved in counted.items()
    }
    told = {(row["condition"], row["study"], row["agent"]): row for row in found.plain()["success"]}
    assert {key: (row["solved"], row["trials"]) for key, row in told.items()} == {
        key: (sum(solved), len(solved)) for key, solved in counted.items()
    }
    for one in found.differences:  # luck is shared by seed
        studies = {one.first.study, one.second.study}
        assert one.paired == ("half" not in studies or len(studies) == 1)
    columns = ("name", "partial", "finished", "planned", "not_shared")
    assert [tuple(one[column] for column in columns) for one in found.plain()["studies"]] == [
        ("one/study", False, 48, 48, ["flip?p=0.6"]),
        ("two/study", False, 48, 48, []),
        ("half", True, 20, 48, []),
    ]


def test_every_condition_that_two_studies_share_is_compared_and_what_one_has_is_named(tmp_path):
    """Studies without a flip, with other names for the same conditions and in another order."""
    flipless = replace(A, agents=("cognitive:careful",), repetitions=1, trials=3)

    def lab(name, *conditions):
        return write_study(tmp_path / name, replace(flipless, conditions=tuple(conditions)))

    doses = [read_condition(f"tremble?p={p}") for p in (0.1, 0.2)]
    one = lab("a", read_condition("truth"), read_condition("drop?p=0.3", "mute"), *doses, read_condition("nudge", "x"))
    two = lab("b", *doses, read_condition("drop?p=0.3", "x"), read_condition("warn", "mute"), read_condition("truth"))
    found = compare_studies([one, two])
    shared = ["truth", "tremble?p=0.1", "tremble?p=0.2", "drop?p=0.3"]
    assert sides(found) == [(name, study) for name in shared for study in "ab"]
    rows = found.plain()["differences"]
    assert [row["condition"] for row in rows] == shared
    assert [row["family"] for row in rows] == ["flip rate", "tremble p", "tremble p", ""]
    assert all((row["paired"], row["value"], row["p_value"]) == (True, 0, 1) for row in rows)  # one seed
    assert [one["not_shared"] for one in found.studies] == [["nudge"], ["warn"]]


# The conclusion


def sample(study, solved, *, luck=1, condition="truth", family=""):
    trials = [make_trial(SOLUTION if i < solved else (0,) * 20, agent="llm:a", trial=i + 1) for i in range(20)]
    return Sample(study=study, agent="llm:a", condition=condition, family=family, luck=luck, trials=trials)


FLIPS = [sample(study, 10, luck=luck, family="flip rate") for luck, study in enumerate("ab")]
NUDGED = [sample(study, n, condition="nudge", luck=luck) for luck, (study, n) in enumerate((("a", 4), ("b", 11)))]
CLEAR = [sample(study, n, condition="nudge") for study, n in (("a", 1), ("b", 19))]


CONCLUSIONS = [
    ([], ["No two studies have a trial to compare under a condition that they share."]),
    (
        [sample("a", 9), sample("b", 11, luck=2), sample("c", 10, luck=3)],
        [
            "No difference between studies was detected in 3 comparisons, ",
            "P = 1, corrected for 3 differences of a family and 1 family; ",
        ],
    ),
    # a P value of 0.03 in its family: the sentence is about two, and the table about each
    (
        [*FLIPS, *NUDGED],
        [
            "No difference between studies was detected in 2 comparisons, ",
            ", corrected for 1 difference of a family and 2 families; ",
        ],
    ),
    (
        [*FLIPS, *CLEAR],
        ["1 of 2 differences between studies was detected, the clearest: llm:a in b against ", "random numbers)."],
    ),
]


@pytest.mark.parametrize(("samples", "parts"), CONCLUSIONS)
def test_the_conclusion_says_no_more_than_what_holds_in_all_families(samples, parts):
    said = conclusion(study_differences(samples))
    assert said.startswith(parts[0])
    assert said.endswith(parts[-1]) or len(parts) < 3
    assert all(part in said for part in parts)


# The page


def test_the_page_begins_with_the_sentence_holds_every_number_and_loads_nothing(found, page):
    text = re.sub(r"\s+", " ", re.sub(r"<[^>]*>", "", page))
    assert text.index(found.said) < text.index("Share solved of the trials")
    assert "20 of 48 trials of half" in text
    tables = (success_table(found), study_table(found), difference_table(found.differences))
    for cell in {cell for table in tables for row in texts([*table]) for cell in row} - {"of these, people's"}:
        assert cell in text
    assert page.count('<td class="pl">') == len(found.differences)
    assert "more differences: with baselines, and within one study" in text
    assert "default-src 'none'; img-src data:; style-src 'unsafe-inline'\"" in page
    assert "<script" not in page
    assert not re.findall(r'(?:src|href)="([^"]*)"', page)

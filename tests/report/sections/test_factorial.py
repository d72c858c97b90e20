"""A factorial design on the page: here of three interventions, in all their combinations."""

from dataclasses import replace
from itertools import combinations

import pytest
from builders import write_study

from lockprobe.report.opened import open_study
from lockprobe.report.pages import page_of, tables_of
from lockprobe.report.results import results_of
from lockprobe.report.study_numbers import study_numbers
from lockprobe.studies.options.studyfile import study

AGENT = "cognitive:perseverant"
PARTS = ["tremble?p=0.6", "flip?p=0.4", "nudge"]
CONDITIONS = [" + ".join(one) for size in (1, 2, 3) for one in combinations(PARTS, size)]
ASKED = study("flips", agent=[AGENT], repetitions=1, trials=12, condition=CONDITIONS)


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    return results_of(study_numbers(open_study(write_study(tmp_path_factory.mktemp("lab") / "study", ASKED))))


def test_every_factor_has_an_effect_on_both_measures(found):
    rows = found.where("factor_effect")
    assert {row.of for row in rows} == {"misreading", "success"}
    assert {row.axis for row in rows} == {"tremble.p=0.6", "flip.p=0.4", "nudge=yes"}
    success = {
        condition: found.one("success", agent=AGENT, condition=condition).value for condition in ["truth", *CONDITIONS]
    }
    high = [share for condition, share in success.items() if "tremble" in condition]
    low = [share for condition, share in success.items() if "tremble" not in condition]
    row = found.one("factor_effect", of="success", axis="tremble.p=0.6")
    assert row.value == pytest.approx(sum(high) / 4 - sum(low) / 4)
    assert (row.clusters, row.corrected_for) == (12, 3)
    assert found.one("factor_effect", of="misreading", axis="flip.p=0.4").value > 0.2


def test_one_block_is_too_few_to_say(tmp_path):
    short = results_of(study_numbers(open_study(write_study(tmp_path / "study", replace(ASKED, trials=1)))))
    assert short.answer_of("overview") == (
        "Not known yet: the answer needs two blocks or more with an ended trial in every condition."
    )


def test_the_page_says_which_matter(found):
    answer = found.answer_of("overview")
    assert f"{AGENT} misreads" in answer
    assert "misreading changes with flip.p=0.4 (+" in answer
    assert "Which features matter?" in page_of("report", found)
    assert [line[2] for line in tables_of(found)["factorial"]][:4] == [
        "factor",
        "tremble.p=0.6",
        "flip.p=0.4",
        "nudge=yes",
    ]

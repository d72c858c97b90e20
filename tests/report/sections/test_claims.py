"""The page of the paper's claims: what each agent says to each, and where nobody is judged."""

import re

import pytest
from builders import modality_study, small_study, write_study
from clumsy import CLUMSY

from lockprobe.foundation.left_out import LeftOutSection
from lockprobe.report.claims.paper import CLAIMS
from lockprobe.report.opened import open_study
from lockprobe.report.pages import page_of, parts_of, tables_of
from lockprobe.report.results import results_of, with_left_out
from lockprobe.report.study_numbers import study_numbers
from lockprobe.studies.options.studyfile import study


def found_of(directory, planned, trials=None):
    return results_of(study_numbers(open_study(write_study(directory / "study", planned, trials))))


@pytest.fixture(scope="module")
def modalities(tmp_path_factory, modal):
    return found_of(tmp_path_factory.mktemp("modalities"), modality_study(), modal)


@pytest.fixture(scope="module")
def clumsy(tmp_path_factory):
    planned = study("flips", agent=["cognitive:careful"], p=[0, 0.4], trials=6, repetitions=1, plant=CLUMSY)
    return found_of(tmp_path_factory.mktemp("clumsy"), planned)


def test_no_two_claims_have_one_name():
    assert len({claim.name for claim in CLAIMS}) == len(CLAIMS)


def test_every_claim_of_the_section_on_modalities_is_measured(modalities):
    here = {row.of: row for row in modalities.where("claim", agent="viewer", modality="")}
    said = {name: modalities.said("claims", name)[0] for name in here}
    assert here["modality-order"].note == here["modality-outpaces"].note == "borne out"
    assert here["modality-order"].test == "log-rank test for a trend over fidelity, and the order of the mean steps"
    assert (
        said["modality-order"] == "mean steps 5.9 with RGB, 9.9 with RGB-D, 13.9 with positions and outcomes in words"
    )
    assert here["modality-steps"].note == "compatible"
    assert re.search(r"80 % by step 15 \[.*with positions and outcomes in words", said["modality-steps"])
    assert said["modality-outpaces"].startswith(
        "RGB reaches 10 of 10 tenths of success before RGB-D, 0 after it; RGB-D"
    )
    assert "with RGB, " in said["reference-faster"]
    misread = [row for row in modalities.where("claim") if row.of.startswith("misinterpretation, ")]
    labels = [modalities.label(row.agent, row.modality) for row in misread]
    assert labels == ["viewer (RGB)", "viewer (RGB-D)"]


def test_each_p_value_stands_after_its_own_test_and_before_what_else_is_said(tmp_path):
    found = found_of(tmp_path, small_study(("cognitive:perseverant",), (0.0, 0.4), 2, 8))
    page = re.sub(r"</?i>|&#39;|<wbr>", "", page_of("claims", found))
    said = 0
    for row in (row for row in found.where("claim") if row.p_value is not None and ";" in row.test):
        test, _, more = row.test.replace("'", "").partition(";")
        said += 1
        assert f"({test}, P = {row.p_value:.2g};{more})" in page
        assert not re.match(r"no |fewer |more ", test)
    assert said >= 3


def test_the_table_has_every_claim_in_the_order_of_the_paper(modalities):
    head, *rows = tables_of(modalities)["claims"]
    assert list(dict.fromkeys(row[1] for row in rows)) == [claim.quote for claim in CLAIMS]
    assert len(rows) == len(modalities.where("claim")) + sum(row[6] == "not measured" for row in rows)
    assert len(head) == len(rows[0])


def test_headings_give_verdicts_and_quotations(modalities):
    parts = {part.name: part for part in parts_of(modalities, "claims")}
    assert list(parts) == [f"claim-{i}" for i in range(1, len(CLAIMS) + 1)]
    assert parts["claim-4"].heading == "Borne out"
    assert parts["claim-4"].answer == (
        "“GPT o1 performs best with RGB input and worst with ground-truth state, with RGB-D falling in between.” "
        "(Sec. 3.1, Fig. 3)"
    )
    assert parts["claim-11"].answer.endswith("error rate of approximately 5% at...” (Sec. 3.1, Table 1)")
    assert parts["claim-14"].heading == "Not measured"
    page = page_of("claims", modalities)
    assert "not measured in this study" in page
    assert "Table entry: State Misinterpretation Rates Across Input Modalities, row RGB-D" in page
    assert "\u201cState Misinterpretation" not in page
    assert "\u201cperformance rises to a peak" in page


def test_verdicts_of_several_agents_are_counted(tmp_path):
    found = found_of(tmp_path, small_study(["ideal-observer", "random"], (0.0, 0.4), 1, 4))
    headings = {part.name: part.heading for part in parts_of(found, "claims")}
    counts = [sum(map(int, re.findall(r"\((\d)\)", headings[f"claim-{i}"]))) for i, _ in enumerate(CLAIMS, 1)]
    assert counts == [n if (n := len(found.where("claim", of=claim.name))) > 1 else 0 for claim in CLAIMS]
    assert max(counts) == 2


def test_where_the_rules_were_broken_numbers_stay_and_no_claim_is_judged(clumsy):
    rows = clumsy.where("claim")
    assert clumsy.not_judged.startswith("No claim of the paper is judged: ")
    assert {(row.note, row.test) for row in rows} == {("not judged", clumsy.not_judged)}
    assert all(clumsy.said("claims", row.of) for row in rows)
    assert {row[6] for row in tables_of(clumsy)["claims"][1:]} == {"not judged", "not measured"}
    assert f"<dt>Not judged</dt><dd>{clumsy.not_judged}</dd>" in page_of("claims", clumsy)


def test_claims_that_could_not_be_tested_are_not_called_unmeasured(clumsy):
    lost = with_left_out(clumsy, [LeftOutSection("The paper's claims", "ValueError: no")])
    assert parts_of(lost, "claims") == []
    assert len(tables_of(lost)["claims"]) == 1

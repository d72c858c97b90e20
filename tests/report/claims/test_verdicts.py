"""The paper's claims: its figures recomputed from counts, and verdicts that follow from tests."""

from dataclasses import replace

import pytest
from builders import play_study, small_study
from known_truth import records

from lockprobe.foundation.seeds import generator
from lockprobe.report.claims.paper import CLAIMS, fisher_z
from lockprobe.report.claims.verdicts import claim_rows
from lockprobe.statistics.published import CORRELATION
from lockprobe.statistics.summary import summarise


def rows_of(world, seed=1):
    return by_measure(summarise([replace(trial, agent="llm:x") for trial in records(world, generator(seed))]))


def by_measure(summary):
    """Measure of a claim -> its verdict and P value, for an agent that speaks to it."""
    return {claim.measure: (verdict, p) for claim, _, (_, verdict, _, p) in claim_rows(summary)}


def test_the_papers_figures_follow_from_its_counts():
    said = {claim.measure: claim.recomputed for claim in CLAIMS}
    assert said["baseline"].startswith("7/30, 0.233 [0.118, 0.409]")
    assert said["peak"].startswith("20/30, 0.667 [0.488, 0.808]")
    assert said["ratio"].startswith("2.86 [1.50, 5.90]")
    assert "Fisher P = 0.0016, corrected for selection among six 0.0096" in said["effect"]
    assert said["loops-drop"] == "in points 24/30 to 16/30, Fisher P = 0.054; relative 23/30 to 17/30, P = 0.17"
    modalities = [claim.recomputed for claim in CLAIMS if claim.measure == "modalities"]
    assert modalities[0] == "8/10, 0.800 [0.490, 0.943]; Fisher against 10/10: P = 0.47"


def test_the_interval_of_the_papers_correlation():
    assert fisher_z(CORRELATION, 7) == pytest.approx((-0.95, 0.13), abs=0.005)
    assert fisher_z(CORRELATION, 21) == pytest.approx((-0.86, -0.37), abs=0.005)


def test_table_1_implies_more_steps_with_rgbd_than_with_ground_truth():
    (order,) = (claim.recomputed for claim in CLAIMS if claim.measure == "modality-order")
    assert "about 101 steps with RGB, 131 with RGB-D and 122 with ground truth" in order
    assert "35 in 122 steps are 28.7 %, the mean is 26.8 %" in order


def test_rows_of_a_table_are_no_quotations():
    assert [claim.place for claim in CLAIMS if not claim.quoted] == ["Table 1", "Table 1"]


def test_every_claim_is_there_in_the_order_of_the_paper():
    rows = claim_rows(summarise(play_study(small_study())))
    assert list(dict.fromkeys(claim for claim, *_ in rows)) == list(CLAIMS)
    assert {agent for claim, agent, _ in rows if claim.measure == "reference"} == {"human-inspired"}
    assert claim_rows(summarise([]))
    assert {verdict for _, _, (_, verdict, *_) in claim_rows(summarise([]))} == {"not measured"}


def test_an_agent_like_the_papers_looks_like_it_and_supports_nothing_on_loops():
    """Loops are irrelevant in this world, and yet its figures are those of Fig. 5. A few verdicts err by chance."""
    studies = [rows_of("loops-irrelevant", seed) for seed in range(3)]
    for measure in ("baseline", "peak", "ratio", "correlation"):
        assert sum(rows[measure][0] == "compatible" for rows in studies) >= 2, measure
    for measure in ("loops", "loops-drop"):  # a drop such as the paper's is often not shown by 30 trials
        assert sum(rows[measure][0] in ("compatible", "not decided") for rows in studies) >= 2, measure
        assert sum(rows[measure][0] == "compatible" for rows in studies) >= 1, measure
    assert sum(rows["effect"][0] == "borne out" for rows in studies) >= 2
    assert sum(rows["onset"][0] == "borne out" for rows in studies) <= 1


def test_a_trapped_agent_supports_them():
    rows = rows_of("loop-trapped")
    assert rows["onset"][0] == "borne out"
    assert rows["onset"][1] < 0.05
    assert rows["baseline"][0] == "not compatible"


def test_what_a_study_does_not_hold_is_not_measured():
    rows = by_measure(summarise(play_study(small_study(["human-inspired"]))))
    assert rows["modalities"][0] == "not measured"
    assert rows["peak"][0] == "not measured"  # no p of 0.4
    assert rows["reference-steps"][0] == "compatible"

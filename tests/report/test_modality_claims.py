"""The paper's claims about modalities: what measures them, and where nothing does."""

from dataclasses import replace

from lockprobe.analysis.summary import summarise
from lockprobe.report.claims import claim_rows


def test_the_opposite_order_is_not_borne_out(modal):
    turned = {"rgb": "symbolic", "symbolic": "rgb", "rgbd": "rgbd"}
    trials = [t if t.agent != "viewer" else replace(t, modality=turned[t.modality]) for t in modal]
    (row,) = [row for row in claim_rows(summarise(trials)) if row.claim.measure == "modality-order"]
    assert row.verdict == "not borne out"
    assert row.p_value < 0.05


def test_a_study_of_one_modality_says_nothing_of_modalities(modal):
    rows = claim_rows(summarise([trial for trial in modal if trial.modality == "symbolic"]))
    for row in rows:
        if row.claim.measure.startswith(("modalit", "reference-faster")) or row.claim.modality != "symbolic":
            assert row.verdict == "not measured"


def test_variants_of_one_modality_have_no_order_that_could_be_borne_out(modal):
    variants = {"rgb": "rgbd?depth=gray", "rgbd": "rgbd", "symbolic": "rgbd?depth=height"}
    trials = [replace(t, modality=variants[t.modality]) for t in modal if t.agent == "viewer"]
    rows = [row for row in claim_rows(summarise(trials)) if row.claim.measure == "modality-order"]
    assert [row.verdict for row in rows] == ["not measured"]

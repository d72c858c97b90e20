"""The paper's claims about modalities: what measures them, and where nothing does."""

from dataclasses import replace

from lockprobe.analysis.summary import summarise
from lockprobe.report.claims import claim_rows


def test_the_opposite_order_is_not_compatible(modal):
    turned = {"rgb": "symbolic", "symbolic": "rgb", "rgbd": "rgbd"}
    trials = [t if t.agent != "viewer" else replace(t, modality=turned[t.modality]) for t in modal]
    (row,) = [row for row in claim_rows(summarise(trials)) if row.claim.measure == "modality-order"]
    assert row.verdict == "not compatible"
    assert row.p_value < 0.05
    others = {row.claim.measure: row.verdict for row in claim_rows(summarise(trials))}
    assert others["modality-outpaces"] == others["modality-steps"] == "not compatible"


def test_rgbd_has_to_lie_in_between(modal):
    """The trend alone would bear the order out: RGB is fastest, RGB-D slowest, and ground truth just before it."""
    turned = {"rgb": "rgb", "rgbd": "symbolic", "symbolic": "rgbd"}
    trials = [t if t.agent != "viewer" else replace(t, modality=turned[t.modality]) for t in modal]
    rows = {row.claim.measure: row for row in claim_rows(summarise(trials))}
    assert rows["modality-order"].p_value < 0.05
    assert rows["modality-order"].verdict == "not compatible"
    assert rows["modality-outpaces"].verdict == "not compatible"


def test_two_modalities_do_not_decide_what_is_said_of_three(modal):
    trials = [t for t in modal if t.modality != "rgbd"]
    rows = {row.claim.measure: row.verdict for row in claim_rows(summarise(trials))}
    assert rows["modality-order"] == rows["reference-faster"] == "not decided"
    assert rows["modalities"] in ("not decided", "not compatible")
    assert rows["modality-outpaces"] == "not measured"


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

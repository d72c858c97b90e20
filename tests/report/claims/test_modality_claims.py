"""The paper's claims about modalities: what measures them, and where nothing does."""

from dataclasses import replace

from lockprobe.report.claims.verdicts import claim_rows
from lockprobe.statistics.summary import summarise


def by_measure(trials):
    """Measure of a claim -> its verdict and P value, for an agent that speaks to it."""
    return {claim.measure: (verdict, p) for claim, _, (_, verdict, _, p) in claim_rows(summarise(trials))}


def test_the_opposite_order_is_not_compatible(modal):
    turned = {"rgb": "symbolic", "symbolic": "rgb", "rgbd": "rgbd"}
    trials = [t if t.agent != "viewer" else replace(t, modality=turned[t.modality]) for t in modal]
    rows = by_measure(trials)
    assert rows["modality-order"][0] == "not compatible"
    assert rows["modality-order"][1] < 0.05
    assert rows["modality-outpaces"][0] == rows["modality-steps"][0] == "not compatible"


def test_rgbd_has_to_lie_in_between(modal):
    """The trend alone would bear the order out: RGB is fastest, RGB-D slowest, and ground truth just before it."""
    turned = {"rgb": "rgb", "rgbd": "symbolic", "symbolic": "rgbd"}
    trials = [t if t.agent != "viewer" else replace(t, modality=turned[t.modality]) for t in modal]
    rows = by_measure(trials)
    assert rows["modality-order"][1] < 0.05
    assert rows["modality-order"][0] == "not compatible"
    assert rows["modality-outpaces"][0] == "not compatible"


def test_depth_worsens_if_rgb_is_faster_and_not_if_rgbd_is(modal):
    turned = {"rgb": "rgbd", "rgbd": "rgb", "symbolic": "symbolic"}
    other = [t if t.agent != "viewer" else replace(t, modality=turned[t.modality]) for t in modal]
    assert by_measure(modal)["depth"][0] == "borne out"
    assert by_measure(other)["depth"][0] == "not compatible"


def test_two_modalities_do_not_decide_what_is_said_of_three(modal):
    trials = [t for t in modal if t.modality != "rgbd"]
    rows = by_measure(trials)
    assert rows["modality-order"][0] == rows["reference-faster"][0] == "not decided"
    assert rows["modalities"][0] in ("not decided", "not compatible")
    assert rows["modality-outpaces"][0] == "not measured"


def test_a_study_of_one_modality_says_nothing_of_modalities(modal):
    rows = claim_rows(summarise([trial for trial in modal if trial.modality == "symbolic"]))
    for claim, _, (_, verdict, *_) in rows:
        if claim.measure.startswith(("modalit", "reference-faster")) or claim.modality != "symbolic":
            assert verdict == "not measured"


def test_variants_of_one_modality_have_no_order_that_could_be_borne_out(modal):
    variants = {"rgb": "rgbd?depth=gray", "rgbd": "rgbd", "symbolic": "rgbd?depth=height"}
    trials = [replace(t, modality=variants[t.modality]) for t in modal if t.agent == "viewer"]
    rows = [found for claim, _, found in claim_rows(summarise(trials)) if claim.measure == "modality-order"]
    assert [verdict for _, verdict, *_ in rows] == ["not measured"]

"""Optimal actions: every condition, and boxes that cannot be judged."""

from dataclasses import replace

from builders import small_study, write_study

from lockprobe.boxes.families import box
from lockprobe.report.page import page_of, tables_of
from lockprobe.report.results import results

CONTRADICTED = "On this box true reports contradict this prior"


def found_in(directory, planned):
    return results(write_study(directory, planned))


def part_of(found):
    return page_of(found).partition('id="optimal_actions"')[2].partition('<details class="section"')[0]


def test_every_condition_is_judged(tmp_path):
    found = found_in(tmp_path / "study", small_study())
    assert len(found.where("optimal_actions")) == len(found.cells)
    for row in found.where("optimal_actions"):
        assert row.low <= row.value <= row.high
        assert row.clusters == 8
    assert len(tables_of(found)["optimal-actions"]) == 5  # a blind agent once, the other at every p
    part = part_of(found)
    assert "every joint is free or needs one other joint open" in part
    assert CONTRADICTED not in part


def test_a_prior_that_true_reports_contradict_is_said_to_be_wrong(tmp_path):
    """A target that needs two joints open is in none of the priors."""
    both = {"revolute-left": ({"slider-1": True, "slider-2": True},)}
    study = replace(small_study(["random"], (0.0,), 1, 6), box=replace(box("chain-4"), name="both", interlock=both))
    assert CONTRADICTED in part_of(found_in(tmp_path / "both", study))


def test_boxes_too_large_for_a_prior_are_not_judged(tmp_path):
    study = replace(small_study(["random"], (0.0,), 1, 3), box=box("chain-7"))
    found = found_in(tmp_path / "study", study)
    assert found.where("optimal_actions") == []
    assert not part_of(found)

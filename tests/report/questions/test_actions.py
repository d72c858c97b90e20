"""Optimal actions: every condition, and boxes that cannot be judged."""

from dataclasses import replace

from builders import small_study
from page_parts import part
from reported import found_in

from lockprobe.boxes.families import box
from lockprobe.report.page import Page, tables_of

CONTRADICTED = "On this box true reports contradict this prior"


def test_every_condition_is_judged(tmp_path):
    found = found_in(tmp_path, small_study())
    rows = found.where("optimal_actions")
    assert len(rows) == len(found.cells)
    assert {row.clusters for row in rows} == {8}
    head, *shares = tables_of(found)["conditions"]
    assert len(shares) == 4  # a blind agent once, the other at every p
    assert all(row[head.index("optimal")].endswith(" %") for row in shares)
    shown = part(Page(found=found).text(), "optimal_actions")
    assert "every joint is free or needs one other joint open" in shown
    assert CONTRADICTED not in shown


def test_a_prior_that_true_reports_contradict_is_said_to_be_wrong(tmp_path):
    """A target that needs two joints open is in none of the priors."""
    both = {"revolute-left": ({"slider-1": True, "slider-2": True},)}
    planned = replace(
        small_study(["random"], (0.0,), 1, 6), boxes=(replace(box("chain-4"), name="both", interlock=both),)
    )
    assert CONTRADICTED in part(Page(found=found_in(tmp_path, planned)).text(), "optimal_actions")


def test_boxes_too_large_for_a_prior_are_not_judged(tmp_path):
    found = found_in(tmp_path, replace(small_study(["random"], (0.0,), 1, 3), boxes=(box("chain-7"),)))
    assert found.where("optimal_actions") == []
    assert not part(Page(found=found).text(), "optimal_actions")

"""What a report says of the panel of a study with pictures."""

import numpy as np
import pytest

from lockprobe.boxes.families import box
from lockprobe.boxes.layouts import laid_out, locking_pairs, neighbours, redealt
from lockprobe.report.prose.panel import panel_said


def test_one_panel_in_the_order_of_the_lock():
    assert panel_said(box("chain-4"), dealt=False, listed_anew=True) == (
        "The panel was the same in every trial: of the pairs of joints that lock each other, 3 of 3 sit side by side on "
        "it (1.5 on average in a random arrangement). Pictures show this order, and words list the joints in a random "
        "order. So a difference between pictures and words can come from the panel; --layout shuffled randomises it in "
        "every trial."
    )


def test_one_panel_against_the_order_of_the_lock():
    far = laid_out(box("chain-6"), "misleading", np.random.default_rng(1))
    assert ", 0 of 5 sit side by side on it (1.7 on" in panel_said(far, dealt=False, listed_anew=True)


def test_words_in_the_order_of_the_panel():
    said = panel_said(box("chain-4"), dealt=False, listed_anew=False)
    assert said.endswith("Pictures show this order, and words list the joints in the same order.")
    assert "can come from the panel" not in said


def test_dealt_panels():
    said = panel_said(box("chain-4"), dealt=True, listed_anew=True)
    assert said.startswith("In every trial the joints were assigned to positions on the panel at random")
    assert said.endswith("So the position of a joint says nothing about the interlock.")
    assert said == panel_said(box("reset"), dealt=True, listed_anew=False)


def test_the_average_over_deals_is_that_of_deals():
    dealt = [redealt(box("chain-4"), np.random.default_rng(seed)) for seed in range(2000)]
    beside = [len(locking_pairs(drawn) & neighbours(drawn)) for drawn in dealt]
    assert np.mean(beside) == pytest.approx(1.5, abs=0.08)  # standard error 0.016


def test_a_rigid_panel_is_not_to_be_shuffled():
    said = panel_said(box("chain-4"), dealt=False, listed_anew=True, rigid=True)
    assert "shuffled" not in said
    assert "can come from the panel" in said

"""Sentences on forks say what was detected, and never that there is no effect."""

import pytest

from lockprobe.report.prose.branch import branch_said, found_said, place_said, size_said, value_said
from lockprobe.statistics.agent_comparison.paired import BlockMean
from lockprobe.statistics.branch import BranchEffect


def effect(value=0.1, low=0.02, high=0.18, p_value=0.01, **others):
    change = BlockMean(value=value, low=low, high=high, p_value=p_value, pairs=300, blocks=150)
    about = {
        "agent": "random",
        "condition": "truth",
        "where": "8",
        "arm": "lie",
        "truthful": False,
        "outcome": "solved",
    }
    return BranchEffect(**(about | others), after_truth=0.4, change=change, forks=300)


def test_an_effect_is_said_with_its_interval_and_its_size():
    assert branch_said(effect()) == (
        "At the report of step 8, one inverted report raises the success of random (truth): 40 % after a true report, "
        "+10 points, 95 % interval +2 to +18; P = 0.01, 150 trials, 300 forks."
    )
    assert "later reports are true" in branch_said(effect(truthful=True))
    assert "lowers" in branch_said(effect(-0.1, -0.18, -0.02))
    assert "+18; P = 0.01 (corrected for 3 agents), 150 trials" in branch_said(effect(agents=3))


@pytest.mark.parametrize("open_", [effect(p_value=0.2), effect(low=-0.01), effect(p_value=None)])
def test_what_is_not_shown_is_not_said_to_be_nothing(open_):
    assert branch_said(open_).startswith(
        "No effect of one inverted report at the report of step 8 on the success of random"
    )
    assert " was detected: 40 % after" in branch_said(open_)
    assert found_said([open_, open_]) == [
        "No effect on success was detected after correction for the number of effects."
    ]
    assert found_said([open_]) == [branch_said(open_)]


def test_of_several_the_detectable_ones_are_said():
    assert found_said([effect(), effect(p_value=0.5)]) == [branch_said(effect())]
    assert found_said([]) == []


def test_every_arm_and_place_has_words():
    for arm in ("lie", "lie-truth", "truth-truth", "remark", "withheld", "tremble", "random", "force=slider-1"):
        assert f", {arm} raises" not in branch_said(effect(arm=arm))
    assert "a next attempt at joint slider-1 raises" in branch_said(effect(arm="force=slider-1"))
    assert [place_said(where) for where in ("4", "onset")] == [
        "the report of step 4",
        "the report that completes its first loop",
    ]


def test_sizes_have_their_units():
    assert size_said(effect()) == "+10, 95 % interval +2 to +18"
    assert [value_said(name, -0.25) for name in ("solved", "steps", "choice")] == [
        "\N{MINUS SIGN}25",
        "\N{MINUS SIGN}0.2",
        "-0.25",
    ]

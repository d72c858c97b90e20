"""Attempts against the rules of a box are found from the record, whatever the plant was."""

from dataclasses import replace

from clumsy import HAND

from lockprobe.boxes.families import box
from lockprobe.report.prose import rules_broken_said
from lockprobe.statistics.rules import Rules, unbroken
from lockprobe.testing import make_trial

CHAIN = box("chain-4")


def test_each_way_to_break_them_is_found():
    trial = make_trial([3, 3, 0, 2, 1, 3], plant=f"{HAND}?misses=1&forces=3&knocks=4")
    found = Rules(CHAIN).judged(trial)  # the forced one was the target: it is solved
    assert found[0] == (True, False, False)
    assert [(one.free, one.moved) for one in found if one.against] == [(True, False), (False, True)]
    knocked = make_trial([3, 2, 3], plant=f"{HAND}?knocks=1")
    assert [one.other for one in Rules(CHAIN).judged(knocked)] == [True, False, False]
    assert rules_broken_said(*Rules(CHAIN).broken((trial, knocked))) == "3 of 6 attempts broke the rules of the box."
    late = make_trial([3, 2, 3, 0], plant=f"{HAND}?misses=2")
    assert [unbroken(one, Rules(CHAIN).judged(one)) for one in (trial, late, make_trial([3, 2, 3, 0]))] == [0, 1, 4]


def test_broken_trials_count_and_other_boxes_do_not():
    broken = make_trial([3], plant=f"{HAND}?misses=1", broken=True)
    assert broken.ending == "error"
    assert rules_broken_said(*Rules(CHAIN).broken((broken,))) == "1 of 1 attempts broke the rules of the box."
    for other in (replace(broken, joints=tuple("abcd")),):
        assert Rules(CHAIN).judged(other) == []
        assert unbroken(other, []) == len(other.steps)
    assert rules_broken_said(*Rules(box("chain-5")).broken((broken,))) == ""

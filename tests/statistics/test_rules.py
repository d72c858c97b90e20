"""Attempts against the rules of a box are counted from the record, whatever the plant was."""

from dataclasses import replace

from clumsy import HAND

from lockprobe.boxes.families import box
from lockprobe.statistics.clustered import clustered_proportion
from lockprobe.statistics.conditions.condition import condition_summary
from lockprobe.statistics.rules import against_rules, break_shares, rule_breaks, unbroken
from lockprobe.testing import make_trial, play_trials

CHAIN = box("chain-4")


def test_the_rules_break_no_rules():
    for agent in ("random", "human-inspired"):
        found = rule_breaks(play_trials(agent, 5, box="gray-code"), box("gray-code"))
        assert found.attempts > 20
        assert 0 < found.free < found.attempts
        assert (found.against, found.missed, found.forced, found.others) == (0, 0, 0, 0)


def test_each_way_to_break_them_is_counted():
    trial = make_trial([3, 3, 0, 2, 1, 3], plant=f"{HAND}?misses=1&forces=3&knocks=4")
    assert [(one.free, one.moved, one.other) for one in against_rules(trial, CHAIN)][:1] == [(True, False, False)]
    found = rule_breaks([trial], CHAIN)
    assert (found.attempts, found.missed, found.forced) == (3, 1, 1)  # the forced one was the target: it is solved
    knocked = rule_breaks([make_trial([3, 2, 3], plant=f"{HAND}?knocks=1")], CHAIN)
    assert (knocked.attempts, knocked.against, knocked.others) == (3, 1, 1)


def test_a_miss_is_one_wherever_joints_stand_on_the_panel():
    trials = play_trials("round-robin", 6, plant=f"{HAND}?misses=1;2;3;4;5;6;7;8", layout="shuffled")
    assert len({trial.joints for trial in trials}) > 1
    found = rule_breaks(trials, CHAIN)
    free = sum(
        CHAIN.may_move(
            tuple(step.state[trial.joints.index(name)] == "1" for name in CHAIN.names), CHAIN.names.index(step.joint)
        )
        for trial in trials
        for step in trial.steps[:8]
    )
    assert found.missed == found.against == free > 0


def test_broken_trials_count_and_other_boxes_do_not():
    broken = make_trial([3], plant=f"{HAND}?misses=1", broken=True)
    assert broken.ending == "error"
    assert rule_breaks([broken], CHAIN).against == 1
    assert rule_breaks([broken], box("chain-5")) is None
    assert rule_breaks([], CHAIN).attempts == 0


def test_each_condition_has_its_own_count():
    kept, missed = (play_trials("round-robin", 3, plant=f"{HAND}{options}") for options in ("", "?misses=1;2;3;4"))
    assert [condition_summary(one, None, CHAIN).rules.against > 0 for one in (kept, missed)] == [False, True]
    assert condition_summary(kept, None).rules is None
    assert against_rules(replace(kept[0], joints=tuple("abcd")), CHAIN) == []


def test_shares_are_of_free_and_of_locked_joints_with_trials_as_clusters():
    trials = play_trials("round-robin", 6, plant=f"{HAND}?misses=1;2;3;4&forces=6&knocks=7")
    judged = [against_rules(trial, CHAIN) for trial in trials]
    free = [[one for one in of if one.free] for of in judged]
    locked = [[one for one in of if not one.free] for of in judged]
    found = break_shares(trials, CHAIN)
    assert found.missed == clustered_proportion([sum(not one.moved for one in of) for of in free], list(map(len, free)))
    assert found.forced == clustered_proportion([sum(one.moved for one in of) for of in locked], list(map(len, locked)))
    assert found.others == clustered_proportion([sum(one.other for one in of) for of in judged], list(map(len, judged)))
    assert min(found.missed.count, found.forced.count, found.others.count) > 0
    assert found.missed.design_effect >= 1


def test_attempts_before_the_first_broken_rule_are_unbroken():
    trial = make_trial([3, 2, 3, 0], plant=f"{HAND}?misses=2")
    assert unbroken(trial, CHAIN) == 1
    kept = make_trial([3, 2, 3, 0])
    assert unbroken(kept, CHAIN) == len(kept.steps)

"""Attempts against the rules of a box are counted from the record, whatever the plant was."""

from dataclasses import replace

from lockprobe.boxes.families import box
from lockprobe.statistics.conditions.condition import condition_summary
from lockprobe.statistics.rules import RuleBreaks, against_rules, rule_breaks, together
from lockprobe.testing import make_trial, play_trials
from lockprobe.trial.record import Snapshot

CHAIN = box("chain-4")


class Hand:
    """The rules of chain-4, except at some attempts, from 1: ``misses`` move nothing, ``forces`` move the joint.

    At ``knocks`` the joint to the left moves too.
    """

    facts: dict[str, str] = {}  # noqa: RUF012

    def __init__(
        self,
        *,
        box,
        labels,
        rng,
        misses: tuple[int, ...] = (),
        forces: tuple[int, ...] = (),
        knocks: tuple[int, ...] = (),
    ):
        self._box, self._now, self._count = box, box.initial, 0
        self._misses, self._forces, self._knocks = misses, forces, knocks

    def observe(self):
        return Snapshot(configuration=self._now)

    def attempt(self, joint):
        self._count += 1
        moves = self._box.may_move(self._now, joint)
        moves = (moves and self._count not in self._misses) or self._count in self._forces
        toggled = {joint} if moves else set()
        toggled |= {joint - 1} if self._count in self._knocks else set()
        self._now = tuple(now ^ (i in toggled) for i, now in enumerate(self._now))
        return Snapshot(configuration=self._now, joint=joint, outcome="moved" if moves else "blocked")

    def close(self):
        pass


HAND = f"python:{__name__}:Hand"


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


def test_counts_add_up_and_unknown_ones_are_left_out():
    one = RuleBreaks(attempts=3, against=2, free=2, missed=1, forced=1, others=0)
    assert together([one, None, one]) == RuleBreaks(attempts=6, against=4, free=4, missed=2, forced=2, others=0)
    assert together([None]) is None


def test_each_condition_has_its_own_count():
    kept, missed = (play_trials("round-robin", 3, plant=f"{HAND}{options}") for options in ("", "?misses=1;2;3;4"))
    assert [condition_summary(one, None, CHAIN).rules.against > 0 for one in (kept, missed)] == [False, True]
    assert condition_summary(kept, None).rules is None
    assert against_rules(replace(kept[0], joints=tuple("abcd")), CHAIN) == []

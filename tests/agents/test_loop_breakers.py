"""Loop breakers go round until a report frees them, each for its own reason."""

import pytest

from lockprobe.agents.loop_breakers import AnyFalsehood, FormByLength, LoopBreaker, Novelty, Sceptic
from lockprobe.agents.policy import Told, View
from lockprobe.foundation.errors import BadValue

VIEW = View(joints=4, target=0)
FALSE = Told(joint=1, moved=True)
TRUE = Told(joint=1, moved=False)


def two(first, last):
    """A report in two statements."""
    return Told(joint=1, moved=last.moved, corrects=first)


REPORTS = {
    "lie": FALSE,
    "TT": two(TRUE, TRUE),
    "FT": two(FALSE, TRUE),
    "TF": two(TRUE, FALSE),
    "FF": two(FALSE, FALSE),
    "remark": Told(joint=1, moved=False, remarked=True),
    "again": TRUE,
}


def going_round(policy):
    """A memory in which joint 1 was blocked, and comes next."""
    memory = policy.begin(VIEW)
    for joint in (1, 2, 3):
        memory = policy.remember(VIEW, memory, Told(joint=joint, moved=False))
    assert policy.probabilities(VIEW, memory) == (0, 1, 0, 0)
    return memory


@pytest.mark.parametrize(
    ("policy", "frees"),
    [
        (LoopBreaker(), {"lie": 3, "TT": 3, "FT": 3, "TF": 3, "FF": 3, "remark": 3, "again": 0}),
        (FormByLength(), {"lie": 3, "TT": 6, "FT": 6, "TF": 6, "FF": 6, "remark": 3, "again": 0}),
        (Sceptic(), {"lie": 3, "TT": 3, "FT": 0, "TF": 0, "FF": 3, "remark": 3, "again": 0}),
        (AnyFalsehood(), {"lie": 3, "TT": 0, "FT": 3, "TF": 3, "FF": 3, "remark": 0, "again": 0}),
        (Novelty(), {"lie": 3, "TT": 3, "FT": 3, "TF": 3, "FF": 3, "remark": 3, "again": 0}),
    ],
)
def test_what_frees_and_for_how_long(policy, frees):
    memory = going_round(policy)
    assert {name: policy.remember(VIEW, memory, told).free for name, told in REPORTS.items()} == frees


def test_once_free_it_has_forgotten_and_draws_a_new_cycle():
    policy = LoopBreaker()
    memory = policy.remember(VIEW, going_round(policy), FALSE)
    for joint in (0, 1, 2):
        assert policy.probabilities(VIEW, memory)[memory.last] == 0
        memory = policy.remember(VIEW, memory, Told(joint=joint, moved=joint == 1))
    assert memory == policy.begin(VIEW)


def test_novelty_frees_once_in_a_trial():
    policy = Novelty()
    memory = policy.remember(VIEW, policy.begin(VIEW), REPORTS["TT"])
    assert (memory.free, memory.freed) == (3, True)
    for joint in (0, 2, 3, 1, 2, 3):
        memory = policy.remember(VIEW, memory, Told(joint=joint, moved=False))
    assert all(policy.remember(VIEW, memory, told).free == 0 for told in REPORTS.values())


def test_a_box_is_large_enough_for_a_cycle():
    with pytest.raises(BadValue, match="at least 3 joints"):
        LoopBreaker().begin(View(joints=2, target=0))

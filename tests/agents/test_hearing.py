"""What is heard of a report in two statements."""

import pytest

from lockprobe.agents.cognitive import SoftmaxMemory
from lockprobe.agents.hearing import Hears, Jolted
from lockprobe.agents.policy import Told, View
from lockprobe.foundation.errors import BadValue

VIEW = View(joints=3, target=0)
POLICY = SoftmaxMemory(failure=2, stay=1, closed=0.5)
LIE, TRUTH = Told(joint=1, moved=True, shifted=2), Told(joint=1, moved=False, shifted=0)


def two(first, last):
    """A report in two statements."""
    return Told(joint=1, moved=last.moved, shifted=last.shifted, corrects=first)


@pytest.mark.parametrize(
    ("believes", "mixed", "alike"),
    [("first", LIE, TRUTH), ("last", TRUTH, TRUTH), ("agreed", None, TRUTH), ("neither", None, None)],
)
def test_one_statement_is_believed_or_none(believes, mixed, alike):
    agent = Hears(policy=POLICY, believes=believes)
    start = agent.begin(VIEW)

    def after(heard):
        return start if heard is None else POLICY.remember(VIEW, start, heard)

    assert agent.remember(VIEW, start, two(LIE, TRUTH)) == after(mixed)
    assert agent.remember(VIEW, start, two(TRUTH, TRUTH)) == after(alike)
    assert agent.remember(VIEW, start, LIE) == after(LIE)
    assert agent.probabilities(VIEW, after(LIE)) == POLICY.probabilities(VIEW, after(LIE))


def test_statements_that_differ_in_positions_alone_do_not_agree():
    agent = Hears(policy=POLICY, believes="agreed")
    elsewhere = Told(joint=1, moved=True, shifted=6)
    assert agent.remember(VIEW, agent.begin(VIEW), two(elsewhere, LIE)) == agent.begin(VIEW)


def test_a_correction_jolts_for_three_steps_and_a_remark_does_not():
    agent = Jolted(policy=POLICY)
    known = agent.remember(VIEW, agent.begin(VIEW), TRUTH)
    remarked = Told(joint=2, moved=False, shifted=0, remarked=True)
    assert agent.remember(VIEW, known, remarked).kept == POLICY.remember(VIEW, known.kept, remarked)
    for first, last in ((LIE, TRUTH), (TRUTH, TRUTH)):
        memory = agent.remember(VIEW, known, two(first, last))
        assert memory.kept == POLICY.begin(VIEW)
        for _ in range(3):
            assert agent.probabilities(VIEW, memory) == pytest.approx((1 / 3,) * 3)
            memory = agent.remember_silence(VIEW, memory, 0)
        assert agent.probabilities(VIEW, memory) == POLICY.probabilities(VIEW, POLICY.begin(VIEW))


def test_mistakes_are_named():
    with pytest.raises(BadValue, match="believes"):
        Hears(policy=POLICY, believes="both")

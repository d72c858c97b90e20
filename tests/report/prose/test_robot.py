"""A robot that breaks the rules of the box is said to, and no claim of the paper is judged by that."""

from lockprobe.report.prose.robot import broken_said, not_judged
from lockprobe.statistics.rules import RuleBreaks

BROKEN = RuleBreaks(attempts=60, against=12, free=30, missed=11, forced=1, others=0)
KEPT = RuleBreaks(attempts=60, against=0, free=30, missed=0, forced=0, others=0)


def test_no_claim_is_judged_where_there_are_any():
    assert broken_said(BROKEN) == "12 of 60 attempts broke the rules of the box."
    assert not_judged(BROKEN) == "No claim of the paper is judged: 12 of 60 attempts broke the rules of the box."
    assert {not_judged(one) or broken_said(one) for one in (KEPT, None)} == {""}

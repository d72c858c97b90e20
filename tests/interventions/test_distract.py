"""A sentence about something else, at moments that are drawn."""

import re

import pytest
from scipy.stats import binomtest

from lockprobe.interventions.distract import ASIDES
from lockprobe.studies.running.single import run_trial


def said(p, **settings):
    return [
        step.remark
        for step in run_trial(agent="round-robin", box="chain-7", condition=f"distract?p={p}", **settings).steps
    ]


def test_a_sentence_stands_beside_every_report_at_1_and_beside_none_at_0():
    first, *others = said(1)
    assert first == ""
    assert set(others) <= set(ASIDES)
    assert len(set(others)) > 2
    assert set(said(0)) == {""}


def test_what_is_said_at_a_smaller_p_is_said_at_a_larger_one():
    few, many = said(0.3), said(0.7)
    assert all(a in ("", b) for a, b in zip(few, many, strict=True))
    assert few != many


def test_its_rate_is_p():
    steps = [remark for trial in range(1, 101) for remark in said(0.3, trial=trial)[1:]]
    assert binomtest(sum(map(bool, steps)), len(steps), 0.3).pvalue > 0.001


@pytest.mark.parametrize("agent", ["human-inspired", "ideal-observer"])
def test_the_report_stays_as_it_is(agent):
    plain, distracted = (run_trial(agent=agent, p=0.3, condition=c) for c in ("", "distract?p=1"))
    assert [(step.told, step.decision) for step in plain.steps] == [(s.told, s.decision) for s in distracted.steps]


@pytest.mark.parametrize("aside", ASIDES)
def test_no_sentence_speaks_of_what_moved_or_names_a_joint(aside):
    assert not re.search(r"mov|lock|block|position|attempt|false|true|loop|repeat|\b[A-H]\b", aside)

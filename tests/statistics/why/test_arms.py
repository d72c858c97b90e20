"""The arms of a study of controls are known by what acts, whatever conditions are called."""

from dataclasses import replace

import pytest
from why_answers import as_arms

from lockprobe.statistics.why.arms import ARMS, ON_REQUEST, PARTS, PLANNED, arms_of


@pytest.mark.parametrize("reading", ["", "&others=kept", "&inverts=position", "&inverts=position&others=kept"])
@pytest.mark.parametrize("p", [0.4, 1.0, 0.05])
def test_arms_are_known_by_what_acts_whatever_they_are_called(p, reading):
    renamed = [replace(one, label=f"condition {i}") for i, one in enumerate(as_arms(ARMS, p, reading))]
    assert arms_of(renamed[::-1]) == (p, {arm: f"condition {i}" for i, arm in enumerate(ARMS)})


@pytest.mark.parametrize("missing", PLANNED)
def test_without_a_planned_arm_there_is_no_answer(missing):
    assert arms_of(as_arms([arm for arm in ARMS if arm != missing])) is None


def test_the_remark_and_other_arms_may_be_missing_or_there():
    assert arms_of(as_arms(PLANNED)) == (0.4, {arm: arm for arm in PLANNED})
    every = [*ARMS, *PARTS, *ON_REQUEST]
    assert arms_of(as_arms(every)) == (0.4, {arm: arm for arm in every})


def test_arms_of_another_rate_or_another_kind_of_false_report_are_no_arms():
    rest = [arm for arm in ARMS if arm != "truth-lie"]
    assert arms_of([*as_arms(rest), *as_arms(["truth-lie"], 0.2)]) is None
    assert arms_of([*as_arms(rest), *as_arms(["truth-lie"], 0.4, "&others=kept")]) is None
    assert arms_of(as_arms(["lie in loops", *(arm for arm in ARMS if arm != "lie")])) is None

"""Agents compared under each condition: by hand, in families that nothing else changes, and never twice."""

from dataclasses import replace
from math import comb

import pytest
from builders import SOLUTION, make_trial

from lockprobe.foundation.spec import Spec
from lockprobe.statistics.conditions.agents_by_condition import agents_by_condition
from lockprobe.statistics.conditions.design import Design
from lockprobe.statistics.conditions.series import SeriesArm
from lockprobe.trial.record import STATES

FAILED = (0,) * 20
N = 12


def arm(label):
    """A condition by its interventions."""
    specs = () if label == "truth" else (Spec.parse(label),)
    return SeriesArm(label=label, specs=specs, doses=tuple(("p",) if "?p" in label else ("after",) for _ in specs))


def cells(**solved):
    """The trials of agents under conditions: of each the number that it solves, the first ones."""
    found = {}
    for agent, by_label in solved.items():
        for label, count in by_label.items():
            made = [make_trial(SOLUTION if i < count else FAILED, agent=agent, trial=i + 1) for i in range(N)]
            found[agent, label] = [replace(one, condition=label) for one in made]
    return found


def compared(played, *labels):
    agents = tuple(dict.fromkeys(agent for agent, _ in played))
    arms = tuple(map(arm, labels or dict.fromkeys(label for _, label in played)))
    return agents_by_condition(played, Design(agents=agents, arms=arms, axis=frozenset({"truth"})))


def test_a_difference_under_a_condition_is_that_of_its_trials_alone():
    (one,) = compared(cells(viewer={"truth": 12, "nudge": 3}, learner={"truth": 0, "nudge": 9}))
    assert (one.condition, one.control, one.axis) == ("nudge", "truth", "")
    assert (one.pair.second, one.pair.first) == (("viewer", STATES), ("learner", STATES))
    assert one.at.success.value == pytest.approx((3 - 9) / N)
    assert (one.at.success.only_second, one.at.success.only_first) == (0, 6)
    assert one.at.p_adjusted == pytest.approx(2 / 2**6)  # McNemar: six of six
    assert one.change.at[0].change.value == pytest.approx((3 - 12) / N - 9 / N)


def test_p_values_are_corrected_for_all_pairs_and_conditions_of_a_family():
    counts = {"viewer": (12, 1, 2), "learner": (12, 9, 4), "cognitive:careful": (12, 12, 8)}
    labels = ("truth", "nudge", "warn")
    found = compared(cells(**{agent: dict(zip(labels, of, strict=True)) for agent, of in counts.items()}))
    assert [(one.tests, one.changes) for one in found] == [(6, 6)] * 6
    raw = sorted(one.at.success.p_value for one in found)
    least = min(found, key=lambda one: one.at.success.p_value)
    assert least.at.success.p_value == pytest.approx(2 * comb(11, 0) / 2**11)
    assert least.at.p_adjusted == pytest.approx(6 * raw[0])
    assert all(one.at.p_adjusted >= one.at.success.p_value for one in found)


def test_the_doses_of_an_axis_are_a_family_of_their_own():
    """So a condition beside them changes no P value of theirs."""
    doses = ("truth", "tremble?p=0.1", "tremble?p=0.3")
    counts = {"viewer": (12, 6, 2), "learner": (12, 11, 9)}
    alone = {agent: dict(zip(doses, of, strict=True)) for agent, of in counts.items()}
    beside = {agent: {**of, "nudge": 3 + 2 * i} for i, (agent, of) in enumerate(alone.items())}
    before, now = compared(cells(**alone)), compared(cells(**beside))
    assert [one for one in now if one.axis] == list(before)
    assert [one.condition for one in now if not one.axis] == ["nudge"]


def test_agents_that_a_condition_changes_nothing_of_are_compared_under_its_control_alone():
    alike = {"truth": 8, "nudge": 8}
    assert compared(cells(viewer=alike, learner={"truth": 5, "nudge": 5})) == ()
    assert len(compared(cells(viewer=alike, learner={"truth": 5, "nudge": 6}))) == 1


def test_a_baseline_is_compared_with_each_agent_and_has_no_change():
    counts = {"truth": 12, "nudge": 3}
    found = compared(cells(viewer=counts, learner={"truth": 6, "nudge": 9}, random={"truth": 2, "nudge": 4}))
    assert [(one.pair.second[0], one.pair.first[0], one.change is None) for one in found] == [
        ("viewer", "learner", False), ("viewer", "random", True), ("learner", "random", True),
    ]  # fmt: skip
    assert [one.tests for one in found] == [1, 2, 2]

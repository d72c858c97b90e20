"""Why false reports change success: arms by what acts, outcomes as recorded, and mechanisms that are known."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from builders import play_study
from solved import columns

from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.spec import Spec
from lockprobe.interventions.conditions import read_condition
from lockprobe.statistics.design import ARMS, PLANNED, SeriesArm, arms_of
from lockprobe.statistics.outcomes import outcomes
from lockprobe.statistics.why import decide, whys
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.study import design_of

AGENT, BLOCKS = "cognitive:perseverant", 40


def as_arms(arms=ARMS, p=0.4, reading=""):
    """These arms at a rate, as an analysis sees them."""
    found = [read_condition(ARMS[arm].format(p=p, reading=reading), arm) for arm in arms]
    return [
        SeriesArm(
            label=one.label,
            specs=tuple(map(Spec.parse, one.specs)),
            doses=tuple(names for _, names in one.acting),
            modality=one.modality,
        )
        for one in found
    ]


@pytest.mark.parametrize("reading", ["", "&others=kept", "&inverts=position", "&inverts=position&others=kept"])
@pytest.mark.parametrize("p", [0.4, 1.0, 0.05])
def test_arms_are_known_by_what_acts_whatever_they_are_called(p, reading):
    renamed = [replace(one, label=f"condition {i}") for i, one in enumerate(as_arms(ARMS, p, reading))]
    assert arms_of(renamed[::-1]) == (p, {arm: f"condition {i}" for i, arm in enumerate(ARMS)})


def test_other_arms_may_be_missing_or_there_and_planned_ones_may_not():
    assert arms_of(as_arms(PLANNED)) == (0.4, {arm: arm for arm in PLANNED})
    for missing in PLANNED:
        assert arms_of(as_arms([arm for arm in ARMS if arm != missing])) is None
    rest = [arm for arm in ARMS if arm != "truth-lie"]
    assert arms_of([*as_arms(rest), *as_arms(["truth-lie"], 0.2)]) is None
    assert arms_of([*as_arms(rest), *as_arms(["truth-lie"], 0.4, "&others=kept")]) is None


def whys_of(trials, *agents):
    """What the agents of these trials show."""
    cells = {
        name: SimpleNamespace(trials=own, outcomes=outcomes(own))
        for name, own in grouped(trials, lambda trial: (trial.group, trial.condition)).items()
    }
    return tuple(whys(cells, design_of(study("why", agent=list(agents), trials=BLOCKS))))


def played(*agents, trials=BLOCKS, **more):
    return play_study(study("why", agent=list(agents), trials=trials, repetitions=1, **more))


def as_groups(solved):
    return {arm: columns(own, np.arange(len(own)) + 1, solved=own > 0) for arm, own in solved.items()}


@pytest.fixture(scope="module")
def trials():
    return played(AGENT)


@pytest.fixture(scope="module")
def solved(trials):
    return {arm: np.array([one.solved for one in trials if one.condition == arm], float) for arm in ARMS}


def test_the_decision_is_that_of_the_outcomes_in_any_order(trials, solved):
    (found,), (again,) = whys_of(trials, AGENT), whys_of(trials[::-1], AGENT)
    assert (found.agent, found.p, found.conditions) == (AGENT, 0.4, {arm: arm for arm in ARMS})
    assert found.decision == again.decision == decide(as_groups(solved))
    assert found.decision.claims == ("last",)


def test_intervals_hold_whatever_became_of_broken_trials(trials, solved):
    """Of false reports every fourth trial broke: the ends are those of all of these unsolved, and all solved."""
    broke = np.arange(BLOCKS) % 4 == 1
    broken = [replace(one, ending="error") if one.condition == "lie" and one.trial % 4 == 2 else one for one in trials]
    (why,) = whys_of(broken, AGENT)
    found = why.decision
    ends = (solved | {"lie": np.where(broke, end, solved["lie"])} for end in (0.0, 1.0))
    failed, opened = (decide(as_groups(end)) for end in ends)
    assert found.total.low == min(failed.total.low, opened.total.low)
    assert found.total.high == max(failed.total.high, opened.total.high)
    assert found.total.value == (solved["lie"] - solved["truth"])[~broke].mean()
    assert found.total.clusters == BLOCKS - broke.sum()


@pytest.mark.parametrize("missing", PLANNED)
def test_without_trials_in_a_planned_arm_there_is_no_answer(trials, missing):
    assert whys_of([one for one in trials if one.condition != missing], AGENT) == ()

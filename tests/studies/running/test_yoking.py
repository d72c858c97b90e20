"""Self-yoked trials: as many false reports as the agent's own trial with lies in loops had, at random steps."""

from dataclasses import replace

import pytest

from lockprobe.foundation.errors import BadValue, TrialFault
from lockprobe.interventions.yoked import Yoked
from lockprobe.report.verify.verification import verify
from lockprobe.studies.branch import Branching
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal, load
from lockprobe.studies.running.runner import run, run_study
from lockprobe.studies.running.single import run_trial
from lockprobe.studies.running.yoking import as_recorded, bound, is_yoked
from lockprobe.trial.told_outcome import flipped

LOOPING, YOKED = "flip?p=0.8&while=looping", "yoked?p=0.8&how=looping"
STUDY = study(
    agent=["cognitive:perseverant", "world:loop-breaker"], condition=[YOKED, LOOPING], trials=8, repetitions=1
)


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    directory = tmp_path_factory.mktemp("yoked") / "out"
    run_study(STUDY, directory)
    return directory


def pairs(trials):
    """Trials of equal agent and luck under both conditions."""
    found = {(trial.condition, trial.agent, trial.trial): trial for trial in trials}
    return [(found[LOOPING, a, n], found[YOKED, a, n]) for a in STUDY.agents for n in range(1, 9)]


def lies(trial):
    return [i + 1 for i in range(len(trial.steps) - 1) if flipped(trial, i)]


def test_every_trial_has_as_many_lies_at_other_steps(directory):
    trials = load(directory)
    assert len(trials) == STUDY.size
    planned = 0
    for source, yoked in pairs(trials):
        steps = [int(step) for step in str(yoked.channels[0]["at"]).split(";")]
        assert len([step for step in steps if step]) == len(lies(source))
        assert max(steps) < len(source.steps)
        assert lies(yoked) == [step for step in steps if 0 < step < len(yoked.steps)]
        planned += len(lies(source))
    assert planned > 20
    assert any(lies(source) != lies(yoked) for source, yoked in pairs(trials))


def test_a_study_with_it_can_be_verified_and_resumed_in_any_order(directory, tmp_path):
    assert [check.name for check in verify(directory) if not check.holds] == []
    trials = load(directory)
    with Journal.open(tmp_path, STUDY) as journal:
        yoked = [trial for trial in trials if trial.condition == YOKED]
        run(STUDY, journal, plans=lambda agent: [p for p in STUDY.plans(agent) if p.condition.label == YOKED])
        assert not journal.trials  # what they follow is owed
        run(STUDY, journal)
    assert {trial.key: trial for trial in load(tmp_path)} == {trial.key: trial for trial in trials}
    assert yoked


def test_a_trial_waits_for_one_that_broke(directory):
    trials = {trial.key: trial for trial in load(directory)}
    plan = next(plan for plan in STUDY.plans(STUDY.agents[0]) if is_yoked(plan.condition))
    made = bound(plan, STUDY, trials)
    assert made is not None
    assert not is_yoked(made.condition)
    assert made.condition.label == YOKED
    key = plan.key.replace(YOKED, LOOPING)
    assert bound(plan, STUDY, {}) is None
    broken = replace(trials[key], ending="error", error=_fault(trials[key]))
    assert bound(plan, STUDY, {key: broken}) is None
    assert as_recorded(plan, trials[plan.key]).condition.specs == made.condition.specs


def _fault(trial):
    from lockprobe.trial.record import TrialError

    return TrialError(boundary="model", step=3, message="down")


def test_a_fork_of_it_tells_what_was_told(directory):
    trials = load(directory)
    _, yoked = next(pair for pair in pairs(trials) if lies(pair[1]))
    asked = Branching(study=STUDY, trials={yoked.key: yoked}, at=("1",), arms=("truth",))
    (plan,) = asked.plans(yoked.agent)
    assert plan.condition.specs[0].startswith(YOKED)
    assert "at=" in plan.condition.specs[0]


def test_it_cannot_stand_alone():
    with pytest.raises(BadValue, match=r"expected with the condition flip\?p=0.8&while=looping in the same study"):
        study(agent="random", condition=YOKED)
    with pytest.raises((BadValue, TrialFault), match="a study that also has"):
        run_trial(agent="random", condition=YOKED)
    with pytest.raises(BadValue, match="at: got"):
        Yoked(p=0.4, how="next", at=(3,))

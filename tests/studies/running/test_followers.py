"""Trials that follow other trials: as many false reports as there, the misreadings there, or their rates."""

import asyncio
import json
from dataclasses import replace
from functools import cache
from shutil import rmtree

import pytest
from benchmarked import benchmark
from painted import painted_twins

from lockprobe.agents.llm.model_facts import OWN_FACTS
from lockprobe.agents.model_access import Access
from lockprobe.foundation.errors import BadFile, BadValue, BudgetReached, TrialFault, UnknownName
from lockprobe.interventions.confusion import rates_of
from lockprobe.interventions.sources import follows
from lockprobe.interventions.yoked import Yoked
from lockprobe.report.verify.verification import verify
from lockprobe.statistics.confusion import confusion
from lockprobe.statistics.misinterpretation import claims
from lockprobe.studies.branch import Branching
from lockprobe.studies.costs.budget import Budget
from lockprobe.studies.modality import interventions_for
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal, load
from lockprobe.studies.running.followers import Followers, as_recorded
from lockprobe.studies.running.runner import Limits, run, run_study
from lockprobe.studies.running.single import run_trial
from lockprobe.testing.provider import ScriptedProvider, completion, joints, pictures, turns, words
from lockprobe.trial.loop import play
from lockprobe.trial.told_outcome import false_reports

LOOPING, YOKED = "flip?p=0.8&while=looping", "yoked?p=0.8&how=looping"
STUDY = study(
    agent=["cognitive:perseverant", "cognitive:loop-breaker"], condition=[YOKED, LOOPING], trials=8, repetitions=1
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
    return [i + 1 for i, false in enumerate(false_reports(trial)) if false]


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
    plan = next(plan for plan in STUDY.plans(STUDY.agents[0]) if follows(plan.condition))
    made = Followers(STUDY, trials).bound(plan)
    assert made is not None
    assert made.condition.interventions[0].at
    assert made.condition == plan.condition
    key = plan.key.replace(YOKED, LOOPING)
    assert Followers(STUDY, {}).bound(plan) is None
    broken = replace(trials[key], ending="error", error=_fault(trials[key]))
    assert Followers(STUDY, {key: broken}).bound(plan) is None
    assert as_recorded(plan, trials[plan.key]).condition.interventions == made.condition.interventions


def _fault(trial):
    from lockprobe.trial.record import TrialError

    return TrialError(boundary="model", step=3, message="down")


def test_a_fork_of_it_tells_what_was_told(directory):
    trials = load(directory)
    _, yoked = next(pair for pair in pairs(trials) if lies(pair[1]))
    asked = Branching(study=STUDY, trials={yoked.key: yoked}, at=("1",), arms=("truth",))
    (plan,) = asked.plans(yoked.agent)
    assert plan.condition.specs[0] == YOKED
    assert plan.condition.interventions[0].at == as_recorded(plan, yoked).condition.interventions[0].at != ()


def test_it_cannot_stand_alone():
    with pytest.raises(BadValue, match=r"expected with the condition flip\?p=0.8&while=looping in the same study"):
        study(agent="random", condition=YOKED)
    with pytest.raises((BadValue, TrialFault), match="a study that also has"):
        run_trial(agent="random", condition=YOKED)
    with pytest.raises(BadValue, match="at: got"):
        Yoked(p=0.4, how="next", at=(3,))


# What pictures were misread as: the painted box of the benchmark, whose viewers misread by a known rule.

known = benchmark("known_viewers")
BRIDGE = study("bridge", trials=12, layout="fixed")
ARMS = [one.label for one in BRIDGE.conditions]


@cache
def bridged(world, asked=BRIDGE):
    """The trials of a world by arm, each in the order of its blocks."""
    agent, trials = known.KnownViewer(world=known.WORLDS[world]), {}
    for arm in ARMS:
        followers = Followers(asked, dict(trials))
        for number in range(1, asked.trials + 1):
            plan = followers.bound(asked.plan(asked.agents[0], asked.labelled(arm), 1, number))
            acting = interventions_for(plan.condition)
            trial = asyncio.run(play(plan, plant=known.PaintedBox(plan.box), interventions=acting, agent=agent))
            assert trial.error is None
            trials[trial.key] = trial
    return {arm: [one for one in trials.values() if one.condition == arm] for arm in ARMS}


def told(trial):
    """Everything of a trial that does not say how the box was shown."""
    return [(step.state, step.joint, step.moved, step.decision.joint) for step in trial.steps]


def test_an_agent_that_acts_on_its_misreadings_alone_plays_alike_when_they_are_replayed():
    played = bridged("misreads at random, rate 0.25")
    assert [told(trial) for trial in played["pictures"]] == [told(trial) for trial in played["replayed"]]
    assert [told(trial) for trial in played["pictures"]] != [told(trial) for trial in played["words"]]
    misread = [sum(claim.false_belief for claim in claims(trial)) for trial in played["pictures"]]
    assert sum(misread) > 20
    assert misread == [sum(step.told_falsely for step in trial.steps[:-1]) for trial in played["replayed"]]


def test_where_nothing_was_misread_the_words_are_the_same_byte_for_byte():
    played = bridged("reads well, decides otherwise")
    words = [line_of(trial) for trial in played["words"]]
    for arm in ARMS[2:]:
        assert [line_of(trial) for trial in played[arm]] == words
    assert [told(trial) for trial in played["pictures"]] != [told(trial) for trial in played["words"]]


def line_of(trial):
    """The steps and the opening, as the record has them."""
    return trial.opening, [repr(step) for step in trial.steps]


def test_as_many_are_shuffled_and_the_rates_are_those_of_the_pictures():
    played = bridged("misreads at random, rate 0.25")
    for source, shuffled in zip(played["pictures"], played["shuffled"], strict=True):
        misread = sum(claim.false_belief for claim in claims(source))
        steps = [int(step) for step in str(shuffled.channels[0]["at"]).split(";") if step != "0"]
        assert len(steps) == len({*steps}) == misread
        assert max(steps, default=0) < len(source.steps)
    matrix = confusion(played["pictures"])
    for trial in played["profile"]:
        entries = rates_of(tuple(str(trial.channels[0]["by_label"]).split(";")))
        labelled = dict(zip(trial.labels, trial.joints, strict=True))
        for label, rates in entries.items():
            assert rates == pytest.approx(matrix.rates()[labelled[label]], abs=1e-5)
        assert trial.channels[0]["size"] == matrix.claims
    total = matrix.misread / matrix.claims
    entries = rates_of(tuple(str(played["symmetric"][0].channels[0]["by_label"]).split(";")))
    assert [rate for both in entries.values() for rate in both] == [pytest.approx(total, abs=1e-5)] * 8


def test_a_source_has_to_be_there_and_to_be_played():
    for condition, expected in (
        ("yoked?claims=rgb", r"a source that the study has \(truth.*\), or STUDY/CONDITION"),
        ("flip?like=nothing", r"a source that the study has"),
    ):
        with pytest.raises(BadValue, match=expected):
            study(agent="viewer", condition=condition, plant="fast-twin")
    with pytest.raises(BadValue, match="viewer:human-inspired plays by what it sees"):
        study("bridge", agent=["viewer", "human-inspired"])
    with pytest.raises(BadFile):
        study(agent="random", condition="flip?like=nowhere/rgb")


THERE = study("flips", agent="cognitive:perseverant", p=[0, 0.4], trials=6, repetitions=1)


def following(there, **more):
    """A study whose conditions follow another one."""
    conditions = [f"flip?like={there}/flip?p=0.4", f"replay=yoked?claims={there}/flip?p=0.4"]
    asked = {"agent": "human-inspired", "condition": conditions, "trials": 4, "repetitions": 1}
    return study("flips", **asked | more)


def test_misreadings_of_another_study_are_a_condition_of_this_one(tmp_path):
    """The rates stand in the settings, so the other study may go; no path stands in a key."""
    run_study(THERE, tmp_path / "there")
    here = following(tmp_path / "there")
    trials = run_study(here, tmp_path / "here")
    matrix = confusion([trial for trial in load(tmp_path / "there") if trial.condition == "flip?p=0.4"])
    like = here.conditions[1]
    assert rates_of(like.interventions[0].rates) == {
        joint: pytest.approx(rates, abs=1e-5) for joint, rates in matrix.rates().items()
    }
    assert like.interventions[0].size == matrix.claims > 20
    assert like.label == "flip?p=1&like=flips/flip?p=0.4"
    assert not any(str(tmp_path) in trial.key for trial in trials)
    for label in (like.label, "replay"):
        assert any(step.told_falsely for trial in trials for step in trial.steps if trial.condition == label)
    rmtree(tmp_path / "there")
    assert [check.name for check in verify(tmp_path / "here") if not check.holds] == []


def test_a_source_that_has_changed_is_refused(tmp_path):
    run_study(THERE, tmp_path / "there")
    here = following(tmp_path / "there")
    rmtree(tmp_path / "there")
    run_study(replace(THERE, seed=9), tmp_path / "there")
    with pytest.raises(BadFile, match="its misreadings have changed since this study began"):
        run_study(here, tmp_path / "here")


def test_a_source_that_does_not_fit_is_refused_before_anything_is_played(tmp_path):
    run_study(THERE, tmp_path / "there")
    run_study(replace(THERE, name="silent", assessment=False), tmp_path / "silent")
    for given, said in (
        ({"box": "chain-3"}, "expected a study of chain-3, not of chain-4"),
        ({"trials": 7}, "expected one with repetition 1, trial 7"),
        ({"condition": f"yoked?claims={tmp_path}/there/rgb"}, "no condition in .* is called 'rgb'"),
        ({"condition": f"yoked?claims={tmp_path}/silent/truth"}, "whose agent said what its attempts did"),
        ({"condition": f"flip?like={tmp_path}/silent/truth"}, "whose agent said what its attempts did"),
        ({"condition": f"flip?like={tmp_path}/there/truth&of=random"}, "of: got 'random', expected an agent of"),
        ({"condition": "yoked?claims=/truth"}, "the directory of a study before the slash"),
        ({"condition": "yoked?claims=truth", "assessment": False}, "assessment: got False"),
        ({"condition": "flip?like=truth&of=random"}, "none with a source in the same study"),
        ({"condition": "flip?like=truth&size=3"}, "one without size, which the study fills in"),
        ({"condition": "yoked?claims=truth&misread=1:A:moved"}, "one without misread, which the study fills in"),
    ):
        with pytest.raises((BadValue, UnknownName), match=said):
            following(tmp_path / "there", **given)
    other = following(tmp_path / "there", box="chain-3", condition=f"flip?like={tmp_path}/there/flip?p=0.4&by=total")
    rates = rates_of(other.conditions[1].interventions[0].rates)
    assert set(rates) == set(other.box.names)
    assert len({*rates.values()}) == 1


PRICE = """
[[model]]
match = ["openai-api/scripted/model"]
price = { input = 3, cached = 1, output = 0.01, date = "2026-01-02", source = "made up" }
"""


def seen_as(request):
    """A model that takes every third picture for a move, and in words believes what it is told."""
    listing, (turn, told) = joints(request), turns(request)
    shown = pictures(request["messages"][-1])
    last = "none" if turn == 0 else "moved" if shown and shown[0][0][-20] % 3 == 0 else "did not move"
    if turn and not shown:
        reports = [words(one).rpartition(": ")[2] for one in request["messages"] if one["role"] != "assistant"]
        last = "moved" if reports[-1] != reports[-2] else "did not move"
    answer = {"last_action": last, "hypothesis": told[-5:], "joint": listing[(turn + (last == "moved")) % len(listing)]}
    return completion(json.dumps(answer))


def test_a_vision_model_plays_it_within_a_budget_and_goes_on(tmp_path, monkeypatch):
    """What the budget leaves is owed; then every call is made once, and the record can be checked."""
    painted_twins(monkeypatch)
    (tmp_path / "models.toml").write_text(PRICE)
    monkeypatch.setenv(OWN_FACTS, str(tmp_path / "models.toml"))
    with ScriptedProvider(seen_as) as provider:
        asked = study("bridge", agent=provider.agent, trials=3, max_steps=5)
        limits = Limits(access=Access(connections=2))
        with Journal.open(tmp_path / "study", asked) as journal:
            journal.calls.limit(Budget(asked, 0.03))
            with pytest.raises(BudgetReached):
                run(asked, journal, limits=limits)
            begun = {trial.condition for trial in journal.trials.values()}
        trials = run_study(asked, tmp_path / "study", limits=limits)
        made = len(provider.requests)
    assert {"words", "pictures"} >= begun > set()
    assert len(trials) == asked.size
    assert made == sum(len(trial.steps) for trial in trials)
    told = [sum(step.told_falsely for step in trial.steps[:-1]) for trial in trials if trial.condition == "replayed"]
    assert sum(told) > 0
    assert [check.name for check in verify(tmp_path / "study") if not check.holds] == []

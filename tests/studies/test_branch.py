"""Forks of recorded trials: the past is on record, one report is changed, and the agent plays on."""

import pickle
from dataclasses import replace

import pytest
from provider_server import Manner, here

from lockprobe.agents.llm.settings import Access
from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.simulation.exact import propagate
from lockprobe.statistics.branch import branch_effects
from lockprobe.statistics.design import CROSSED
from lockprobe.studies.branch import FORKS, TOLD, branching, play_forks
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.executor import Limits
from lockprobe.studies.running.runner import run_study
from lockprobe.trial.record import TrialError
from lockprobe.trial.source import false_reports

ASKED = {"p": [0.0, 0.4], "trials": 6, "repetitions": 1}


def played(directory, planned, **asked):
    """The parents by key, and the forks that are asked for."""
    trials = run_study(planned, directory)
    wanted = branching(planned, trials, **asked)
    with Journal.open(directory / FORKS, planned) as journal:
        play_forks(wanted, journal)
    return {trial.key: trial for trial in trials}, load(directory / FORKS)


@pytest.fixture(scope="module")
def strategies(tmp_path_factory):
    planned = study("flips", agent=["cognitive:insistent", "random"], **(ASKED | {"trials": 2}))
    return played(tmp_path_factory.mktemp("forks"), planned, at=["3", "7"], times=2, told=list(TOLD))


def by_name(forks):
    return {fork.fork: fork for fork in forks}


def test_told_what_was_told_a_fork_is_the_trial_on_record(strategies):
    parents, forks = strategies
    same = 0
    for name, fork in by_name(forks).items():
        parent = parents[name.parent]
        told = "lie" if false_reports(parent)[name.at - 1] else "truth"
        if (name.arm, name.time) == (told, 1):
            same += 1
            assert (fork.opening, fork.steps, fork.ending) == (parent.opening, parent.steps, parent.ending)
    assert same > 6


def test_only_the_report_at_the_fork_differs_from_the_record_until_the_agent_acts(strategies):
    parents, forks = strategies
    for name, fork in by_name(forks).items():
        parent = parents[name.parent]
        assert fork.steps[: name.at - 1] == parent.steps[: name.at - 1]
        mine, theirs = fork.steps[name.at - 1], parent.steps[name.at - 1]
        assert (mine.joint, mine.moved, mine.state, mine.decision) == (
            theirs.joint, theirs.moved, theirs.state, theirs.decision
        )  # fmt: skip
        assert false_reports(fork)[name.at - 1] == (name.arm in ("lie", "truth-lie", "lie-lie"))
        assert ("Correction:" in mine.told) == (name.arm in CROSSED)
        assert (mine.told_moved is None) == (name.arm == "withheld")
        assert bool(fork.steps[name.at].remark) == (name.arm == "remark")


def test_arms_share_their_luck_and_continuations_do_not(strategies):
    """What an agent that reads nothing does after a fork depends on the continuation and on nothing that is told."""
    _, forks = strategies
    actions = {}
    for name, fork in by_name(forks).items():
        if fork.agent == "random":
            actions.setdefault((name.parent, name.at, name.time), set()).add(fork.actions)
    assert {len(found) for found in actions.values()} == {1}
    first, second = ({key[:2]: found for key, found in actions.items() if key[2] == time} for time in (1, 2))
    assert sum(first[key] != second[key] for key in first) > len(first) * 0.8


def test_forks_are_no_trials_of_the_study_and_the_same_command_owes_nothing(tmp_path):
    planned = study("flips", agent="random", **(ASKED | {"trials": 2}))
    _, forks = played(tmp_path, planned, at=["4"])
    assert len(load(tmp_path)) == planned.size
    wanted = branching(planned, load(tmp_path), at=["4"])
    for plan in wanted.plans("random"):  # as it travels to a worker
        assert pickle.loads(pickle.dumps(plan)).key == plan.key
    with Journal.open(tmp_path / FORKS, planned) as journal:
        assert not any(journal.owes(plan.key) for plan in wanted.plans("random"))
        play_forks(wanted, journal)
    assert load(tmp_path / FORKS) == forks


@pytest.mark.slow
def test_forks_estimate_the_exact_effect_of_one_lie(tmp_path):
    """Propagation with one report forced either way is the truth."""
    agent = "cognitive:perseverant"
    planned = study("flips", agent=agent, p=[0.0], trials=150, repetitions=1, modality="symbolic")
    parents, forks = played(tmp_path, planned, at=["4"], times=2)
    (change,) = [one.change for one in branch_effects(forks, parents) if one.outcome == "success"]
    truth, lie = (propagate(agent, p=p, flip=OutcomeFlip(at=(4,)), modality="symbolic") for p in (0, 1))
    exact = (lie.success - truth.success) / (1 - truth.solved[4])
    error = (change.high - change.low) / 2 / 1.98
    assert abs(change.value - exact) < 3.5 * error
    assert error < 0.05


def test_what_cannot_be_forked_is_refused_in_one_line(tmp_path):
    planned = study("flips", agent=["human-inspired", "random"], **ASKED)
    trials = run_study(planned, tmp_path)
    for asked, message in (
        ({"at": ["40"]}, "40"),
        ({"at": ["nowhere"]}, "a step from 1, or one of onset"),
        ({"at": ["0"]}, "a step from 1"),
        ({"told": ["lies"]}, "one of truth, lie, truth-truth"),
        ({"times": 0}, "from 1 to 1000"),
        (
            {"keys": ["flips/human-inspired/truth/rep=1/trial=1"], "at": ["19"]},
            "after which a trial goes on that no person played",
        ),
    ):
        with pytest.raises(BadValue, match=message):
            branching(planned, trials, **asked)
    with pytest.raises(UnknownName, match="no trial is called 'flips/nobody'"):
        branching(planned, trials, keys=["flips/nobody"])
    broken = replace(trials[0], ending="error", error=TrialError(boundary="model", message="gone", step=3))
    with pytest.raises(BadValue, match="after which a trial goes on that no person played"):
        branching(planned, [broken, *trials[1:]], keys=[broken.key])
    assert broken.key not in branching(planned, [broken, *trials[1:]]).trials


def test_no_request_on_record_is_sent_again_and_what_was_told_costs_nothing(tmp_path):
    asked = {"box": "random-8-1", "p": [0.3], "trials": 2, "repetitions": 1, "max_steps": 10}
    planned, limits = study("flips", agent="llm:openai-api/fake/model", **asked), Limits(access=Access(connections=32))
    with here(manner=Manner()) as server:
        parents = {trial.key: trial for trial in run_study(planned, tmp_path, limits=limits)}
        known = set(server.account()["conversations"])
    with here(manner=Manner()) as server, Journal.open(tmp_path / FORKS, planned) as journal:
        arms = {"told": ["truth", "lie", "lie-truth", "withheld"], "at": ["2", "5", "first-lie"], "times": 2}
        play_forks(branching(planned, [*parents.values()], **arms), journal, limits=limits)
        seen = set(server.account()["conversations"])
    assert seen
    assert not known & seen
    calls, forks = read_calls(tmp_path / FORKS), {fork.key: fork for fork in load(tmp_path / FORKS)}
    as_recorded = {fork.key for fork in forks.values() if fork.steps == parents[fork.fork.parent].steps}
    assert as_recorded
    assert {call.key for call in calls} == forks.keys() - as_recorded
    assert all(forks[key].fork.time == 1 for key in as_recorded)
    assert all(call.step > forks[call.key].fork.at for call in calls)

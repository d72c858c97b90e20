"""Providers break in many ways; what a study records is as if none had, or an error at the right boundary.

``LOCKPROBE_CHAOS=210`` in the environment makes the large study of as many trials.
"""

import os
from contextlib import suppress
from dataclasses import replace
from itertools import chain, repeat

import pytest
from provider_server import ENDS, HTTP_FAULTS, REPLY_FAULTS, Manner, here, mixed

from lockprobe.agents.llm.settings import Access
from lockprobe.foundation.errors import AgentsGivenUp
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.runner import Limits, run

SPEC = "llm:openai-api/fake/model"
TRIALS = int(os.environ.get("LOCKPROBE_CHAOS", "18"))


def played(directory, planned, access):
    """The trials of a study after one run, which may give its model up."""
    with Journal.open(directory, planned) as journal, suppress(AgentsGivenUp):
        run(planned, journal, limits=Limits(access=access))
    return load(directory)


def what_happened(trial):
    """A trial without what repairs leave in it: their replies and their costs."""
    steps = [
        replace(step, decision=replace(step.decision, replies=step.decision.replies[-1:], usage=None))
        for step in trial.steps
    ]
    return replace(trial, steps=tuple(steps))


ONE = study(StudyOptions(agent=[SPEC], p=[0], trials=1, repetitions=1))
QUICK = Access(connections=1, timeout=2, retries=2, pause=0.01)


FAULTY = {
    "429 with Retry-After": "the provider answered 429: Rate limit reached",
    "429": "the provider answered 429: Rate limit reached",
    "500": "the provider answered 500: The server had an error",
    "dropped": "Server disconnected without sending a response",
    "dropped midway": "peer closed connection without sending complete message body",
    "stalled": "no reply within 0.3 s",
    "truncated": "a reply that cannot be read",
    "malformed": "a reply that cannot be read",
    "a string": "service unavailable",
    "upstream": "the provider answered 502: Upstream error",
    "no content": "the provider answered with an error: an empty reply that no model gives, stop",
}
"""What a trial ends with, at the boundary ``model``, if the provider does nothing else; once is asked again."""

ENDING = {
    "wrong schema": ("reply", "stop", 5, "Field required"),
    "empty": ("reply", "stop", 5, "an empty reply (after 5 tokens)"),
    "refusal": ("refusal", "content_filter", 1, "refused: I cannot help with opening locks."),
    "filtered": ("refusal", "content_filter", 1, "refused: finish_reason content_filter"),
    "cut": ("reply", "max_tokens", 2, "the reply was cut off after 5 tokens: a larger max_tokens leaves it more room)"),
}
"""Where a trial ends that gets no other reply, why the model stopped, after how many, and with which words."""


@pytest.fixture(scope="module")
def right(tmp_path_factory):
    """The record of the one trial where nothing goes wrong."""
    with here():
        return played(tmp_path_factory.mktemp("right"), ONE, QUICK)


def test_a_provider_that_fails_for_a_while_is_asked_again_and_leaves_no_trace_in_the_record(tmp_path, right):
    with here(manner=Manner(faults=iter(["", "500", "dropped midway"]))) as server:
        assert played(tmp_path, ONE, QUICK) == right
    assert server.faults == {"500": 1, "dropped midway": 1}
    assert [call.retries for call in read_calls(tmp_path)] == [0, 2, *[0] * (len(right[0].steps) - 2)]


@pytest.mark.parametrize(("kind", "message"), [(kind, FAULTY[kind]) for kind in HTTP_FAULTS])
def test_a_provider_that_keeps_failing_breaks_the_trial_which_is_owed_again(tmp_path, right, kind, message):
    with here(manner=Manner(faults=iter(["", kind, kind, kind]))) as server:
        patience = replace(QUICK, timeout=0.3) if kind == "stalled" else QUICK
        (trial,) = played(tmp_path, ONE, patience)
        assert (trial.ending, trial.error.boundary, trial.error.step) == ("error", "model", 2)
        assert message in trial.error.message
        assert trial.error.message.endswith("(tried 3 times)")
        assert trial.steps == right[0].steps[:1]
        assert trial.owed_again
        failed = list(read_calls(tmp_path))[-1]
        assert (failed.step, failed.reply, failed.error) == (2, None, trial.error.message)
        assert played(tmp_path, ONE, QUICK) == right
    assert server.account()["arrived"] == len(right[0].steps) + 3


@pytest.mark.parametrize("kinds", [REPLY_FAULTS, ("cut", "empty")], ids=" ".join)
def test_a_reply_that_cannot_be_used_is_asked_for_again(tmp_path, right, kinds):
    with here(manner=Manner(faults=iter(["", *kinds]))):
        trials = played(tmp_path, ONE, QUICK)
    assert [what_happened(trial) for trial in trials] == [what_happened(trial) for trial in right]
    assert [len(step.decision.replies) for step in trials[0].steps] == [1, 3, *[1] * (len(right[0].steps) - 2)]
    assert trials[0].steps[1].decision.usage.calls == 3


@pytest.mark.parametrize("kind", [*REPLY_FAULTS, *ENDS])
def test_a_model_that_gives_no_other_ends_the_trial_for_good_and_is_not_paid_again(tmp_path, right, kind):
    boundary, stop, times, why = ENDING[kind]
    with here(manner=Manner(faults=chain([""], repeat(kind)))) as server:
        for _ in range(2):
            (trial,) = played(tmp_path, ONE, QUICK)
            assert (trial.ending, trial.error.boundary, trial.error.step) == ("error", boundary, 2)
            assert trial.error.message.endswith(why)
            assert (len(trial.error.replies), trial.error.usage.calls) == (times, times)
            assert trial.steps == right[0].steps[:1]
            assert not trial.owed_again
    assert server.account()["arrived"] == 1 + times
    assert [call.stop for call in read_calls(tmp_path)] == ["stop", *[stop] * times]


def test_a_study_with_a_fifth_of_all_calls_faulty_ends_with_the_right_records(tmp_path):
    planned = study(StudyOptions(agent=[SPEC], p=[0, 0.3, 0.6], trials=TRIALS // 3, repetitions=1))
    assert planned.size == TRIALS
    with here():
        right = played(tmp_path / "right", planned, Access(connections=8))
    impatient = Access(connections=8, retries=0, timeout=0.5, pause=0.02)
    runs = [impatient, *[replace(impatient, retries=3)] * 20]  # without patience first, so that trials break
    with here(manner=Manner(median=0.005, faults=mixed(0.2))) as server:
        for made, access in enumerate(runs, 1):
            trials = played(tmp_path / "chaos", planned, access)
            assert {trial.error.boundary for trial in trials if trial.error} <= {"model"}
            if made == 1:
                assert any(trial.owed_again for trial in trials)
            if len(trials) == planned.size and not any(trial.owed_again for trial in trials):
                break
    account = server.account()
    assert {trial.key: what_happened(trial) for trial in trials} == {trial.key: what_happened(trial) for trial in right}
    assert all(trial.error is None for trial in trials)
    assert all({*account["faults"]} & {*kinds} for kinds in (HTTP_FAULTS, REPLY_FAULTS))  # both had their share
    every = [*read_calls(tmp_path / "chaos")]
    calls = [call for call in every if call.reply is not None]
    assert len({(call.key, call.step, call.turn) for call in calls}) == len(calls)
    assert len(calls) == sum(step.decision.usage.calls for trial in trials for step in trial.steps)
    # a reply that crossed with the end of the client's patience is counted as an attempt that may have been charged for
    assert len(calls) <= account["replied"] <= len(calls) + sum(call.unanswered for call in every)
    print(
        f"{len(trials)} trials in {made} runs: {account['arrived']} requests, {len(calls)} replies, {account['replied']} sent, "
        f"{sum(call.unanswered for call in every)} unanswered, {account['faults']}"
    )

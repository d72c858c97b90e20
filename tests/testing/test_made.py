"""Trials made for tests are such as studies write, and the scripted provider answers as it is told."""

import asyncio
import json
import os
import subprocess
import sys
import urllib.error
import urllib.request
from contextlib import ExitStack
from dataclasses import dataclass

import pytest

import lockprobe
from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.done import Tremble
from lockprobe.studies.running.single import run_trial
from lockprobe.testing import (
    ScriptedAgent,
    ScriptedProvider,
    completion,
    failure,
    in_turn,
    joints,
    make_trial,
    play_trials,
    replying,
    words,
)
from lockprobe.trial.trial_json import trial_from_json, trial_to_json


def test_a_trial_attempts_what_it_is_told_as_the_box_reacts():
    trial = make_trial([3, 3, 0, 3, 2, 1, 0], false_at=[3], claims=[None, "moved", "blocked"])
    assert [step.moved for step in trial.steps] == [True, True, False, True, True, True, True]
    assert [step.told_falsely for step in trial.steps] == [False, False, True, False, False, False, False]
    assert [step.decision.claimed for step in trial.steps[:4]] == [None, "moved", "blocked", None]
    assert (trial.solved, trial.budget, trial.labels) == (True, 7, tuple("ABCD"))
    assert trial_from_json(trial_to_json(trial)) == trial


def test_it_ends_with_its_list_or_breaks():
    assert (make_trial([0, 1]).ending, make_trial([3, 2, 1, 0, 0]).actions[-1]) == ("budget", "revolute-left")
    broken = make_trial([0, 1], broken=True)
    assert (broken.ending, broken.error.boundary, len(broken.steps)) == ("error", "model", 2)
    assert make_trial([], broken=True).steps == ()
    slipping = make_trial([0] * 9, box="fork", condition=[Tremble(p=1)])
    assert slipping.box == "fork"
    assert all(step.chosen == "revolute-left" for step in slipping.steps)


def test_trials_that_are_played_have_luck_of_their_own_and_a_script_begins_anew():
    three = play_trials("random", 3, condition="drop?p=0.5")
    assert three == [run_trial(agent="random", trial=n, condition="drop?p=0.5") for n in (1, 2, 3)]
    assert len({trial.actions for trial in three}) == 3
    scripted = run_trial(agent=ScriptedAgent(joints=(0, 1)), shuffle="never", max_steps=5)
    assert scripted.actions[::2] == ("revolute-left",) * 3
    with pytest.raises(BadValue, match="^joints: got \\(\\), expected at least one place"):
        ScriptedAgent(joints=())


BODY = {"messages": [{"role": "user", "content": "The panel's joints: A, B, C. The target joint: A."}]}


def posted(provider, body=BODY):
    """Status and body of the answer to a request."""
    request = urllib.request.Request(f"{provider.url}/chat/completions", json.dumps(body).encode())
    try:
        with urllib.request.urlopen(request, timeout=10) as answer:
            return answer.status, json.loads(answer.read())
    except urllib.error.HTTPError as error:
        return error.code, json.loads(error.read())


def said(answer):
    return answer[1]["choices"][0]["message"]["content"]


def test_answers_come_in_the_order_of_the_list_and_a_request_after_the_last_fails_the_test():
    with ExitStack() as stack:
        provider = stack.enter_context(ScriptedProvider(["one", {"joint": "B"}, failure(503, "full")]))
        assert said(posted(provider)) == "one"
        assert json.loads(said(posted(provider))) == {"joint": "B"}
        assert posted(provider)[0] == 503
        assert provider.requests == [BODY] * 3
        status, body = posted(provider)
        assert (status, body["error"]["message"]) == (400, "LookupError: a request came after the last of 3 answers")
        with pytest.raises(LookupError, match="after the last of 3 answers"):
            stack.close()


def test_a_function_answers_each_request_and_what_it_asserts_reaches_the_test():
    def answer(request):
        assert len(request["messages"]) == 1, "the conversation grew"
        return replying(request, joints(request)[-1])

    with ExitStack() as stack:
        provider = stack.enter_context(ScriptedProvider(answer))
        assert json.loads(said(posted(provider)))["joint"] == "C"
        posted(provider, {"messages": [*BODY["messages"], *BODY["messages"]]})
        with pytest.raises(AssertionError, match="the conversation grew"):
            stack.close()


def test_by_itself_it_goes_through_the_joints():
    request = BODY
    for joint in "ABCA":
        reply = in_turn(request)[1]["choices"][0]["message"]
        assert json.loads(reply["content"])["joint"] == joint
        told = {"role": "user", "content": f"{joint} did not move."}
        request = {"messages": [*request["messages"], reply, told]}
    assert json.loads(said(in_turn(request)))["last_action"] == "did not move"


def test_the_environment_says_where_it_is_as_long_as_it_runs(monkeypatch):
    monkeypatch.setenv("MINE_BASE_URL", "before")
    monkeypatch.delenv("MINE_API_KEY", raising=False)
    with ScriptedProvider(lambda request: completion("x"), name="mine", keep=False) as provider:
        assert provider.agent == "llm:openai-api/mine/model"
        assert os.environ["MINE_BASE_URL"] == provider.url
        assert os.environ["MINE_API_KEY"]
        posted(provider)
    assert os.environ["MINE_BASE_URL"] == "before"
    assert "MINE_API_KEY" not in os.environ
    assert provider.requests == []  # a long run need not be kept


@dataclass(frozen=True, kw_only=True)
class Polite:
    """Says please, from the second step on."""

    def brief(self, briefing, past, task, rng):
        return briefing.remarking("Please go on.") if len(past) > 1 else briefing


@pytest.mark.parametrize("condition", [[Polite()], "hypothesis?ask=off", "hypothesis?ask=after"])
def test_a_prompt_of_ones_own_is_seen_on_the_wire_and_replies_are_of_the_form_that_is_asked_for(condition):
    pytest.importorskip("inspect_ai")
    with ScriptedProvider() as provider:
        trial = lockprobe.run_trial(agent=provider.agent, condition=condition, max_steps=3)
    assert trial.error is None
    assert all(len(step.decision.replies) == 1 for step in trial.steps)
    polite = ["Please" in words(request["messages"][-1]) for request in provider.requests]
    assert polite == [False, *[not isinstance(condition, str)] * 2]


def test_it_needs_nothing_but_the_standard_library():
    code = (
        "import sys; import lockprobe; before = set(sys.modules); from lockprobe.testing import ScriptedProvider;"
        "new = {name.partition('.')[0] for name in set(sys.modules) - before};"
        "print(sorted(new - set(sys.stdlib_module_names) - {'lockprobe'}), 'numpy' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[] False"


def test_a_hosted_model_plays_in_a_notebook(tmp_path):
    """A notebook's thread runs an event loop: neither the provider nor the study may need one there."""
    planned = lockprobe.study(agent=["llm:openai-api/scripted/model"], p=[0, 0.4], trials=1, repetitions=1)

    async def cell():
        with ScriptedProvider() as provider:
            trials = lockprobe.run_study(planned, tmp_path)
        return trials, len(provider.requests)

    trials, requests = asyncio.run(cell())
    assert [trial.error for trial in trials] == [None, None]
    assert requests == sum(len(trial.steps) for trial in trials)

"""The scripted provider answers as it is told, keeps what it was asked, and brings nothing heavy along."""

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
from lockprobe.testing import ScriptedProvider, completion, failure, in_turn, joints, replying, words

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


def test_answers_come_in_the_order_of_the_list_and_requests_are_kept():
    with ScriptedProvider(["one", {"joint": "B"}, failure(503, "full")]) as provider:
        assert said(posted(provider)) == "one"
        assert json.loads(said(posted(provider))) == {"joint": "B"}
        assert posted(provider)[0] == 503
    assert provider.requests == [BODY] * 3


def test_a_request_after_the_last_answer_fails_the_test():
    with ExitStack() as stack:
        provider = stack.enter_context(ScriptedProvider(["one"]))
        posted(provider)
        status, body = posted(provider)
        assert (status, body["error"]["message"]) == (400, "LookupError: a request came after the last of 1 answers")
        with pytest.raises(LookupError, match="after the last of 1 answers"):
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
    with ScriptedProvider(name="mine") as provider:
        assert provider.agent == "llm:openai-api/mine/model"
        assert os.environ["MINE_BASE_URL"] == provider.url
        assert os.environ["MINE_API_KEY"]
    assert os.environ["MINE_BASE_URL"] == "before"
    assert "MINE_API_KEY" not in os.environ


def test_a_long_run_need_not_be_kept():
    with ScriptedProvider(lambda request: completion("x"), keep=False) as provider:
        posted(provider)
    assert provider.requests == []


@dataclass(frozen=True, kw_only=True)
class Polite:
    """Says please, from the second step on."""

    def brief(self, briefing, past, task, rng):
        return briefing.remarking("Please go on.") if len(past) > 1 else briefing


def test_a_prompt_of_ones_own_is_seen_on_the_wire():
    pytest.importorskip("inspect_ai")
    with ScriptedProvider() as provider:
        trial = lockprobe.run_trial(agent=provider.agent, condition=[Polite()], max_steps=3)
    assert trial.error is None
    assert ["Please" in words(request["messages"][-1]) for request in provider.requests] == [False, True, True]


@pytest.mark.parametrize("spec", ["hypothesis?ask=off", "hypothesis?ask=after"])
def test_its_replies_are_of_the_form_that_is_asked_for(spec):
    pytest.importorskip("inspect_ai")
    with ScriptedProvider() as provider:
        trial = lockprobe.run_trial(agent=provider.agent, condition=spec, max_steps=4)
    assert trial.error is None
    assert all(len(step.decision.replies) == 1 for step in trial.steps)


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

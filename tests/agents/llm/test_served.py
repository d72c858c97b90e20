"""A real model behind HTTP: the embedded one, served in a process of its own as an OpenAI-compatible endpoint."""

import json
import os
import subprocess
import sys

import pytest
from prefixes import repeated_prefix

from lockprobe.agents import weights
from lockprobe.agents.llm.model_facts import ModelFacts
from lockprobe.agents.llm.settings import Access, ModelSettings
from lockprobe.agents.llm.token_bounds import at_most, tokens
from lockprobe.agents.prompt import conversation
from lockprobe.agents.reply import parse_reply
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running.runner import Limits, run_study
from lockprobe.trial.model_call import Usage
from lockprobe.trial.record import Percept, Situation, Task, Turn

pytest.importorskip("xllamacpp")
pytestmark = pytest.mark.skipif(weights.embedded() is None, reason="the embedded model is not installed")

SERVE = """
import sys, xllamacpp
params = xllamacpp.CommonParams()
params.model.path, params.n_ctx, params.n_parallel = sys.argv[1], 4096, 2
params.cpuparams.n_threads = params.cpuparams_batch.n_threads = 1
params.flash_attn_type = params.cache_ram_mib = 0
params.warmup = params.fit_params = False
params.verbosity = -1
server = xllamacpp.Server(params)
print(server.listening_address, flush=True)
sys.stdin.read()
"""
SPEC = "llm:openai-api/served/smollm2?temperature=0&max_tokens=120"


@pytest.fixture(scope="module")
def address():
    """Where the server listens; it ends with its standard input."""
    command = [sys.executable, "-c", SERVE, str(weights.locate("llm:local"))]
    environment = os.environ | {"OMP_WAIT_POLICY": "passive"}
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment) as server:
        yield server.stdout.readline().strip()
        server.stdin.close()


@pytest.fixture(scope="module")
def played(address, tmp_path_factory):
    """A study of one short trial, and what was called for it."""
    directory = tmp_path_factory.mktemp("served")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SERVED_BASE_URL", f"{address}/v1")
        patch.setenv("SERVED_API_KEY", "nobody-asks-for-one")
        planned = study(StudyOptions(agent=[SPEC], p=[0.4], trials=1, repetitions=1, max_steps=3))
        trials = run_study(planned, directory, limits=Limits(access=Access(connections=1)))
    return trials, list(read_calls(directory))


def situations(trial):
    """What the model was told at every step, from the record."""
    target = trial.labels[trial.joints.index(trial.target)]
    task, past = Task(joints=trial.listing, target=target, budget=trial.budget), ()
    percept = Percept(positions=(False,) * len(trial.listing), text=trial.opening)
    for step in trial.steps:
        yield Situation(task=task, past=past, percept=percept)
        past = (*past, Turn(percept=percept, decision=step.decision))
        percept = Percept(joint=step.decision.joint, positions=percept.positions, text=step.told)


@pytest.mark.slow
def test_every_decision_is_what_the_model_itself_replied(played):
    trials, _ = played
    assert len(trials) == 1
    for trial in trials:
        assert trial.ending in ("solved", "budget")
        for step, situation in zip(trial.steps, situations(trial), strict=True):
            said = parse_reply(step.decision.replies[-1], situation)
            assert (step.decision.joint, step.decision.claimed) == (said.joint, said.claimed)
            assert step.joint == trial.joints[trial.labels.index(said.joint)]


def test_the_form_that_was_asked_for_is_kept_at_the_first_call(played):
    """The server enforces the schema; a model of this size would not keep to it by itself."""
    trials, _ = played
    for trial in trials:
        for step in trial.steps:
            (reply,) = step.decision.replies
            assert [*json.loads(reply)] == ["last_action", "hypothesis", "joint"]


def test_the_record_says_what_the_model_was_and_what_was_sent(played):
    trials, _ = played
    for trial in trials:
        sent = {"temperature": 0.0, "top_p": "provider default", "max_tokens": 120, "schema": "strict", "repairs": 4}
        assert trial.facts.items() >= ({"model": "openai-api/served/smollm2"} | sent).items()


def test_every_call_is_on_disk_with_what_it_took(played):
    trials, calls = played
    assert len(calls) == sum(len(trial.steps) for trial in trials)
    for trial in trials:
        own = [call for call in calls if call.key == trial.key]
        assert [call.reply for call in own] == [step.decision.replies[0] for step in trial.steps]
        for call, step in zip(own, trial.steps, strict=True):
            assert (call.step, call.turn, call.usage) == (step.step, 1, step.decision.usage)
            assert 200 < call.usage.input_tokens < 1000
            assert 10 < call.usage.output_tokens <= 120


def test_a_prefix_cache_hits_what_requests_repeat(played):
    """Measured by the runtime itself, which keeps the conversations it had, beside what requests repeat of each other."""
    trials, _ = played
    for trial in trials:
        requests = [conversation(situation) for situation in situations(trial)]
        spent = sum((step.decision.usage for step in trial.steps), Usage())
        assert 0.5 < repeated_prefix(requests) < spent.cached_tokens / spent.input_tokens + 0.1


@pytest.mark.slow
def test_what_was_said_of_the_size_of_requests_holds_for_the_models_own_count(played):
    trials, _ = played
    for trial in trials:
        for step, situation in zip(trial.steps, situations(trial), strict=True):
            messages = conversation(situation)
            counted, most = step.decision.usage, at_most(messages, ModelSettings(max_tokens=120), ModelFacts())
            assert counted.input_tokens <= most.input_tokens
            assert counted.output_tokens <= most.output_tokens
            assert counted.input_tokens == pytest.approx(sum(tokens(message.text) for message in messages), rel=0.35)

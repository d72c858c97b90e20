"""A real model behind HTTP: the embedded one, served in a process of its own as an OpenAI-compatible endpoint."""

import json
import os
import subprocess
import sys

import pytest

from lockprobe.agents import local
from lockprobe.agents.llm.settings import Access
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running.runner import Limits, run_study

pytest.importorskip("xllamacpp")
pytestmark = pytest.mark.skipif(local.embedded() is None, reason="the embedded model is not installed")

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
def played(tmp_path_factory):
    """One short trial, and what was called for it. The server ends with its standard input."""
    command = [sys.executable, "-c", SERVE, str(local.locate("llm:local"))]
    environment, directory = os.environ | {"OMP_WAIT_POLICY": "passive"}, tmp_path_factory.mktemp("served")
    with (
        subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment) as server,
        pytest.MonkeyPatch.context() as patch,
    ):
        patch.setenv("SERVED_BASE_URL", f"{server.stdout.readline().strip()}/v1")
        planned = study(StudyOptions(agent=[SPEC], p=[0.4], trials=1, repetitions=1, max_steps=3))
        (trial,) = run_study(planned, directory, limits=Limits(access=Access(connections=1)))
        server.stdin.close()
    return trial, list(read_calls(directory))


def test_a_real_server_replies_in_the_form_that_was_asked_for_at_the_first_call(played):
    """The server enforces the schema; a model of this size would not keep to it by itself."""
    trial, calls = played
    assert trial.ending in ("solved", "budget")
    sent = {"temperature": 0.0, "top_p": "provider default", "max_tokens": 120, "schema": "strict", "repairs": 4}
    assert trial.facts.items() >= ({"model": "openai-api/served/smollm2"} | sent).items()
    for step, call in zip(trial.steps, calls, strict=True):
        (reply,) = step.decision.replies
        said = json.loads(reply)
        assert [*said] == ["last_action", "hypothesis", "joint"]
        claims = {"moved": "moved", "did not move": "blocked", "none": None}
        assert (said["joint"], claims[said["last_action"]]) == (step.decision.joint, step.decision.claimed)
        assert (call.key, call.step, call.turn, call.reply, call.usage) == (
            trial.key, step.step, 1, reply, step.decision.usage,
        )  # fmt: skip

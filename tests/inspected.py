"""Runs our tasks as Inspect AI runs them, against a server on loopback."""

import gc

import pytest
from provider_server import Manner, here

MODEL = "openai-api/fake/model"
SPEC = f"llm:{MODEL}"

IN_EVALS = pytest.mark.filterwarnings("ignore:(?i)unclosed:ResourceWarning")
"""Marks tests that run an eval: inspect-ai 0.3.285 leaves connections and streams of its own open."""


def evaluated(tmp_path, monkeypatch, task, answer, **options):
    """The log of an eval, and the server with all requests."""
    with here(answer, Manner(keeps=False), keep=True) as server:
        monkeypatch.setenv("FAKE_BASE_URL", server.url)
        monkeypatch.setenv("FAKE_API_KEY", "sk-private-0123456789")
        log = _log(tmp_path, task, options)
        gc.collect()  # what is left open is found in the test that left it
    return log, server


def _log(tmp_path, task, options):
    from inspect_ai import eval as inspect_eval
    from inspect_ai.model import get_model

    quiet = {"display": "none", "log_realtime": False, "ctl_server": False, "max_retries": 0}
    model = get_model(MODEL, memoize=False)  # of the server that runs now
    return inspect_eval(task, model=model, log_dir=str(tmp_path), **{**quiet, "reasoning_summary": "none"} | options)[0]

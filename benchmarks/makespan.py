"""How long a study of a hosted model takes, against the least that it can take, beside plain Inspect AI, in one run.

    uv run python benchmarks/makespan.py [--trials 210] [--connections 10,32] [--median 0.5] [--ways lockprobe,inspect]

A server in a process of its own answers after lognormal latencies (sigma 0.5), drawn by hash of the conversation, so
that the same step of the same trial takes the same time whoever asks. Its model keeps to two joints and never opens the
box: every trial takes 20 steps. No schedule is faster than the total latency divided by the connections, nor than the
longest chain of latencies of one trial; the larger is the bound. The plain way is what a user would write first: an
eval whose samples are the same trials, with a solver that calls ``generate`` in a loop, and Inspect AI's defaults but
for the number of connections.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import ClassVar

import numpy as np
from inspect_ai import Task, eval  # noqa: A004 - its name
from inspect_ai.dataset import Sample
from inspect_ai.model import ChatMessageAssistant, ChatMessageUser, ResponseSchema
from inspect_ai.solver import Generate, Solver, TaskState, solver
from inspect_ai.util import JSONSchema

from lockprobe.agents.llm import model as _  # noqa: F401 - so that nobody is charged for importing it
from lockprobe.agents.model_access import Access
from lockprobe.agents.prompt import conversation, parse_reply, reply_schema
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.running.runner import Limits, run
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.studies.study import Study
from lockprobe.trial.record import Decision, Fact, Situation

SERVER = Path(__file__).parents[1] / "tests" / "provider_server.py"
MODEL = "openai-api/fake/model"


@contextmanager
def serving(median: float) -> Iterator[str]:
    """The base URL of a fresh server."""
    manner = json.dumps({"answer": "blind", "median": median, "sigma": 0.5})
    command = [sys.executable, str(SERVER), manner]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        yield process.stdout.readline().strip()
        process.stdin.close()


def by_lockprobe(planned: Study, connections: int) -> None:
    """The study as ``lockprobe run`` plays it."""
    with TemporaryDirectory() as directory, Journal.open(directory, planned) as journal:
        run(planned, journal, limits=Limits(access=Access(connections=connections)))


class Generating:
    """An agent inside an eval that asks by the solver's ``generate``."""

    facts: ClassVar[Mapping[str, Fact]] = {}

    def __init__(self, state: TaskState, generate: Generate) -> None:
        self._state, self._generate = state, generate

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """One call."""
        said, state = conversation(situation), self._state
        if not situation.past:
            state.messages = []
        made = {"user": ChatMessageUser, "assistant": ChatMessageAssistant}
        state.messages += [made[message.role](content=message.text) for message in said[len(state.messages) :]]
        form = ResponseSchema(name="reply", json_schema=JSONSchema.model_validate(reply_schema(situation)), strict=True)
        self._state = await self._generate(state, response_schema=form)
        return parse_reply(self._state.output.completion, situation)


def by_inspect(planned: Study, connections: int) -> None:
    """The same trials as an eval with a plain solver."""
    plans = {plan.key: plan for plan in planned.plans(planned.agents[0])}

    @solver
    def playing() -> Solver:
        async def solve(state: TaskState, generate: Generate) -> TaskState:
            await play_timed(plans[str(state.sample_id)], Generating(state, generate), lambda key, step: None)
            return state

        return solve

    with TemporaryDirectory() as directory:
        task = Task(dataset=[Sample(id=key, input="the box") for key in plans], solver=playing())
        log = eval(task, model=MODEL, max_connections=connections, log_dir=directory, display="none")[0]
        assert log.status == "success", log.error


WAYS = {"lockprobe": by_lockprobe, "inspect": by_inspect}


def measured(way: str, connections: int, trials: int, median: float) -> str:
    """One row of the table."""
    planned = study(StudyOptions(agent=[f"llm:{MODEL}"], p=[0.3], trials=trials, repetitions=1))
    with serving(median) as url:
        os.environ |= {"FAKE_BASE_URL": url, "FAKE_API_KEY": "none"}
        wall, processor = time.perf_counter(), time.process_time()
        WAYS[way](planned, connections)
        wall, processor = time.perf_counter() - wall, time.process_time() - processor
        with urllib.request.urlopen(url.removesuffix("/v1") + "/account", timeout=60) as answer:
            account = json.loads(answer.read())
    bound = max(account["latency"] / connections, account["longest_chain"])
    cost = 1000 * processor / account["arrived"]
    return (
        f"| {way} | {connections} | {account['arrived']} | {account['latency']:.1f} | {account['longest_chain']:.1f} | "
        f"{bound:.1f} | {wall:.1f} | {wall / bound:.3f} | {cost:.2f} |"
    )


def main() -> None:
    """Print the table, row by row."""
    asked = argparse.ArgumentParser()
    asked.add_argument("--trials", type=int, default=210)
    asked.add_argument("--connections", default="10,32")
    asked.add_argument("--median", type=float, default=0.5)
    asked.add_argument("--ways", default="lockprobe,inspect")
    given = asked.parse_args()
    print(
        "| way | connections | requests | total s | longest chain s | bound s | makespan s | ratio | CPU ms a request |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    for connections in map(int, given.connections.split(",")):
        for way in given.ways.split(","):
            print(measured(way, connections, given.trials, given.median), flush=True)
    print(f"load average {os.getloadavg()[0]:.2f}")


if __name__ == "__main__":
    main()

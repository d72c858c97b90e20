"""How long a study of a hosted model takes, against the least that it can take, beside plain Inspect AI, in one run.

    uv run python benchmarks/makespan.py [--trials 210] [--connections 10,32] [--median 0.5] [--rounds 1]
        [--ways lockprobe,inspect,client,post]

A server in a process of its own answers after lognormal latencies (sigma 0.5), drawn by hash of the conversation, so
that the same step of the same trial takes the same time whoever asks. Its model keeps to two joints and never opens the
box: every trial takes 20 steps. No schedule is faster than the total latency divided by the connections, nor than the
longest chain of latencies of one trial; the larger is the bound. ``inspect`` is what a user would write first: an
eval whose samples are the same trials, with a solver that calls ``generate`` in a loop, and Inspect AI's defaults but
for the number of connections. ``client`` is a loop around OpenAI's client, with neither retries nor records, and
``post`` the same with the client's ``post``, which skips the search through types: the least that this client costs. A
short median shows how many calls a second one processor makes. With rounds, the ways take turns, and the row with the
least processor time of each counts. The last column is its ratio to that of ``client``.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, ClassVar

import numpy as np
from inspect_ai import Task, eval  # noqa: A004 - its name
from inspect_ai.dataset import Sample
from inspect_ai.model import ChatMessageAssistant, ChatMessageUser, ResponseSchema
from inspect_ai.solver import Generate, Solver, TaskState, solver
from inspect_ai.util import JSONSchema
from openai import AsyncOpenAI
from openai.types.chat import ChatCompletion

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
            await play_timed(plans[str(state.sample_id)], Generating(state, generate))
            return state

        return solve

    with TemporaryDirectory() as directory:
        task = Task(dataset=[Sample(id=key, input="the box") for key in plans], solver=playing())
        log = eval(task, model=MODEL, max_connections=connections, log_dir=directory, display="none")[0]
        assert log.status == "success", log.error


class Asking:
    """An agent that asks OpenAI's client itself."""

    facts: ClassVar[Mapping[str, Fact]] = {}

    def __init__(self, ask: Callable[..., Any]) -> None:
        self._ask = ask

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """One call."""
        said = [{"role": message.role, "content": message.text} for message in conversation(situation)]
        schema = {"name": "reply", "schema": reply_schema(situation), "strict": True}
        form = {"type": "json_schema", "json_schema": schema}
        came = await self._ask(model="model", messages=said, response_format=form)
        return parse_reply(came.choices[0].message.content, situation)


def by_client(planned: Study, connections: int, *, post: bool = False) -> None:
    """The same trials in a loop around OpenAI's client, as many at once as there are connections."""

    async def playing() -> None:
        plans = iter(planned.plans(planned.agents[0]))
        url, key = os.environ["FAKE_BASE_URL"], os.environ["FAKE_API_KEY"]
        async with AsyncOpenAI(base_url=url, api_key=key) as client:

            async def posted(**body: Any) -> Any:
                return await client.post("/chat/completions", cast_to=ChatCompletion, body=body)

            agent = Asking(posted if post else client.chat.completions.create)

            async def lane() -> None:
                for plan in plans:
                    await play_timed(plan, agent)

            await asyncio.gather(*(lane() for _ in range(connections)))

    asyncio.run(playing())


WAYS: dict[str, Callable[[Study, int], None]] = {
    "lockprobe": by_lockprobe,
    "inspect": by_inspect,
    "client": by_client,
    "post": partial(by_client, post=True),
}


@dataclass(frozen=True)
class Measured:
    """One way with so many connections: seconds, and milliseconds of processor time per request."""

    requests: int
    latency: float
    longest_chain: float
    bound: float
    wall: float
    cost: float


def measured(way: str, connections: int, trials: int, median: float) -> Measured:
    """Play the study once, with a fresh server."""
    planned = study(StudyOptions(agent=[f"llm:{MODEL}"], p=[0.3], trials=trials, repetitions=1))
    with serving(median) as url:
        os.environ |= {"FAKE_BASE_URL": url, "FAKE_API_KEY": "none"}
        wall, processor = time.perf_counter(), time.process_time()
        WAYS[way](planned, connections)
        wall, processor = time.perf_counter() - wall, time.process_time() - processor
        with urllib.request.urlopen(url.removesuffix("/v1") + "/account", timeout=60) as answer:
            account = json.loads(answer.read())
    latency, chain = account["latency"], account["longest_chain"]
    bound = max(latency / connections, chain)
    return Measured(account["arrived"], latency, chain, bound, wall, 1000 * processor / account["arrived"])


def row(way: str, connections: int, one: Measured, client: Measured | None) -> str:
    """One row of the table."""
    least = f"{one.wall / one.bound:.3f}" if one.bound else ""
    beside = f"{one.cost / client.cost:.2f}" if client is not None else ""
    return (
        f"| {way} | {connections} | {one.requests} | {one.latency:.1f} | {one.longest_chain:.1f} | {one.bound:.1f} | "
        f"{one.wall:.1f} | {least} | {one.requests / one.wall:.0f} | {one.cost:.2f} | {beside} |"
    )


def main() -> None:
    """Print the table."""
    asked = argparse.ArgumentParser()
    asked.add_argument("--trials", type=int, default=210)
    asked.add_argument("--connections", default="10,32")
    asked.add_argument("--median", type=float, default=0.5)
    asked.add_argument("--rounds", type=int, default=1)
    asked.add_argument("--ways", default="lockprobe,inspect")
    given = asked.parse_args()
    ways = given.ways.split(",")
    print(
        "| way | connections | requests | total s | longest chain s | bound s | makespan s | ratio "
        "| requests a second | CPU ms a request | / client |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for connections in map(int, given.connections.split(",")):
        rounds = [
            {way: measured(way, connections, given.trials, given.median) for way in ways}
            for number in range(given.rounds)
        ]
        best = {way: min((one[way] for one in rounds), key=lambda found: found.cost) for way in ways}
        for way in ways:
            print(row(way, connections, best[way], best.get("client")), flush=True)
    print(f"load average {os.getloadavg()[0]:.2f}")


if __name__ == "__main__":
    main()

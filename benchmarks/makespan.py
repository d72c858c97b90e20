"""How long a study of a hosted model takes, against the least that it can take, beside a bare loop, in one run.

    uv run python benchmarks/makespan.py [--trials 210] [--connections 10,32] [--median 0.5] [--rounds 1]
        [--ways lockprobe,bare]

A server in a process of its own answers after lognormal latencies (sigma 0.5), drawn by hash of the conversation, so
that the same step of the same trial takes the same time whoever asks. Its model keeps to two joints and never opens the
box: every trial takes 20 steps. No schedule is faster than the total latency divided by the connections, nor than the
longest chain of latencies of one trial; the larger is the bound. ``bare`` is what a user would write first: a loop
around the HTTP library, with neither retries nor records. A median of 0 shows how many calls a second one processor
makes. Nobody is charged for the imports of a first call, which both share, nor for certificates, which a server without
TLS does not need. With rounds, the ways take turns, and the row with the least processor time of each counts. The last
column is its ratio to that of the bare loop; with rounds the median ratio of requests a second follows.
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
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import ClassVar

import httpx2
import numpy as np

from lockprobe.agents.llm import model as _  # noqa: F401 - so that nobody is charged for importing it
from lockprobe.agents.llm.settings import Access
from lockprobe.agents.prompt import conversation, reply_schema
from lockprobe.agents.reply import asked_for, parse_reply
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


class Asking:
    """An agent that asks the HTTP library itself."""

    facts: ClassVar[Mapping[str, Fact]] = {}

    def __init__(self, http: httpx2.AsyncClient) -> None:
        self._http = http

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """One call."""
        said = [{"role": message.role, "content": message.text} for message in conversation(situation)]
        schema = {"name": "reply", "schema": reply_schema(asked_for(situation)), "strict": True}
        form = {"type": "json_schema", "json_schema": schema}
        body = {"model": "model", "messages": said, "response_format": form}
        came = await self._http.post("/chat/completions", json=body)
        return parse_reply(came.json()["choices"][0]["message"]["content"], situation)


def by_bare_loop(planned: Study, connections: int) -> None:
    """The same trials in a loop around the HTTP library, as many at once as there are connections."""

    async def playing() -> None:
        plans = iter(planned.plans(planned.agents[0]))
        limits = httpx2.Limits(max_connections=None, max_keepalive_connections=connections)
        url = os.environ["FAKE_BASE_URL"]
        async with httpx2.AsyncClient(base_url=url, timeout=None, limits=limits, verify=False) as http:

            async def lane() -> None:
                for plan in plans:
                    await play_timed(plan, Asking(http))

            await asyncio.gather(*(lane() for _ in range(connections)))

    asyncio.run(playing())


WAYS: dict[str, Callable[[Study, int], None]] = {
    "lockprobe": by_lockprobe,
    "bare": by_bare_loop,
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


def row(way: str, connections: int, one: Measured, bare: Measured | None) -> str:
    """One row of the table."""
    least = f"{one.wall / one.bound:.3f}" if one.bound else ""
    beside = f"{one.cost / bare.cost:.2f}" if bare is not None else ""
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
    asked.add_argument("--ways", default="lockprobe,bare")
    given = asked.parse_args()
    ways = given.ways.split(",")
    print(
        "| way | connections | requests | total s | longest chain s | bound s | makespan s | ratio "
        "| requests a second | CPU ms a request | / bare |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for way in ways:
        measured(way, 1, 1, 0.0)
    for connections in map(int, given.connections.split(",")):
        rounds = [
            {way: measured(way, connections, given.trials, given.median) for way in ways[:: -1 if number % 2 else 1]}
            for number in range(given.rounds)
        ]
        best = {way: min((one[way] for one in rounds), key=lambda found: found.cost) for way in ways}
        for way in ways:
            print(row(way, connections, best[way], best.get("bare")), flush=True)
        if given.rounds > 1 and {*WAYS} <= {*ways}:
            beside = median(one["bare"].wall / one["lockprobe"].wall for one in rounds)
            print(f"{connections} connections: {beside:.2f} of the bare loop's requests a second")
    print(f"load average {os.getloadavg()[0]:.2f}")


if __name__ == "__main__":
    main()

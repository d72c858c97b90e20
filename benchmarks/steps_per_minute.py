"""Steps per minute of the embedded model: scored answers against plain JSON generation, in one run.

    uv run python benchmarks/steps_per_minute.py [--minutes 1]

The plain way is what a user would write first: the conversation as chat, one request at a time, a JSON schema, the
reply generated token by token, by the same runtime from the same file on one thread. Both play the same flip study
(p = 0 and 0.4, same seed), each for the same time; the figure to quote is the ratio.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import ClassVar

import numpy as np

from lockprobe.agents.local import Engine, locate
from lockprobe.agents.prompt import conversation, reply_schema
from lockprobe.agents.reply import asked_for, parse_reply
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.running.executor import Observer
from lockprobe.studies.running.runner import Limits, run
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.trial.record import Decision, Fact, Situation, Step


class TimeIsUp(Exception):
    """Ends a measurement."""


class Counting(Observer):
    """Counts steps from the first one on, and ends the run when the time is up."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self.steps = 0
        self.began: float | None = None

    def step(self, key: str, step: Step) -> None:
        """One step was played."""
        now = time.perf_counter()
        if self.began is None:
            self.began = now
            return
        self.steps += 1
        if now - self.began >= self.seconds:
            raise TimeIsUp

    @property
    def per_minute(self) -> float:
        """Steps per minute so far."""
        assert self.began is not None
        return self.steps / (time.perf_counter() - self.began) * 60


class PlainJson:
    """The model asked the plain way."""

    facts: ClassVar[Mapping[str, Fact]] = {}

    def __init__(self) -> None:
        self._server = Engine(locate("llm:local"))._server  # noqa: SLF001

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Generate one reply under a JSON schema."""
        answer = self._server.handle_chat_completions(
            {
                "messages": [{"role": m.role, "content": m.text} for m in conversation(situation)],
                "response_format": {
                    "type": "json_schema",
                    "json_schema": {"schema": reply_schema(asked_for(situation))},
                },
                "max_tokens": 100,
                "temperature": 1.0,
                "seed": int(rng.integers(2**31)),
            }
        )
        return parse_reply(answer["choices"][0]["message"]["content"], situation)


def plain(seconds: float) -> float:
    """Steps per minute of the plain way."""
    agent, counting = PlainJson(), Counting(seconds)
    with suppress(TimeIsUp):
        for plan in study(StudyOptions(agent=["llm:local"], p=[0, 0.4], trials=1000)).plans("llm:local"):
            asyncio.run(play_timed(plan, agent, counting.step))
    return counting.per_minute


def scored(seconds: float, workers: int) -> float:
    """Steps per minute of ``lockprobe run`` with so many worker processes."""
    planned = study(StudyOptions(agent=["llm:local"], p=[0, 0.4], trials=1000))
    counting = Counting(seconds)
    with TemporaryDirectory() as directory, Journal.open(Path(directory), planned) as journal, suppress(TimeIsUp):
        run(planned, journal, limits=Limits(workers=workers), observer=counting)
    return counting.per_minute


def main() -> None:
    """Measure and print one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=1.0, help="time per way of playing")
    seconds = parser.parse_args().minutes * 60
    figures = {
        "plain": plain(seconds),
        "scored, 1 process": scored(seconds, 1),
        "scored, 2 processes": scored(seconds, 2),
    }
    ratios = {name: round(value / figures["plain"], 2) for name, value in figures.items()}
    rounded = {name: round(value) for name, value in figures.items()}
    print(json.dumps({"steps per minute": rounded, "ratio to plain": ratios, "cores": os.cpu_count()}, indent=2))


if __name__ == "__main__":
    main()

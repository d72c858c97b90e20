"""A study that is served, and people who are programs: over HTTP they do what the page does, and decide as a strategy.

A visitor sends an act again until that has counted, as the page does when the network fails.
"""

import asyncio
import json
import random
import subprocess
from contextlib import asynccontextmanager
from types import SimpleNamespace

import forked
import httpx2 as httpx
from seated import Player, parts, people_study

from lockprobe.people.experiment import Experiment, read_words
from lockprobe.people.server_state import Reply
from lockprobe.people.web import app
from lockprobe.people.web.address import Address

PATIENCE = 60.0
"""Seconds for which a visitor tries to reach a server that is gone."""

STUDY = people_study(trials=3)
QUESTIONS = ({"name": "how", "question": "How?"}, {"name": "sure", "question": "?", "options": ["a", "b"]})


def experiment(**changes):
    return Experiment.model_validate({"practice": "", "questions": QUESTIONS, **changes})


@asynccontextmanager
async def served(directory, study=STUDY, people=None):
    """The server in this process: its address, the key of a preview, and a client without cookies."""
    async with (
        app.opened(directory, study, people or experiment(), read_words("en"), Address(port=0)) as (where, state),
        httpx.AsyncClient(base_url=where.url, trust_env=False, verify=False, timeout=60) as http,
    ):
        yield SimpleNamespace(url=where.url, preview=state.preview, http=http, directory=directory, study=study)


@asynccontextmanager
async def visiting(place, platform=None):
    visitor = Visitor(place.url, place.study, place.directory, platform=platform)
    try:
        yield visitor
    finally:
        await visitor.http.aclose()


def start(*arguments):
    """``lockprobe serve`` in a process of its own, and its address."""
    process = forked.start(["serve", *arguments, "--json"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    return process, json.loads(process.stdout.readline())["url"]


class Visitor:
    """One person with one browser.

    Args:
        url: Of the server.
        study: Of which the visitor plays trials; for the random streams of the strategy alone.
        directory: Of the study; which trials they are is looked up in the diary there.
        strategy: How it decides.
        platform: The parameters of its URL.
        luck: Seed of how long it waits.
    """

    def __init__(self, url, study, directory, strategy="human-inspired", platform=None, luck=1):
        json_ = {"content-type": "application/json"}
        self.http = httpx.AsyncClient(base_url=url, headers=json_, trust_env=False, verify=False, timeout=PATIENCE)
        self.platform, self.strategy, self.replies = platform or {}, strategy, []
        self.luck, self.seen, self.resent = random.Random(luck), [], 0
        self._player = Player(directory, study, strategy)

    @property
    def scene(self):
        return self.seen[-1].scene

    @property
    def turn(self):
        return self.seen[-1].turn

    @property
    def identity(self):
        return self.seen[-1].participant

    async def post(self, path, body):
        """One request, made again while the server is gone or in trouble."""
        until = asyncio.get_running_loop().time() + PATIENCE
        while True:
            try:
                answer = await self.http.post(path, json=body)
            except httpx.TransportError:
                assert asyncio.get_running_loop().time() < until, "nobody answers"
                self.resent += 1
                await asyncio.sleep(0.02 + 0.1 * self.luck.random())
                continue
            assert answer.status_code < 500, answer.text
            self.replies.append(answer.content)
            return answer

    async def open(self):
        """Load the page."""
        answer = await self.post("/api/open", {"platform": self.platform})
        assert answer.status_code == 200, answer.text
        self._take(answer.json())

    async def act(self, **act):
        """Do something, until it has counted once."""
        before = self.seen[-1]
        while self.seen[-1] == before:
            body = {"turn": before.turn, "act": act, "platform": self.platform}
            answer = await self.post("/api/act", body)
            if answer.status_code == 200:
                self._take(answer.json())
            else:
                assert answer.status_code == 409, answer.text
                await self.open()
        assert self.turn == before.turn + 1 or self.scene.kind == "closed"

    def _take(self, reply):
        reply.pop("words", None)
        shown = Reply("", **{**reply, "scene": parts(reply["scene"])})
        if self.seen and self.turn == shown.turn and shown.scene.kind != "closed":
            assert self.scene == shown.scene, "what was shown has changed"
        else:
            self.seen.append(shown)

    async def do(self):
        """Do what the scene asks for."""
        act = await self._player.act(self.seen[-1])
        await self.act(**act.model_dump(mode="json", exclude_none=True))

    async def play(self, pause=0.0, until=("debrief", "closed")):
        """Take part from the first scene to the last, with pauses of so many seconds on average."""
        if not self.seen:
            await self.open()
        while self.scene.kind not in until:
            await asyncio.sleep(self.luck.expovariate(1 / pause) if pause else 0)
            await self.do()

    async def to_the_box(self, step=1):
        """Come as far as a step of the first box."""
        await self.open()
        while self.scene.kind != "box" or self.scene.step < step:
            await self.do()


def logged(caplog):
    """The lines of the log since it was looked at last, without their times."""
    said = [one.getMessage().partition("Z ")[2] for one in caplog.records if one.name == app.__name__]
    caplog.clear()
    return said

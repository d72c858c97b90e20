"""People who are programs: over HTTP they do what the page does, and decide as a strategy does.

A visitor knows what its page shows and nothing else, but for the random stream of its strategy, which it gets for each
box from whoever tests. It sends an act again until that has counted, as the page does when the network fails.
"""

import asyncio
import contextlib
import json
import random
import subprocess
from dataclasses import dataclass, field

import forked
from seated import Player, parts
from wire import Gone, Wire

from lockprobe.people.experiment import read_words

PATIENCE = 60.0
"""Seconds for which a visitor tries to reach a server that is gone."""


@dataclass
class Seen:
    """One scene as it came."""

    turn: int
    scene: dict


@dataclass
class Visitor:
    """One person with one browser.

    Attributes:
        url: Of the server.
        study: Of which the visitor plays trials; for the random streams alone.
        directory: Of the study; the slots are looked up in the diary there.
        strategy: How it decides.
        platform: The parameters of its URL.
        luck: Of everything but the decisions.
    """

    url: str
    study: object
    directory: object
    strategy: str = "human-inspired"
    platform: dict = field(default_factory=dict)
    luck: random.Random = field(default_factory=lambda: random.Random(1))
    answers: dict = field(default_factory=dict)

    def __post_init__(self):
        self.http = Wire(self.url)
        self.seen = []
        self.resent = 0
        self.identity = self.words = None
        self._player = Player(self.directory, self.study, self.strategy)

    @property
    def scene(self):
        return self.seen[-1].scene

    @property
    def turn(self):
        return self.seen[-1].turn

    async def post(self, path, body):
        """One request, made again while the server is gone or in trouble."""
        until = asyncio.get_running_loop().time() + PATIENCE
        while True:
            try:
                answer = await self.http.post(path, body)
            except Gone:
                assert asyncio.get_running_loop().time() < until, "nobody answers"
                self.resent += 1
                await asyncio.sleep(0.02 + 0.1 * self.luck.random())
                continue
            assert answer.status_code < 500, answer.text
            return answer

    async def open(self):
        """Load the page."""
        answer = await self.post("/api/open", {"platform": self.platform})
        assert answer.status_code == 200, answer.text
        self.words = answer.json()["words"]
        self._take(answer.json())

    async def act(self, **act):
        """Do something, until it has counted once."""
        before = self.seen[-1]
        while True:
            body = {"turn": before.turn, "act": act, "platform": self.platform}
            answer = await self.post("/api/act", body)
            if answer.status_code == 200:
                self._take(answer.json())
                assert self.turn == before.turn + 1 or self.scene["kind"] == "closed"
                return
            assert answer.status_code == 409, answer.text
            await self.open()
            if self.turn == before.turn + 1:
                return
            assert self.seen[-1] == before, "what was shown has changed"

    def _take(self, reply):
        self.identity = reply["participant"]
        if self.seen and self.turn == reply["turn"] and reply["scene"]["kind"] != "closed":
            assert self.scene == reply["scene"], "what was shown has changed"
            return
        self.seen.append(Seen(reply["turn"], reply["scene"]))

    async def do(self):
        """Do what the scene asks for."""
        scene, rt = self.scene, round(self.luck.uniform(150, 9000), 1)
        match scene["kind"]:
            case "consent":
                await self.act(kind="agree", agreed=True)
            case "page" | "over":
                await self.act(kind="answers", answers=[], rt=rt)
            case "comprehension":
                right = {one.question: one.right for one in read_words("en").comprehension.questions}
                answers = [right[one["question"]] for one in scene["questions"]]
                await self.act(kind="answers", answers=answers, rt=rt)
            case "check" | "ask":
                question, options = scene["questions"][0]["question"], scene["questions"][0]["options"]
                answer = self.answers.get(question, self.luck.choice(options) if options else "by trying")
                await self.act(kind="answers", answers=[answer], rt=rt)
            case "box":
                decision = await self.decide()
                said = {"claimed": decision.claimed or "blocked", "claimed_rt": rt} if scene["ask"] else {}
                await self.act(kind="attempt", joint=decision.joint, rt=rt, **said)

    async def play(self, pause=0.0, until=("debrief", "closed")):
        """Take part from the first scene to the last."""
        if not self.seen:
            await self.open()
        while self.scene["kind"] not in until:
            if pause:
                await asyncio.sleep(self.luck.expovariate(1 / pause))
            await self.do()
        return self

    async def decide(self):
        """What the strategy does, from what is shown."""
        return await self._player.decide(parts(self.scene), self.identity)

    async def close(self):
        await self.http.close()


@contextlib.contextmanager
def server(*arguments, environment=None):
    """``lockprobe serve``, in a process of its own, while it says where it is; ended as by Ctrl-C."""
    process = start(*arguments, environment=environment)
    try:
        yield json.loads(process.stdout.readline())
    finally:
        process.terminate()
        process.wait(20)
        process.stdout.close()


def start(*arguments, environment=None):
    """The process alone; its first line says where it is."""
    asked = ["serve", *arguments, "--json"]
    return forked.start(asked, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment)

"""The agents of known truth in ``bridge_worlds.py``, and the painted box whose pictures they read.

Each reads pictures without error and then misreads them by a known rule, or does something else by them. What it says
of its actions is what it read.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from lockprobe.agents.catalogue import resolve
from lockprobe.agents.policy import told_outcome
from lockprobe.agents.viewer import Eyesight, Viewer
from lockprobe.boxes.box import Configuration
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.trial.pictures.frame import Camera, Frame
from lockprobe.trial.protocols import Agent
from lockprobe.trial.record import Decision, Fact, Moment, Percept, Situation, Snapshot, Task

__all__ = ["WORLDS", "KnownViewer", "PaintedBox", "World"]

_SIDE, _HANDLE, _APART = 8, 3, 24
"""Pixels: half of the width of a joint's column, radius of its handle, way between its two positions."""


class PaintedBox(SymbolicPlant):
    """The rules, and a small picture of each configuration: red handles on a wooden board."""

    def observe(self) -> Snapshot:
        """The truth, with a picture."""
        return self._pictured(super().observe())

    def attempt(self, joint: int) -> Snapshot:
        """The truth after an attempt, with a picture."""
        return self._pictured(super().attempt(joint))

    def _pictured(self, seen: Snapshot) -> Snapshot:
        return replace(seen, look=lambda: _painted(seen.configuration), render=_painted)


@cache
def _painted(configuration: Configuration) -> Frame:
    joints = len(configuration)
    width, height = 2 * _SIDE * joints, _APART + 4 * _HANDLE
    rgb = np.full((height, width, 3), (204, 161, 110), dtype=np.uint8)
    places = np.array([[((2 * i + 1) * _SIDE, 2 * _HANDLE + _APART * at) for at in (0, 1)] for i in range(joints)])
    row, column = np.mgrid[:height, :width]
    for i, position in enumerate(configuration):
        x, y = places[i, int(position)]
        rgb[(column - x) ** 2 + (row - y) ** 2 <= _HANDLE**2] = (219, 33, 26)
    panel = np.eye(4)
    panel[2, 3] = 1.0
    middle = np.array([(width - 1) / 2, (height - 1) / 2])
    handles = np.concatenate([places - middle, np.zeros((joints, 2, 1))], axis=-1)
    camera = Camera(width=width, height=height, focal=1.0, panel=panel)
    depth = np.zeros((height, width), dtype=np.float32)
    return Frame(rgb=rgb, depth=depth, camera=camera, handles=handles, renderer="paint")


@dataclass(frozen=True, slots=True, kw_only=True)
class World:
    """What a known viewer does with pictures.

    Attributes:
        agent: The strategy that decides by what it read, and in words by what it is told.
        hidden: Place of a joint in the panel -> the rate at which moves of it are taken for failures, [0, 1].
        invented: Place of a joint -> the rate at which failures are taken for moves, [0, 1].
        seeing: The strategy that decides in pictures, if that is another one; empty if it is the same.
        other_luck: Whether it decides in pictures with other luck than in words.
        silent: Whether it never says what its actions did.
    """

    agent: str = "human-inspired"
    hidden: Mapping[int, float]
    invented: Mapping[int, float]
    seeing: str = ""
    other_luck: bool = False
    silent: bool = False


_EVERY = range(4)

WORLDS: Mapping[str, World] = {
    "misreads at random, rate 0.25": World(hidden=dict.fromkeys(_EVERY, 0.25), invented=dict.fromkeys(_EVERY, 0.25)),
    "misreads by joint and direction": World(
        agent="cognitive:perseverant", hidden={1: 0.9, 2: 0.8, 3: 0.6}, invented={0: 0.1}
    ),
    "reads well, decides otherwise": World(hidden={}, invented={}, seeing="random-no-repeat"),
    "misreads, and decides otherwise": World(
        hidden=dict.fromkeys(_EVERY, 0.25), invented=dict.fromkeys(_EVERY, 0.25), seeing="human-inspired?lapse=0.5"
    ),
    "decides otherwise, and says nothing": World(hidden={}, invented={}, seeing="random-no-repeat", silent=True),
    "misreads, to no effect": World(
        agent="random-no-repeat",
        hidden=dict.fromkeys(_EVERY, 0.25),
        invented=dict.fromkeys(_EVERY, 0.25),
        other_luck=True,
    ),
}


@dataclass(frozen=True, kw_only=True)
class KnownViewer:
    """An agent that reads pictures without error and misreads them as its world says, independently at every report."""

    world: World

    @property
    def facts(self) -> Mapping[str, Fact]:
        """No facts for the record: its trials are analysed and discarded."""
        return {}

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Read, misread, and let the strategy decide."""
        if not situation.percept.pictures:
            return await _strategy(self.world.agent).decide(situation, rng)
        believed = self._believed(situation, rng)
        strategy = _strategy(self.world.seeing or self.world.agent)
        rng = _luck_of(rng, 2 + len(situation.past)) if self.world.other_luck else rng
        claimed = None if self.world.silent else told_outcome(believed)
        return replace(await strategy.decide(believed, rng), claimed=claimed)

    def _believed(self, situation: Situation, rng: np.random.Generator) -> Situation:
        """The situation as it is read: a misread outcome is told as a false report of the default kind is."""
        task, places = situation.task, _places(situation.task)
        read = _EYES.reports(task, [*(turn.percept for turn in situation.past), situation.percept])
        luck = _luck_of(rng).random(len(read))
        moments: list[Moment] = []
        for drawn, report in zip(luck, read, strict=True):
            wrong = report.joint is not None and drawn < self._rate(report, places)
            told = OutcomeFlip().told(report, tuple(moments), task, flipped=wrong) if moments else report
            moments.append(Moment(was=report, told=told))
        past = tuple(
            replace(turn, percept=moment.told) for turn, moment in zip(situation.past, moments[:-1], strict=True)
        )
        return replace(situation, past=past, percept=moments[-1].told)

    def _rate(self, report: Percept, places: Mapping[str, int]) -> float:
        assert report.joint is not None
        rates = self.world.hidden if report.outcome == "moved" else self.world.invented
        return rates.get(places[report.joint], 0.0)


_EYES = Viewer(strategy=resolve("random").make(), name="random", sight=Eyesight(acuity=64))


@cache
def _strategy(spec: str) -> Agent:
    return resolve(spec).make()


def _luck_of(rng: np.random.Generator, key: int = 1) -> np.random.Generator:
    """A stream beside that of the agent, the same whenever it is asked for in a trial: of misreadings, or of a step."""
    seed: Any = rng.bit_generator.seed_seq
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed.entropy, spawn_key=(*seed.spawn_key, key))))


def _places(task: Task) -> dict[str, int]:
    """Label -> the place of its joint in the panel, from the left."""
    return {label: int(x * len(task.joints)) for label, (x, _) in zip(task.joints, task.places, strict=True)}

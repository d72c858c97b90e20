"""One trial, held at each decision: as the loop of :mod:`lockprobe.trial.loop`, or by the rules alone.

The loop plays every condition and writes the record. Where nothing but flips acts on the reports of a symbolic plant, a
:class:`PlainEpisode` says the same a few times faster.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Configuration
from lockprobe.foundation.errors import ChannelFault, PlantFault
from lockprobe.interfaces.gymnasium.settings import BLOCKED, FARTHEST, EnvironmentSettings, EpisodeKey, Vector
from lockprobe.interventions.flip import told_by
from lockprobe.plants.catalogue import plant_of
from lockprobe.trial.loop import play
from lockprobe.trial.pictures.frame import Frame, from_png
from lockprobe.trial.pictures.picture import PictureKind
from lockprobe.trial.plan import Names, Plan
from lockprobe.trial.protocols import Plant
from lockprobe.trial.record import Decision, Ending, Fact, Moment, Percept, Situation, Snapshot, Task, Trial

Images = NDArray[np.uint8] | dict[str, NDArray[np.uint8] | NDArray[np.float32]]
"""Colours, shape (height, width, 3), or with metres of depth, shape (height, width, 1), 0 where there is no reading."""

_UNTOLD = 2
"""Position of a joint if a report is missing."""


class PlainEpisode:
    """One trial in which nothing but flips acts, by the rules and the law of false reports.

    Attributes:
        ending: How the trial ended; None before.
        actions: The joints attempted so far, by their number in the listing.
    """

    def __init__(self, settings: EnvironmentSettings, key: EpisodeKey) -> None:
        self.ending: Ending | None = None
        self.actions: list[int] = []
        self._settings, plan = settings, settings.plan(key)
        self._flips = settings.flips or ()
        self._luck = [
            functools.partial(plan.luck.at, f"{flip.stream}-{place}") for place, flip in enumerate(self._flips)
        ]
        box = settings.study.box
        self._space, self._listing = settings.state_space, listing(settings, plan)
        self._target = self._listing.index(self._space.target)
        self._configuration = self._space.start
        self._positions = sum(1 << place for place, joint in enumerate(self._listing) if box.initial[joint])
        self._told, self._moved, self._outcome = self._positions, False, 0

    def attempt(self, action: int) -> None:
        """Attempt the joint at this place of the listing."""
        joint, bit = self._listing[action], 1 << action
        self.actions.append(action)
        taken = len(self.actions)
        drawn = [
            stream(taken).random(flip.numbers(len(self._listing))).tolist()
            for stream, flip in zip(self._luck, self._flips, strict=True)
        ]
        self._moved = bool(self._space.may_move[self._configuration, joint])
        self._configuration ^= self._moved << joint
        self._positions ^= self._moved * bit
        outcome, self._told = told_by(self._flips, self._positions, self._told, bit, self._moved, drawn)
        self._outcome = BLOCKED + outcome
        if self._moved and action == self._target:
            self.ending = "solved"
        elif taken == self._settings.study.max_steps:
            self.ending = "budget"

    def observation(self) -> Vector:
        """The report as a vector."""
        attempted = self.actions[-1] if self.actions else None
        told = self._bits(self._told)
        return self._settings.vector(self._target, attempted, self._outcome, told, len(self.actions))

    def info(self) -> dict[str, Any]:
        """The truth if it was asked for."""
        if not self._settings.truth:
            return {}
        return {"truth": {"positions": np.array(self._bits(self._positions), dtype=np.int8), "moved": self._moved}}

    def close(self) -> None:
        """Do nothing: it holds nothing open."""

    def _bits(self, positions: int) -> list[int]:
        return [positions >> place & 1 for place in range(len(self._listing))]


def listing(settings: EnvironmentSettings, plan: Plan) -> list[int]:
    """The joints of the study's box, by index, as a trial lists them."""
    return [settings.study.box.names.index(plan.box.names[at]) for at in plan.names.order]


class HeldEpisode:
    """One trial of the loop, held at each decision, after the actions given.

    Attributes:
        actions: The joints attempted so far, by their number in the listing.
        finished: The record of the finished trial; None before.

    Raises:
        TrialFault: If the plant or a channel breaks.
    """

    def __init__(self, settings: EnvironmentSettings, key: EpisodeKey, actions: Sequence[int] = ()) -> None:
        self.actions: list[int] = []
        self.finished: Trial | None = None
        self._settings, self._key = settings, key
        self._names = (plan := settings.plan(key)).names
        self._plant, self._heard, self._moved = _WatchedPlant(plan, self._names), _Listener(), False
        self._loop = play(
            plan,
            plant=self._plant,
            interventions=(*settings.chain, self._heard),
            agent=_Outside(),
            on_step=lambda step: setattr(self, "_moved", step.moved),
        )
        self._send(None)
        for action in actions:
            self.attempt(action)

    @property
    def ending(self) -> Ending | None:
        """How the trial ended; None before."""
        return None if self.finished is None else self.finished.ending

    def attempt(self, action: int) -> None:
        """Run the loop to the next decision.

        Raises:
            TrialFault: If the plant or a channel breaks.
        """
        self.actions.append(action)
        self._send(Decision(joint=self._heard.task.joints[action]))

    def observation(self) -> Vector | Images:
        """The report as a vector, or the pictures."""
        settings, task, percept = self._settings, self._heard.task, self._heard.percept
        if settings.observation == "symbolic":
            attempted = None if percept.joint is None else task.joints.index(percept.joint)
            outcome = 0 if percept.outcome is None else BLOCKED + (percept.outcome == "moved")
            told = percept.positions or (_UNTOLD,) * len(task.joints)
            return settings.vector(task.joints.index(task.target), attempted, outcome, told, len(self.actions))
        rgb = from_png(_picture(percept, "rgb")).astype(np.uint8, copy=False)
        if settings.observation == "rgb":
            return rgb
        metres = from_png(_picture(percept, "depth16")).astype(np.float32)[..., None] / np.float32(1000)
        return {"rgb": rgb, "depth": np.where(metres <= FARTHEST, metres, np.float32(0))}

    def info(self) -> dict[str, Any]:
        """The truth if it was asked for; with pictures also the task, which they do not show."""
        info: dict[str, Any] = {}
        if self._settings.truth:
            positions = np.array(self._plant.configuration, dtype=np.int8)[list(self._names.order)]
            info["truth"] = {"positions": positions, "moved": self._moved}
        if self._settings.observation != "symbolic":
            task = self._heard.task
            info |= {"target": task.joints.index(task.target), "labels": "".join(task.joints)}
        return info

    def words(self) -> str:
        """The task and the last report."""
        task = self._heard.task
        joints = ", ".join(f"{i} {label}" for i, label in enumerate(task.joints))
        left = task.budget - len(self.actions)
        return f"Joints: {joints}. Target: {task.target}. Steps left: {left}.\n{self._heard.percept.text}"

    def frame(self) -> Frame:
        """The camera's picture now, of a plant with a camera."""
        assert self._plant.look is not None
        return self._plant.look()

    def close(self) -> None:
        """Close the plant."""
        self._loop.close()
        self._plant.close()

    def __reduce__(self) -> tuple[Any, ...]:
        """A copy is made of the actions: it plays them again."""
        return HeldEpisode, (self._settings, self._key, tuple(self.actions))

    def _send(self, decision: Decision | None) -> None:
        try:
            self._loop.send(decision)
        except StopIteration as end:
            self.finished = replace(end.value, channels=end.value.channels[:-1])  # without the listener
            if (error := self.finished.error) is not None:
                self._plant.close()
                fault = PlantFault if error.boundary == "plant" else ChannelFault
                raise fault(error.message) from None


def _picture(percept: Percept, kind: PictureKind) -> bytes:
    for picture in percept.pictures:
        if picture.kind == kind:
            return picture.png
    raise ChannelFault(f"no picture of the kind {kind} reached the agent: a channel removed it")


class _Listener:
    """The last channel: it keeps the percept and passes it on unchanged."""

    task: Task
    percept: Percept

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        self.task, self.percept = task, percept
        return percept


class _Outside:
    """The agent of the loop; every decision comes from outside."""

    facts: ClassVar[Mapping[str, Fact]] = {}

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        return await _FromOutside()


class _FromOutside:
    """Holds the loop until a decision is sent."""

    def __await__(self) -> Generator[None, Decision, Decision]:
        return (yield)


class _WatchedPlant:
    """The plant of a trial, made when it is first observed, as in studies; it is looked at once in each moment.

    Attributes:
        configuration: The present configuration in panel order.
        look: Takes the camera's picture now; None without a camera.
    """

    def __init__(self, plan: Plan, names: Names) -> None:
        self.configuration: Configuration = ()
        self.look: Callable[[], Frame] | None = None
        self._make: Callable[[], Plant] = functools.partial(plant_of, plan, names.labels)
        self._plant: Plant | None = None

    @property
    def facts(self) -> Mapping[str, Fact]:
        return {} if self._plant is None else self._plant.facts

    def observe(self) -> Snapshot:
        self._plant = self._make()
        return self._noted(self._plant.observe())

    def attempt(self, joint: int) -> Snapshot:
        assert self._plant is not None
        return self._noted(self._plant.attempt(joint))

    def close(self) -> None:
        plant, self._plant = self._plant, None
        if plant is not None:
            plant.close()

    def _noted(self, snapshot: Snapshot) -> Snapshot:
        self.configuration = snapshot.configuration
        if snapshot.look is None:
            return snapshot
        self.look = functools.cache(snapshot.look)
        render = None if snapshot.render is None else functools.cache(snapshot.render)
        return replace(snapshot, look=self.look, render=render)

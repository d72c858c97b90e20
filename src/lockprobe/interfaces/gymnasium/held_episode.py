"""An episode as the loop of :mod:`lockprobe.trial.loop`, held at each decision."""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, ClassVar

import numpy as np

from lockprobe.foundation.errors import ChannelFault, PlantFault
from lockprobe.interfaces.gymnasium.observation import Images, Vector, images, vector
from lockprobe.interfaces.gymnasium.plant import WatchedPlant, make_plant
from lockprobe.interfaces.gymnasium.settings import EnvironmentSettings, EpisodeKey
from lockprobe.trial.loop import play
from lockprobe.trial.pictures.frame import Frame
from lockprobe.trial.plan import Names, Plan
from lockprobe.trial.protocols import Intervention
from lockprobe.trial.record import Decision, Ending, Fact, Moment, Percept, Situation, Task, Trial


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


class HeldEpisode:
    """One trial, held at each decision.

    Attributes:
        heard: The last task and percept.
        finished: The record of the finished trial; None before.
    """

    def __init__(self, settings: EnvironmentSettings, key: EpisodeKey) -> None:
        self.heard = _Listener()
        self.finished: Trial | None = None
        self._settings, self._key = settings, key
        self._actions: list[int] = []
        self._plan: Plan = settings.plan(*key)
        self._names = Names(self._plan)
        self._plant = WatchedPlant(partial(make_plant, self._plan, self._names))
        self._moved = False
        chain: tuple[Intervention, ...] = (*settings.chain, self.heard)
        self._loop = play(
            self._plan,
            plant=self._plant,
            interventions=chain,
            agent=_Outside(),
            on_step=lambda step: self._note(step.moved),
        )
        self._send(None)
        self._tells_positions = self.heard.percept.positions is not None

    @property
    def ending(self) -> Ending | None:
        """How the trial ended; None before."""
        return None if self.finished is None else self.finished.ending

    def attempt(self, action: int) -> None:
        """Run the loop to the next decision.

        Raises:
            TrialFault: If the plant or a channel breaks.
        """
        self._actions.append(action)
        self._send(Decision(joint=self.heard.task.joints[action]))

    def observation(self) -> Vector | Images:
        """The report as a vector, or the pictures."""
        settings, heard = self._settings, self.heard
        if settings.observation != "symbolic":
            return images(heard.percept, settings.observation)
        left = self._steps_left if settings.steps_left else None
        return vector(heard.task, heard.percept, left, positions=self._tells_positions)

    def info(self) -> dict[str, Any]:
        """The truth if it was asked for; with pictures also the task, which they do not show."""
        info: dict[str, Any] = {}
        if self._settings.truth:
            positions = np.array(self._plant.configuration, dtype=np.int8)[list(self._names.order)]
            info["truth"] = {"positions": positions, "moved": self._moved}
        if self._settings.observation != "symbolic":
            task = self.heard.task
            info |= {"target": task.joints.index(task.target), "labels": "".join(task.joints)}
        return info

    def words(self) -> str:
        """The task and the last report."""
        task = self.heard.task
        joints = ", ".join(f"{i} {label}" for i, label in enumerate(task.joints))
        return f"Joints: {joints}. Target: {task.target}. Steps left: {self._steps_left}.\n{self.heard.percept.text}"

    def frame(self) -> Frame:
        """The camera's picture now."""
        return self._plant.frame()

    def close(self) -> None:
        """Close the plant."""
        self._loop.close()
        self._plant.close()

    def __reduce__(self) -> tuple[Any, ...]:
        """A copy is made of the actions: it plays them again."""
        return held, (self._settings, self._key, tuple(self._actions))

    @property
    def _steps_left(self) -> int:
        return self._plan.budget - len(self._actions)

    def _note(self, moved: bool) -> None:
        self._moved = moved

    def _send(self, decision: Decision | None) -> None:
        try:
            self._loop.send(decision)
        except StopIteration as end:
            self.finished = replace(end.value, channels=end.value.channels[:-1])  # without the listener
            if (error := self.finished.error) is not None:
                self._plant.close()
                fault = PlantFault if error.boundary == "plant" else ChannelFault
                raise fault(error.message) from None


def held(settings: EnvironmentSettings, key: EpisodeKey, actions: Sequence[int]) -> HeldEpisode:
    """The episode of a trial after these actions."""
    episode = HeldEpisode(settings, key)
    for action in actions:
        episode.attempt(action)
    return episode

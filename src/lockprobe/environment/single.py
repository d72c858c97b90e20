"""One lockbox as a Gymnasium environment: the loop of :mod:`lockprobe.trial`, held at each decision."""

from __future__ import annotations

from collections.abc import Generator, Mapping
from dataclasses import replace
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded

from lockprobe.channels.text import TextChannel
from lockprobe.environment.observation import Vector, vector
from lockprobe.environment.place import Place, read_place
from lockprobe.environment.settings import Settings, read_settings
from lockprobe.errors import BadValue, ChannelFault, PlantFault, UnknownName
from lockprobe.plan import Names, Plan
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.record import Decision, Fact, Percept, Situation, Task, Trial
from lockprobe.seams import Channel
from lockprobe.trial import play

__all__ = ["RENDER_MODES", "LockboxEnv"]

RENDER_MODES = ("ansi",)


class LockboxEnv(gymnasium.Env[Vector, np.int64]):
    """A box, one joint per step, until the target moves or the budget is spent.

    The observation is what the agent is told (:mod:`lockprobe.environment.observation`), an action the joint to
    attempt by its place in the listing. The reward is 1 when the target really moves, less ``step_cost`` at every
    step. ``terminated`` when the target really moves, ``truncated`` when the budget is spent before. The k-th episode
    after ``reset(seed=s)`` has the same luck as trial k of repetition 1 of a study with seed ``s``.

    Args:
        render_mode: ``"ansi"``, or None.
        settings: As :func:`lockprobe.environment.settings.read_settings` takes them.

    Attributes:
        trial: The last finished episode as a record, truth beside told; None before.
    """

    metadata: dict[str, Any] = {"render_modes": list(RENDER_MODES), "render_fps": 1}  # noqa: RUF012

    def __init__(self, *, render_mode: str | None = None, **settings: Any) -> None:
        self.render_mode = render_mode
        self.settings: Settings = read_settings(settings)
        self.action_space = spaces.Discrete(len(self.settings.box.joints))
        self.observation_space = spaces.MultiDiscrete(list(self.settings.sizes))
        self.trial: Trial | None = None
        self._next: Place | None = None
        self._episode: _Episode | None = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Vector, dict[str, Any]]:
        """Begin the next trial.

        Args:
            seed: Seed of the study to begin with; None goes on with the trial after the last one.
            options: ``repetition`` and ``trial``, to play that trial of the study and go on from there.

        Raises:
            UserMistake: If an option is none of these.
        """
        super().reset(seed=seed)
        if seed is not None:
            self._next = Place(seed=seed)
        elif self._next is None:
            self._next = Place(seed=int(self.np_random.integers(2**31)))
        place = read_place(self._next, options)
        self._episode, self._next = None, place.next
        self._episode = _Episode(self.settings, place)
        return self._observation(self._episode), self._info(self._episode)

    def step(self, action: np.int64 | int) -> tuple[Vector, float, bool, bool, dict[str, Any]]:
        """Attempt a joint.

        Raises:
            BadValue: If the action is no joint.
            ResetNeeded: If no trial is under way.
            TrialFault: If a channel breaks.
        """
        episode = self._episode
        if episode is None or episode.trial is not None:
            raise ResetNeeded("no trial is under way: call reset()")
        if not self.action_space.contains(action):
            raise BadValue("action", action, f"a whole number from 0 to {len(self.settings.box.joints) - 1}")
        self.trial = episode.attempt(int(action)) or self.trial
        ending = None if episode.trial is None else episode.trial.ending
        reward = float(ending == "solved") - self.settings.step_cost
        return self._observation(episode), reward, ending == "solved", ending == "budget", self._info(episode)

    def render(self) -> str | None:
        """The task and the last report in words, if the render mode is ``"ansi"``.

        Raises:
            UnknownName: If it is another one. Gymnasium warns of it before; tools that ask every environment for
                pictures, and then do without, can go on.
        """
        if self.render_mode is not None and self.render_mode not in RENDER_MODES:
            raise UnknownName("render mode", self.render_mode, RENDER_MODES)
        if self.render_mode is None or self._episode is None:
            return None
        episode, task = self._episode, self._episode.heard.task
        joints = ", ".join(f"{i} {label}" for i, label in enumerate(task.joints))
        return (
            f"Joints: {joints}. Target: {task.target}. Steps left: {episode.steps_left}.\n{episode.heard.percept.text}"
        )

    def close(self) -> None:
        """Drop the trial that is under way."""
        self._episode = None

    def _observation(self, episode: _Episode) -> Vector:
        heard = episode.heard
        return vector(heard.task, heard.percept, episode.steps_left if self.settings.steps_left else None)

    def _info(self, episode: _Episode) -> dict[str, Any]:
        return {"truth": episode.truth()} if self.settings.truth else {}

    def __getstate__(self) -> dict[str, Any]:
        """A trial that is under way is kept as the actions that led there, so that the environment can be copied."""
        episode = self._episode
        return self.__dict__ | {"_episode": None if episode is None else (episode.place, tuple(episode.actions))}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        if state["_episode"] is not None:
            place, actions = state["_episode"]
            self._episode = _Episode(self.settings, place)
            for action in actions:
                self._episode.attempt(action)


class _Listener:
    """The last channel: it passes everything on, and keeps what was told."""

    task: Task
    percept: Percept

    def perceive(self, percept: Percept, previous: Percept | None, task: Task, rng: np.random.Generator) -> Percept:
        self.task, self.percept = task, percept
        return percept


class _Outside:
    """The agent of the loop: every decision comes from outside."""

    facts: ClassVar[Mapping[str, Fact]] = {}

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        return await _FromOutside()


class _FromOutside:
    """Holds the loop until a decision is sent into it."""

    def __await__(self) -> Generator[None, Decision, Decision]:
        return (yield)


class _Episode:
    """One trial, held where its agent is asked.

    Attributes:
        place: Which trial it is.
        actions: The actions so far.
        heard: What was told last.
        trial: The record, once it is finished.
    """

    def __init__(self, settings: Settings, place: Place) -> None:
        self.place = place
        self.actions: list[int] = []
        self.heard = _Listener()
        self.trial: Trial | None = None
        self._plan: Plan = settings.plan(place.seed, place.repetition, place.trial)
        self._plant = SymbolicPlant(settings.box)
        self._moved = False
        chain: tuple[Channel, ...] = (*settings.channels, TextChannel(), self.heard)
        self._loop = play(
            self._plan, plant=self._plant, channels=chain, agent=_Outside(), on_step=lambda step: self._note(step.moved)
        )
        self._send(None)

    @property
    def steps_left(self) -> int:
        return self._plan.budget - len(self.actions)

    def attempt(self, action: int) -> Trial | None:
        """Let the loop go on to the next decision; the record if there is none."""
        self.actions.append(action)
        return self._send(Decision(joint=self.heard.task.joints[action]))

    def truth(self) -> dict[str, Any]:
        """What really is, in the order of the listing, and whether the last attempt moved its joint."""
        configuration = np.array(self._plant.observe().configuration, dtype=np.int8)
        return {"positions": configuration[list(Names(self._plan).order)], "moved": self._moved}

    def _note(self, moved: bool) -> None:
        self._moved = moved

    def _send(self, decision: Decision | None) -> Trial | None:
        try:
            self._loop.send(decision)
        except StopIteration as end:
            self.trial = replace(end.value, channels=end.value.channels[:-1])  # the listener is nobody's channel
            if (error := self.trial.error) is not None:
                fault = PlantFault if error.boundary == "plant" else ChannelFault
                raise fault(error.message) from None
        return self.trial

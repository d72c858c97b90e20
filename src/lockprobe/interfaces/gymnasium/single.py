"""One lockbox as a Gymnasium environment.

Its episodes are the trial loop, held at each decision (:class:`HeldEpisode`). Where nothing but flips acts on the
reports of a symbolic plant, a :class:`PlainEpisode` says the same a few times faster.
"""

from __future__ import annotations

import functools
from collections.abc import Generator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from types import coroutine
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue, ChannelFault, PlantFault
from lockprobe.interfaces.gymnasium.settings import BLOCKED, FARTHEST, EnvironmentSettings, EpisodeKey, Vector
from lockprobe.interventions.flip import told_by
from lockprobe.plants.catalogue import plant_of
from lockprobe.trial.loop import PLANT, play
from lockprobe.trial.pictures.frame import from_png
from lockprobe.trial.pictures.picture import PictureKind
from lockprobe.trial.record import Decision, Ending, Fact, Moment, Percept, Situation, Step, Task, Trial

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
        self._listing = settings.listing(plan)
        self._target = self._listing.index(settings.box.target)
        self._configuration = settings.box.start
        self._positions = sum(
            1 << place for place, joint in enumerate(self._listing) if settings.study.box.initial[joint]
        )
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
        self._moved = bool(self._settings.box.may_move[self._configuration, joint])
        self._configuration ^= self._moved << joint
        self._positions ^= self._moved * bit
        outcome, self._told = told_by(self._flips, self._positions, self._told, bit, self._moved, drawn)
        self._outcome = BLOCKED + outcome if self._settings.outcomes else 0
        if self._moved and action == self._target:
            self.ending = "solved"
        elif taken == self._settings.study.max_steps:
            self.ending = "budget"

    def observation(self) -> Vector:
        """The report as a vector."""
        attempted = self.actions[-1] + 1 if self.actions else 0
        told = self._bits(self._told) if self._settings.positions else ()
        return np.array((self._target, attempted, self._outcome, *told), dtype=np.int64)

    def info(self) -> dict[str, Any]:
        """The truth if it was asked for."""
        if not self._settings.truth:
            return {}
        return {"truth": {"positions": np.array(self._bits(self._positions), dtype=np.int8), "moved": self._moved}}

    def close(self) -> None:
        """Do nothing: it holds nothing open."""

    def _bits(self, positions: int) -> list[int]:
        return [positions >> place & 1 for place in range(len(self._listing))]


class HeldEpisode:
    """One trial of the loop, held at each decision, after the actions given.

    It is the agent of the loop, whose decisions come from outside, and the last channel, which keeps every report and
    passes it on: an agent is not asked again after the last one.

    Attributes:
        actions: The joints attempted so far, by their number in the listing.
        finished: The record of the finished trial; None before.

    Raises:
        TrialFault: If the plant or a channel breaks.
    """

    facts: ClassVar[Mapping[str, Fact]] = {}
    _task: Task
    _percept: Percept

    def __init__(self, settings: EnvironmentSettings, key: EpisodeKey, actions: Sequence[int] = ()) -> None:
        self.actions: list[int] = []
        self.finished: Trial | None = None
        self._settings, self._key, self._plan, self._open = settings, key, settings.plan(key), ExitStack()
        plan, self._names = self._plan, self._plan.names
        self._positions, self._moved = list(plan.box.initial), False
        with PLANT:
            plant = plant_of(plan, self._names.labels)
        self._open.callback(plant.close)
        self._loop = play(plan, plant=plant, interventions=(*settings.chain, self), agent=self, on_step=self._note)
        self._open.callback(self._loop.close)
        self._send(None)
        for action in actions:
            self.attempt(action)

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """Keep a report."""
        self._task, self._percept = task, percept
        return percept

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Wait for a decision from outside."""
        return await _from_outside()

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
        self._send(Decision(joint=self._task.joints[action]))

    def observation(self) -> Vector | Images:
        """The report as a vector, or the pictures."""
        settings, task, percept = self._settings, self._task, self._percept
        if settings.shown == "symbolic":
            attempted = 0 if percept.joint is None else task.joints.index(percept.joint) + 1
            told = settings.outcomes and percept.outcome is not None
            outcome = BLOCKED + (percept.outcome == "moved") if told else 0
            positions = (percept.positions or (_UNTOLD,) * len(task.joints)) if settings.positions else ()
            return np.array((task.joints.index(task.target), attempted, outcome, *positions), dtype=np.int64)
        rgb = self.picture("rgb").astype(np.uint8, copy=False)
        if settings.shown == "rgb":
            return rgb
        metres = self.picture("depth16").astype(np.float32)[..., None] / np.float32(1000)
        return {"rgb": rgb, "depth": np.where(metres <= FARTHEST, metres, np.float32(0))}

    def picture(self, kind: PictureKind) -> NDArray[Any]:
        """The picture of this kind that was shown last; ``ChannelFault`` without one."""
        for picture in self._percept.pictures:
            if picture.kind == kind:
                return from_png(picture.png)
        raise ChannelFault(f"no picture of the kind {kind} reached the agent: a channel removed it")

    def info(self) -> dict[str, Any]:
        """The truth if it was asked for; with pictures also the task, which they do not show."""
        info: dict[str, Any] = {}
        if self._settings.truth:
            positions = np.array(self._positions, dtype=np.int8)[list(self._names.order)]
            info["truth"] = {"positions": positions, "moved": self._moved}
        if self._settings.shown != "symbolic":
            task = self._task
            info |= {"target": task.joints.index(task.target), "labels": "".join(task.joints)}
        return info

    def close(self) -> None:
        """End the loop and close the plant."""
        self._open.close()

    def __reduce__(self) -> tuple[Any, ...]:
        """A copy is made of the actions: it plays them again."""
        return HeldEpisode, (self._settings, self._key, tuple(self.actions))

    def _note(self, step: Step) -> None:
        self._moved = step.moved
        self._positions = [bit == "1" for bit in step.state]
        self._positions[self._plan.box.names.index(step.joint)] ^= step.moved

    def _send(self, decision: Decision | None) -> None:
        try:
            self._loop.send(decision)
        except StopIteration as end:
            self.finished = replace(end.value, channels=end.value.channels[:-1])  # without this one
            if (error := self.finished.error) is not None:
                self.close()
                fault = PlantFault if error.boundary == "plant" else ChannelFault
                raise fault(error.message) from None


@coroutine
def _from_outside() -> Generator[None, Decision, Decision]:
    """Hold the loop until a decision is sent."""
    return (yield)


class LockboxEnv(gymnasium.Env[Vector | Images, np.int64]):
    """A box, one joint per step, until the target moves or the budget is spent.

    The observation holds the agent's reports or pictures (:mod:`lockprobe.interfaces.gymnasium.settings`). An action is
    the index of a joint in the listing. The reward is 1 when the target really moves. ``terminated`` means that it
    did, ``truncated`` that the budget was spent before. The k-th episode after ``reset(seed=s)`` has the same luck as
    trial k of repetition 1 of a study with seed ``s``.

    Args:
        render_mode: None, or where pictures are shown ``"rgb_array"``.
        settings: As in :class:`lockprobe.interfaces.gymnasium.settings.EnvironmentSettings`.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 1}  # noqa: RUF012

    def __init__(self, *, render_mode: str | None = None, **settings: Any) -> None:
        self.render_mode = render_mode
        self.settings = EnvironmentSettings(settings)
        self.action_space = spaces.Discrete(self.settings.box.joints)
        self.observation_space = self.settings.space
        if self.settings.shown == "symbolic":
            self.metadata = self.metadata | {"render_modes": []}
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise BadValue("render_mode", render_mode, "rgb_array with modality='rgb' or 'rgbd'; words are not drawn")
        self._key = self._next = EpisodeKey(seed=0)
        self._seeded = False
        self._episode: PlainEpisode | HeldEpisode | None = None
        self._finished: tuple[EpisodeKey, PlainEpisode | HeldEpisode] | None = None

    @property
    def trial(self) -> Trial | None:
        """The record of the last finished episode, truth and told; None before."""
        if self._finished is None:
            return None
        key, episode = self._finished
        if isinstance(episode, PlainEpisode):  # the loop plays it again, and records it
            episode = HeldEpisode(self.settings, key, episode.actions)
            self._finished = key, episode
        return episode.finished

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin the next trial.

        Args:
            seed: Seed of the study; None continues with the next trial.
            options: ``repetition`` and ``trial`` of the trial to play; later resets continue from there.

        Raises:
            UserMistake: If an option is unknown.
            TrialFault: If the plant or a channel breaks.
        """
        super().reset(seed=seed)
        begun = self._next
        if seed is not None or not self._seeded:
            begun = EpisodeKey(seed=int(self.np_random.integers(2**31)) if seed is None else seed)
        begun = begun.chosen(options)
        self.close()
        self._key, self._next, self._seeded = begun, begun.next, True
        self._episode = (HeldEpisode if self.settings.flips is None else PlainEpisode)(self.settings, begun)
        return self._episode.observation(), self._episode.info()

    def step(self, action: np.int64 | int) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Attempt a joint.

        Raises:
            BadValue: If the action is no joint.
            ResetNeeded: If no trial is under way.
            TrialFault: If the plant or a channel breaks.
        """
        episode = self._episode
        if episode is None or episode.ending is not None:
            raise ResetNeeded("no trial is under way: call reset()")
        if not self.action_space.contains(action):
            raise BadValue("action", action, f"a whole number from 0 to {self.settings.box.joints - 1}")
        episode.attempt(int(action))
        ending = episode.ending
        if ending is not None:
            self._finished = self._key, episode
        solved = ending == "solved"
        return episode.observation(), float(solved), solved, ending == "budget", episode.info()

    def render(self) -> NDArray[np.uint8] | None:
        """The picture that was shown last, shape (height, width, 3); None before the first."""
        held = self._episode if self.render_mode is not None else None
        return held.picture("rgb") if isinstance(held, HeldEpisode) else None

    def close(self) -> None:
        """Drop the unfinished trial and its plant."""
        if self._episode is not None:
            self._episode.close()
        self._episode = None

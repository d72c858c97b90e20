"""One lockbox as a Gymnasium environment: the loop of :mod:`lockprobe.trial.loop`, held at each decision."""

from __future__ import annotations

from collections.abc import Generator, Mapping
from dataclasses import replace
from functools import partial
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue, ChannelFault, PlantFault, UnknownName
from lockprobe.interfaces.gymnasium.observation import FARTHEST, Images, Vector, images, vector
from lockprobe.interfaces.gymnasium.plant import WatchedPlant, make_plant
from lockprobe.interfaces.gymnasium.settings import EnvironmentSettings, EpisodeKey, read_episode_key, read_settings
from lockprobe.trial.loop import play
from lockprobe.trial.plan import Names, Plan
from lockprobe.trial.protocols import Intervention
from lockprobe.trial.record import Decision, Fact, Moment, Percept, Situation, Task, Trial

__all__ = ["LockboxEnv"]

_RENDER_MODES = ("ansi", "rgb_array", "depth_array")


class LockboxEnv(gymnasium.Env[Vector | Images, np.int64]):
    """A box, one joint per step, until the target moves or the budget is spent.

    The observation holds the agent's reports or pictures (:mod:`lockprobe.interfaces.gymnasium.observation`). An action
    is the index of a joint in the listing. The reward is 1 when the target really moves, less ``step_cost`` at every
    step. ``terminated`` means that the target really moved, ``truncated`` that the budget was spent before. The k-th
    episode after ``reset(seed=s)`` has the same luck as trial k of repetition 1 of a study with seed ``s``.

    Args:
        render_mode: ``"ansi"`` or None; with a camera also ``"rgb_array"`` and ``"depth_array"``, independent of the
            observation.
        settings: As in :func:`lockprobe.interfaces.gymnasium.settings.read_settings`.

    Attributes:
        trial: The record of the last finished episode, truth and told; None before.
    """

    metadata: dict[str, Any] = {"render_modes": list(_RENDER_MODES), "render_fps": 1}  # noqa: RUF012

    def __init__(self, *, render_mode: str | None = None, **settings: Any) -> None:
        self.render_mode = render_mode
        self.settings: EnvironmentSettings = read_settings(settings)
        self.action_space = spaces.Discrete(len(self.settings.study.box.joints))
        self.observation_space = _space(self.settings)
        shown = ("ansi",) if self.settings.picture_size is None else _RENDER_MODES
        self.metadata = self.metadata | {"render_modes": list(shown)}
        self.trial: Trial | None = None
        self._next: EpisodeKey | None = None
        self._episode: _Episode | None = None

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
        if seed is not None:
            self._next = EpisodeKey(seed=seed)
        elif self._next is None:
            self._next = EpisodeKey(seed=int(self.np_random.integers(2**31)))
        key = read_episode_key(self._next, options)
        self.close()
        self._next = key.next
        self._episode = _Episode(self.settings, key)
        return self._observation(self._episode), self._info(self._episode)

    def step(self, action: np.int64 | int) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Attempt a joint.

        Raises:
            BadValue: If the action is no joint.
            ResetNeeded: If no trial is under way.
            TrialFault: If the plant or a channel breaks.
        """
        episode = self._episode
        if episode is None or episode.trial is not None:
            raise ResetNeeded("no trial is under way: call reset()")
        if not self.action_space.contains(action):
            raise BadValue("action", action, f"a whole number from 0 to {len(self.settings.study.box.joints) - 1}")
        self.trial = episode.attempt(int(action)) or self.trial
        ending = None if episode.trial is None else episode.trial.ending
        reward = float(ending == "solved") - self.settings.step_cost
        return self._observation(episode), reward, ending == "solved", ending == "budget", self._info(episode)

    def render(self) -> str | NDArray[np.uint8] | NDArray[np.float32] | None:
        """The box now, in the render mode.

        Returns:
            ``"ansi"``: the task and the last report in words. ``"rgb_array"``: the camera's picture, shape (height,
            width, 3). ``"depth_array"``: depth, shape (height, width), metres, 0 where there is no reading.

        Raises:
            UnknownName: If there is no such mode.
            BadValue: If the mode needs a camera and the plant has none. The constructor does not check this, so tools
                can ask every environment for pictures and go on without.
        """
        mode = self.render_mode
        if mode is not None and mode not in _RENDER_MODES:
            raise UnknownName("render mode", mode, _RENDER_MODES)
        if mode is not None and mode not in self.metadata["render_modes"]:
            raise BadValue("render_mode", mode, "ansi, or plant='fast-twin' or 'twin': this one has no camera")
        if mode is None or self._episode is None:
            return None
        if mode == "ansi":
            return self._episode.words()
        frame = self._episode.plant.frame()
        return frame.rgb if mode == "rgb_array" else frame.depth

    def close(self) -> None:
        """Drop the unfinished trial and its plant."""
        if self._episode is not None:
            self._episode.close()
        self._episode = None

    def _observation(self, episode: _Episode) -> Vector | Images:
        heard, settings = episode.heard, self.settings
        if settings.observation != "symbolic":
            return images(heard.percept, settings.observation)
        left = episode.steps_left if settings.steps_left else None
        return vector(heard.task, heard.percept, left, positions=episode.tells_positions)

    def _info(self, episode: _Episode) -> dict[str, Any]:
        """The truth if it was asked for; with pictures also the task, which they do not show."""
        info: dict[str, Any] = {"truth": episode.truth()} if self.settings.truth else {}
        if self.settings.observation != "symbolic":
            task = episode.heard.task
            info |= {"target": task.joints.index(task.target), "labels": "".join(task.joints)}
        return info

    def __getstate__(self) -> dict[str, Any]:
        """Keep an unfinished trial as its actions, so that the environment can be copied."""
        episode = self._episode
        return self.__dict__ | {"_episode": None if episode is None else (episode.key, tuple(episode.actions))}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        if state["_episode"] is not None:
            key, actions = state["_episode"]
            self._episode = None
            self._episode = _Episode(self.settings, key)
            for action in actions:
                self._episode.attempt(action)


def _space(settings: EnvironmentSettings) -> spaces.Space[Any]:
    if settings.observation == "symbolic" or settings.picture_size is None:
        return spaces.MultiDiscrete(list(settings.sizes))
    width, height = settings.picture_size
    size = (height, width)
    rgb = spaces.Box(0, 255, (*size, 3), np.uint8)
    if settings.observation == "rgb":
        return rgb
    return spaces.Dict({"rgb": rgb, "depth": spaces.Box(0.0, FARTHEST, (*size, 1), np.float32)})


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


class _Episode:
    """One trial, held at each decision.

    Attributes:
        key: The trial's place in the study.
        actions: The actions so far.
        heard: The last task and percept.
        plant: The plant.
        trial: The record of the finished trial; None before.
        tells_positions: Whether the first percept tells positions.
    """

    def __init__(self, settings: EnvironmentSettings, key: EpisodeKey) -> None:
        self.key = key
        self.actions: list[int] = []
        self.heard = _Listener()
        self.trial: Trial | None = None
        self._plan: Plan = settings.plan(key.seed, key.repetition, key.trial)
        self._names = Names(self._plan)
        self.plant = WatchedPlant(partial(make_plant, self._plan, self._names))
        self._moved = False
        chain: tuple[Intervention, ...] = (*settings.chain, self.heard)
        self._loop = play(
            self._plan,
            plant=self.plant,
            interventions=chain,
            agent=_Outside(),
            on_step=lambda step: self._note(step.moved),
        )
        self._send(None)
        self.tells_positions = self.heard.percept.positions is not None

    @property
    def steps_left(self) -> int:
        return self._plan.budget - len(self.actions)

    def close(self) -> None:
        """Close the plant."""
        self._loop.close()
        self.plant.close()

    def attempt(self, action: int) -> Trial | None:
        """Run the loop to the next decision. Returns the record if the trial is over."""
        self.actions.append(action)
        return self._send(Decision(joint=self.heard.task.joints[action]))

    def words(self) -> str:
        """The task and the last report."""
        task = self.heard.task
        joints = ", ".join(f"{i} {label}" for i, label in enumerate(task.joints))
        return f"Joints: {joints}. Target: {task.target}. Steps left: {self.steps_left}.\n{self.heard.percept.text}"

    def truth(self) -> dict[str, Any]:
        """True positions in the order of the listing, and whether the last attempt moved its joint."""
        configuration = np.array(self.plant.configuration, dtype=np.int8)
        return {"positions": configuration[list(self._names.order)], "moved": self._moved}

    def _note(self, moved: bool) -> None:
        self._moved = moved

    def _send(self, decision: Decision | None) -> Trial | None:
        try:
            self._loop.send(decision)
        except StopIteration as end:
            self.trial = replace(end.value, channels=end.value.channels[:-1])  # without the listener
            if (error := self.trial.error) is not None:
                self.plant.close()
                fault = PlantFault if error.boundary == "plant" else ChannelFault
                raise fault(error.message) from None
        return self.trial

"""One lockbox as a Gymnasium environment."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.interfaces.gymnasium.held_episode import HeldEpisode
from lockprobe.interfaces.gymnasium.observation import FARTHEST, Images, Vector
from lockprobe.interfaces.gymnasium.plain_episode import PlainBox, PlainEpisode, is_plain
from lockprobe.interfaces.gymnasium.settings import EnvironmentSettings, EpisodeKey, read_episode_key, read_settings
from lockprobe.trial.record import Trial

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
        settings: As in :func:`lockprobe.interfaces.gymnasium.settings.read_settings`. Under plain ones
            (:func:`lockprobe.interfaces.gymnasium.plain_episode.is_plain`) steps do without the trial loop.
    """

    metadata: dict[str, Any] = {"render_modes": list(_RENDER_MODES), "render_fps": 1}  # noqa: RUF012

    def __init__(self, *, render_mode: str | None = None, **settings: Any) -> None:
        self.render_mode = render_mode
        self.settings: EnvironmentSettings = read_settings(settings)
        self.action_space = spaces.Discrete(len(self.settings.study.box.joints))
        self.observation_space = _space(self.settings)
        shown = ("ansi",) if self.settings.picture_size is None else _RENDER_MODES
        self.metadata = self.metadata | {"render_modes": list(shown)}
        self._plain = PlainBox(self.settings) if is_plain(self.settings) else None
        self._next: EpisodeKey | None = None
        self._episode: PlainEpisode | HeldEpisode | None = None
        self._finished: PlainEpisode | Trial | None = None

    @property
    def trial(self) -> Trial | None:
        """The record of the last finished episode, truth and told; None before."""
        if isinstance(self._finished, PlainEpisode):
            self._finished = self._finished.record()
        return self._finished

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
        if self._plain is None:
            self._episode = HeldEpisode(self.settings, key)
        else:
            self._episode = PlainEpisode(self.settings, self._plain, key)
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
            raise BadValue("action", action, f"a whole number from 0 to {len(self.settings.study.box.joints) - 1}")
        episode.attempt(int(action))
        ending = episode.ending
        if ending is not None:
            self._finished = episode.finished
        reward = float(ending == "solved") - self.settings.step_cost
        return episode.observation(), reward, ending == "solved", ending == "budget", episode.info()

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
        assert isinstance(self._episode, HeldEpisode)
        frame = self._episode.frame()
        return frame.rgb if mode == "rgb_array" else frame.depth

    def close(self) -> None:
        """Drop the unfinished trial and its plant."""
        if self._episode is not None:
            self._episode.close()
        self._episode = None


def _space(settings: EnvironmentSettings) -> spaces.Space[Any]:
    if settings.observation == "symbolic" or settings.picture_size is None:
        return spaces.MultiDiscrete(list(settings.sizes))
    width, height = settings.picture_size
    size = (height, width)
    rgb = spaces.Box(0, 255, (*size, 3), np.uint8)
    if settings.observation == "rgb":
        return rgb
    return spaces.Dict({"rgb": rgb, "depth": spaces.Box(0.0, FARTHEST, (*size, 1), np.float32)})

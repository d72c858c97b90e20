"""One lockbox as a Gymnasium environment."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe.interfaces.gymnasium.episode import HeldEpisode, Images, PlainEpisode
from lockprobe.interfaces.gymnasium.settings import EnvironmentSettings, EpisodeKey, Vector, read_settings
from lockprobe.trial.record import Trial


class LockboxEnv(gymnasium.Env[Vector | Images, np.int64]):
    """A box, one joint per step, until the target moves or the budget is spent.

    The observation holds the agent's reports or pictures (:mod:`lockprobe.interfaces.gymnasium.settings`). An action is
    the index of a joint in the listing. The reward is 1 when the target really moves, less ``step_cost`` at every step.
    ``terminated`` means that the target really moved, ``truncated`` that the budget was spent before. The k-th episode
    after ``reset(seed=s)`` has the same luck as trial k of repetition 1 of a study with seed ``s``.

    Args:
        render_mode: ``"ansi"`` or None; with a camera also ``"rgb_array"``, independent of the observation.
        settings: As in :func:`lockprobe.interfaces.gymnasium.settings.read_settings`.
    """

    metadata: dict[str, Any] = {"render_modes": ["ansi", "rgb_array"], "render_fps": 1}  # noqa: RUF012

    def __init__(self, *, render_mode: str | None = None, **settings: Any) -> None:
        self.render_mode = render_mode
        self.settings: EnvironmentSettings = read_settings(settings)
        self.action_space = spaces.Discrete(len(self.settings.study.box.joints))
        self.observation_space = self.settings.space
        if self.settings.picture_size is None:
            self.metadata = self.metadata | {"render_modes": ["ansi"]}
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
            raise BadValue("action", action, f"a whole number from 0 to {len(self.settings.study.box.joints) - 1}")
        episode.attempt(int(action))
        ending = episode.ending
        if ending is not None:
            self._finished = self._key, episode
        reward = float(ending == "solved") - self.settings.step_cost
        return episode.observation(), reward, ending == "solved", ending == "budget", episode.info()

    def render(self) -> str | NDArray[np.uint8] | None:
        """The box now: the task and the last report in words, or the camera's picture, shape (height, width, 3).

        Raises:
            BadValue: If there is no such mode, or it needs a camera and the plant has none. The constructor does not
                check this, so tools can ask every environment for pictures and go on without.
        """
        mode, known = self.render_mode, self.metadata["render_modes"]
        if mode is not None and mode not in known:
            raise BadValue("render_mode", mode, f"{' or '.join(known)}; pictures need plant='fast-twin' or 'twin'")
        episode = self._episode
        if mode is None or episode is None:
            return None
        if isinstance(episode, PlainEpisode):
            episode = HeldEpisode(self.settings, self._key, episode.actions)
        return episode.words() if mode == "ansi" else episode.frame().rgb

    def close(self) -> None:
        """Drop the unfinished trial and its plant."""
        if self._episode is not None:
            self._episode.close()
        self._episode = None

"""Many lockboxes at once in numpy, with the same episodes as single environments."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe.interfaces.gymnasium.observation import BLOCKED, Vector
from lockprobe.interfaces.gymnasium.plain_episode import PlainBox
from lockprobe.interfaces.gymnasium.settings import (
    EnvironmentSettings,
    EpisodeKey,
    read_episode_key,
    read_settings,
    whole,
)
from lockprobe.simulation.kernel import Boxes
from lockprobe.trial.luck import numbers

Flags = NDArray[np.bool_]


class LockboxVectorEnv(VectorEnv[Vector, NDArray[np.integer[Any]], NDArray[Any]]):
    """Independent boxes under the same settings; the default of ``gymnasium.make_vec``.

    Spaces, reward and luck are those of :class:`lockprobe.interfaces.gymnasium.single.LockboxEnv`: environment ``i``
    after ``reset(seed=s)`` is a single environment after ``reset(seed=s + i)``. After the end of an episode, the next
    step begins the next episode and ignores its action (``AutoresetMode.NEXT_STEP``).

    Args:
        num_envs: Number of environments.
        render_mode: None; many boxes have no picture.
        settings: As in :func:`lockprobe.interfaces.gymnasium.settings.read_settings`, plain ones only
            (:func:`lockprobe.interfaces.gymnasium.plain_episode.is_plain`); others need ``vectorization_mode="sync"``.
    """

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(self, num_envs: int = 1, *, render_mode: str | None = None, **settings: Any) -> None:
        if render_mode is not None:
            raise BadValue("render_mode", render_mode, 'None; vectorization_mode="sync" renders')
        self.num_envs = whole("num_envs", num_envs)
        self.settings: EnvironmentSettings = read_settings(settings)
        self._boxes = _Boxes(self.settings, self.num_envs)
        self.single_action_space = spaces.Discrete(len(self.settings.study.box.joints))
        self.single_observation_space = spaces.MultiDiscrete(list(self.settings.sizes))
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self._next: list[EpisodeKey] = []

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Vector, dict[str, Any]]:
        """Begin the next trial in every environment.

        Args:
            seed: A study seed for each environment, or the first of consecutive seeds; None continues with the next
                trials.
            options: ``repetition`` and ``trial`` as in the single environment, and ``reset_mask``, shape (num_envs,):
                the environments to reset.

        Raises:
            UserMistake: If an option is unknown, or the number of seeds is wrong.
        """
        super().reset(seed=seed if isinstance(seed, int) else None)
        asked = dict(options or {})
        chosen = self._chosen(asked.pop("reset_mask", None))
        seeds = list(self._seeds(seed))
        if not self._next:
            unknown = self.np_random.integers(2**31, size=self.num_envs).tolist()
            self._next = [EpisodeKey(seed=own) for own in unknown]
        for i in np.flatnonzero(chosen).tolist():
            own = seeds[i]
            self._next[i] = read_episode_key(self._next[i] if own is None else EpisodeKey(seed=own), asked)
        self._begin(chosen)
        return self._boxes.observation(), self._info()

    def step(
        self, actions: NDArray[np.integer[Any]]
    ) -> tuple[Vector, NDArray[np.float64], Flags, Flags, dict[str, Any]]:
        """Attempt one joint in each environment, or begin the next trial where the last one has ended.

        Raises:
            BadValue: If an action is no joint, or the number of actions is wrong.
            ResetNeeded: If no trial is under way.
        """
        if not self._next:
            raise ResetNeeded("no trial is under way: call reset()")
        joints, last = np.asarray(actions), len(self.settings.study.box.joints) - 1
        integers = joints.shape == (self.num_envs,) and np.issubdtype(joints.dtype, np.integer)
        if not integers or joints.min() < 0 or joints.max() > last:
            raise BadValue("actions", actions, f"{self.num_envs} whole numbers from 0 to {last}")
        boxes, resting = self._boxes, self._boxes.over
        solved = boxes.attempt(joints.astype(np.int64, copy=False)) & ~resting
        truncated = (boxes.taken >= self.settings.study.max_steps) & ~solved & ~resting
        rewards = np.where(resting, 0.0, solved - self.settings.step_cost)
        if resting.any():
            self._begin(resting)
        boxes.over = solved | truncated
        return boxes.observation(), rewards, solved, truncated, self._info()

    def _begin(self, chosen: Flags) -> None:
        rows = np.flatnonzero(chosen)
        self._boxes.begin(rows, [self._next[i] for i in rows.tolist()])
        for i in rows.tolist():
            self._next[i] = self._next[i].next

    def _chosen(self, mask: object) -> Flags:
        if mask is None:
            return np.ones(self.num_envs, dtype=np.bool_)
        if not (isinstance(mask, np.ndarray) and mask.dtype == np.bool_ and mask.shape == (self.num_envs,)):
            raise BadValue("reset_mask", mask, f"an array of {self.num_envs} truth values")
        if not self._next and not mask.all():
            raise ResetNeeded("no trial is under way: call reset() for all environments first")
        return mask

    def _seeds(self, seed: int | Sequence[int | None] | None) -> Sequence[int | None]:
        if seed is None or isinstance(seed, int):
            return [None if seed is None else seed + i for i in range(self.num_envs)]
        if not isinstance(seed, Sequence) or len(seed) != self.num_envs:
            raise BadValue("seed", seed, f"a whole number, or {self.num_envs} of them")
        return seed

    def _info(self) -> dict[str, Any]:
        if not self.settings.truth:
            return {}
        every = np.ones(self.num_envs, dtype=np.bool_)
        truth = self._boxes.truth()
        return {"truth": truth | {f"_{name}": every.copy() for name in truth}, "_truth": every}


class _Boxes:
    """The state of all boxes, joints in the order of the listing.

    Attributes:
        taken: Steps taken in each trial, shape (num_envs,).
        over: Which trials have ended, shape (num_envs,).
    """

    def __init__(self, settings: EnvironmentSettings, count: int) -> None:
        self._settings, self._box = settings, PlainBox(settings)
        space, joints = self._box.space, self._box.space.joints
        self._bits = np.arange(2**joints)[:, None] >> np.arange(joints) & 1
        self._rows = np.arange(count)
        self._orders = np.tile(np.arange(joints), (count, 1))
        self._boxes = Boxes(space.may_move, space.start, self._box.flips, self._orders.copy())
        budget = settings.study.max_steps
        self._luck = [np.zeros((count, budget + 1, flip.numbers(joints))) for flip in self._box.flips]
        self._moved = np.zeros(count, dtype=np.bool_)
        self._seen = np.zeros((count, len(settings.sizes)), dtype=np.int64)
        self.taken = np.zeros(count, dtype=np.int64)
        self.over = np.zeros(count, dtype=np.bool_)

    def begin(self, rows: NDArray[np.int64], keys: Sequence[EpisodeKey]) -> None:
        """Begin trials in the given rows."""
        seed, repetition, trial = np.array(keys, object).reshape(-1, 3).T[..., None]
        steps = np.arange(1, self._settings.study.max_steps + 1)
        luck_of = partial(numbers, self._box.box.name, seed=seed, repetition=repetition, trial=trial, step=steps)
        for luck, (stream, flip) in zip(self._luck, self._box.drawing, strict=True):
            if stream:
                luck[rows, :-1] = luck_of(stream, places=flip.numbers(self._box.space.joints))
        self._orders[rows] = self._box.listings(keys)
        self._boxes.begin(rows, self._orders[rows])
        self._moved[rows] = self.over[rows] = False
        self.taken[rows] = 0
        self._seen[rows, 0] = np.argmax(self._orders[rows] == self._box.space.target, axis=1)
        self._seen[rows, 1:3] = 0

    def attempt(self, actions: NDArray[np.int64]) -> Flags:
        """Attempt a joint in every box; whether it was the target and moved, shape (num_envs,)."""
        drawn = [luck[self._rows, self.taken].T for luck in self._luck]
        joints, self._moved, outcome = self._boxes.attempt(self._rows, actions, drawn)
        self.taken += 1
        self._seen[:, 1] = actions + 1
        if self._settings.tells_outcomes:
            self._seen[:, 2] = BLOCKED + outcome
        solved: Flags = self._moved & (joints == self._box.space.target)
        return solved

    def observation(self) -> Vector:
        """The agents' observations, shape (num_envs, entries)."""
        if self._settings.tells_positions:
            self._seen[:, 3 : 3 + self._bits.shape[1]] = self._bits[self._boxes.told]
        if self._settings.steps_left:
            self._seen[:, -1] = self._settings.study.max_steps - self.taken
        return self._seen.copy()

    def truth(self) -> dict[str, NDArray[Any]]:
        """True positions, shape (num_envs, joints), and whether the last attempt moved its joint, (num_envs,)."""
        positions = self._bits[self._boxes.positions].astype(np.int8)
        return {"positions": positions, "moved": self._moved.copy()}

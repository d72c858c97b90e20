"""Many lockboxes at once on the kernel, with the same episodes as single environments."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.validation import check_whole
from lockprobe.interfaces.gymnasium.environment import BLOCKED, EnvironmentSettings, EpisodeKey, Vector
from lockprobe.simulation.kernel import Boxes
from lockprobe.trial.luck import drawn, keys

Flags = NDArray[np.bool_]


class LockboxVectorEnv(VectorEnv[Vector, NDArray[np.integer[Any]], NDArray[Any]]):
    """Independent boxes under the same settings; the default of ``gymnasium.make_vec``.

    Spaces, reward and luck are those of ``LockboxEnv``: environment ``i`` after ``reset(seed=s)`` is a single one after
    ``reset(seed=s + i)``. After the end of an episode, the next step begins the next episode and ignores its action
    (``AutoresetMode.NEXT_STEP``).

    Args:
        num_envs: Number of environments.
        settings: As of the single environment. Only one flip may act, on reports of a symbolic plant; all else needs
            ``vectorization_mode="sync"``.
    """

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(self, num_envs: int = 1, **settings: Any) -> None:
        check_whole("num_envs", num_envs, 1)
        self.num_envs = num_envs
        self.settings = EnvironmentSettings(settings)
        if (flip := self.settings.flip) is None:
            given = f"{self.settings.study.conditions[0].label} on {self.settings.study.plant}"
            expected = 'one flip alone on a symbolic plant, without pictures; vectorization_mode="sync" plays all else'
            raise BadValue("make_vec", given, expected)
        self._flip, box, joints = flip, self.settings.box, self.settings.box.joints
        self.single_action_space, self.single_observation_space = spaces.Discrete(joints), self.settings.space
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._seeds = list[int]()
        self._repetition, self._trial = np.zeros((2, num_envs), dtype=np.int64)
        self._rows, self._bits = np.arange(num_envs), np.arange(2**joints)[:, None] >> np.arange(joints) & 1
        self._boxes = Boxes(box.may_move, box.start, flip, np.tile(np.arange(joints), (num_envs, 1)))
        self._taken = np.zeros(num_envs, dtype=np.int64)
        self._over = np.zeros(num_envs, dtype=np.bool_)
        self._seen = np.zeros(self.observation_space.shape or (), dtype=np.int64)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Vector, dict[str, Any]]:
        """Begin the next trial in every environment.

        Args:
            seed: A study seed for each environment, or the first of consecutive seeds; None continues with the next
                trials.
            options: ``repetition`` and ``trial`` as in the single environment.

        Raises:
            UserMistake: If an option is unknown, or the number of seeds is wrong.
        """
        super().reset(seed=seed if isinstance(seed, int) else None)
        seeds = (
            seed if isinstance(seed, Sequence) else [None if seed is None else seed + i for i in self._rows.tolist()]
        )
        if len(seeds) != self.num_envs:
            raise BadValue("seed", seed, f"a whole number, or {self.num_envs} of them")
        before = [*map(EpisodeKey, self._seeds, self._repetition.tolist(), (self._trial + 1).tolist())]
        before = before or [*map(EpisodeKey, self.np_random.integers(2**31, size=self.num_envs).tolist())]
        now = [key if own is None else EpisodeKey(own) for own, key in zip(seeds, before, strict=True)]
        self._seeds, self._repetition[:], self._trial[:] = map(
            list, zip(*(key.chosen(options) for key in now), strict=True)
        )
        self._keys = keys(self.settings.study.box.name, f"{self._flip.stream}-0", self._seeds)
        self._begin(self._rows)
        return self._observed(), {}

    def step(
        self, actions: NDArray[np.integer[Any]]
    ) -> tuple[Vector, NDArray[np.float64], Flags, Flags, dict[str, Any]]:
        """Attempt one joint in each environment, or begin the next trial where the last one has ended.

        Raises:
            BadValue: If an action is no joint, or the number of actions is wrong.
            ResetNeeded: If no trial is under way.
        """
        if not self._seeds:
            raise ResetNeeded("no trial is under way: call reset()")
        places, last = np.asarray(actions), self.settings.box.joints - 1
        integers = places.shape == (self.num_envs,) and np.issubdtype(places.dtype, np.integer)
        if not integers or places.min() < 0 or places.max() > last:
            raise BadValue("actions", actions, f"{self.num_envs} whole numbers from 0 to {last}")
        places, resting = places.astype(np.int64, copy=False), self._over
        self._taken += 1
        count = self._flip.numbers(last + 1)
        luck = np.ones((1, count))
        if self._flip.p:
            of = {"repetition": self._repetition, "trial": self._trial, "step": self._taken}
            luck = drawn(self._keys, **of, places=count)
        joints, moved, outcome = self._boxes.attempt(self._rows, places, luck.T)
        self._seen[:, 1] = places + 1
        if self.settings.outcomes:
            self._seen[:, 2] = BLOCKED + outcome
        solved = moved & (joints == self.settings.box.target) & ~resting
        truncated = (self._taken >= self.settings.study.max_steps) & ~solved & ~resting
        if (rows := np.flatnonzero(resting)).size:
            self._trial[rows] += 1
            self._begin(rows)
        self._over = solved | truncated
        return self._observed(), solved.astype(np.float64), solved, truncated, {}

    def _begin(self, rows: NDArray[np.int64]) -> None:
        """Begin trials in the given rows."""
        study, joints = self.settings.study, self.settings.box.joints
        orders = np.broadcast_to(np.arange(joints), (len(rows), joints))
        if (study.shuffle, study.layout) != ("never", "fixed"):
            now = zip(self._repetition[rows].tolist(), self._trial[rows].tolist(), strict=True)
            episodes = (EpisodeKey(self._seeds[row], *one) for row, one in zip(rows.tolist(), now, strict=True))
            orders = np.array([self.settings.listing(self.settings.plan(one)) for one in episodes])
        self._boxes.begin(rows, orders)
        self._over[rows] = False
        self._taken[rows] = 0
        self._seen[rows, 0] = np.argmax(orders == self.settings.box.target, axis=1)
        self._seen[rows, 1:3] = 0

    def _observed(self) -> Vector:
        """The agents' observations, shape (num_envs, entries)."""
        if self.settings.positions:
            self._seen[:, 3:] = self._bits[self._boxes.told]
        return self._seen.copy()

"""Many lockboxes at once in numpy, with the same episodes as single environments."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from lockprobe.boxes.state_space import space_of
from lockprobe.foundation.errors import BadValue
from lockprobe.interfaces.gymnasium.observation import BLOCKED, Vector
from lockprobe.interfaces.gymnasium.settings import (
    EnvironmentSettings,
    EpisodeKey,
    read_episode_key,
    read_settings,
    whole,
)
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.second_draw import survival
from lockprobe.interventions.words import TextChannel
from lockprobe.trial.condition import spec_of
from lockprobe.trial.plan import Names

__all__ = ["LockboxVectorEnv"]

Flags = NDArray[np.bool_]


class LockboxVectorEnv(VectorEnv[Vector, NDArray[np.integer[Any]], NDArray[Any]]):
    """Independent boxes under the same settings; the default of ``gymnasium.make_vec``.

    Spaces, reward and luck are those of :class:`lockprobe.interfaces.gymnasium.single.LockboxEnv`: environment ``i``
    after ``reset(seed=s)`` is a single environment after ``reset(seed=s + i)``. After the end of an episode, the next
    step begins the next episode and ignores its action (``AutoresetMode.NEXT_STEP``).

    Args:
        num_envs: Number of environments.
        render_mode: None; many boxes have no picture.
        settings: As in :func:`lockprobe.interfaces.gymnasium.settings.read_settings`, with the symbolic plant, reports
            and outcome flips only; anything else needs ``vectorization_mode="sync"``.
    """

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(self, num_envs: int = 1, *, render_mode: str | None = None, **settings: Any) -> None:
        if render_mode is not None:
            raise BadValue("render_mode", render_mode, 'None; vectorization_mode="sync" renders')
        self.num_envs = whole("num_envs", num_envs)
        self.settings: EnvironmentSettings = read_settings(settings)
        for what, asked in (("observation", self.settings.observation), ("plant", self.settings.plant)):
            if asked != "symbolic":
                raise BadValue(what, asked, 'symbolic; vectorization_mode="sync" or "async" plays all others')
        self.single_action_space = spaces.Discrete(len(self.settings.study.box.joints))
        self.single_observation_space = spaces.MultiDiscrete(list(self.settings.sizes))
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self._boxes = _Boxes(self.settings, self.num_envs)
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
        solved = boxes.attempt(joints) & ~resting
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
        box, joints = settings.study.box, len(settings.study.box.joints)
        self._settings = settings
        self._flips = _flips(settings)
        self._may_move = space_of(box).may_move
        self._initial = np.array(box.initial, dtype=np.bool_)
        self._start = int(self._initial @ (1 << np.arange(joints)))
        self._tells_positions, self._tells_outcomes = settings.tells_positions, settings.tells_outcomes
        self._is_drawn = settings.study.shuffle != "never" or settings.study.layout != "fixed"
        self._rows = np.arange(count)
        self._listing = np.tile(np.arange(joints), (count, 1))
        self._code = np.full(count, self._start)
        self._positions = np.tile(self._initial, (count, 1))
        self._told = self._positions.copy()
        self._moved = np.zeros(count, dtype=np.bool_)
        self._luck = np.zeros((len(self._flips), count, settings.study.max_steps + 1))
        self._seen = np.zeros((count, len(settings.sizes)), dtype=np.int64)
        self._seen[:, 0] = box.target_index
        self.taken = np.zeros(count, dtype=np.int64)
        self.over = np.zeros(count, dtype=np.bool_)

    def begin(self, rows: NDArray[np.int64], keys: Sequence[EpisodeKey]) -> None:
        """Begin trials in the given rows."""
        settings = self._settings
        drawn = [k for k, flip in enumerate(self._flips) if _heeds_luck(flip)]
        if drawn or self._is_drawn:
            for i, key in zip(rows.tolist(), keys, strict=True):
                plan = settings.plan(key.seed, key.repetition, key.trial)
                for k in drawn:
                    self._luck[k, i, :-1] = plan.stream(f"{OutcomeFlip.stream}-{k}").random(plan.budget)
                if self._is_drawn:
                    panel = [settings.study.box.names.index(name) for name in plan.box.names]
                    self._listing[i] = [panel[joint] for joint in Names(plan).order]
        self._code[rows] = self._start
        self._positions[rows] = self._told[rows] = self._initial[self._listing[rows]]
        self._moved[rows] = self.over[rows] = False
        self.taken[rows] = 0
        self._seen[rows, 0] = np.argmax(self._listing[rows] == settings.study.box.target_index, axis=1)
        self._seen[rows, 1:3] = 0

    def attempt(self, actions: NDArray[np.integer[Any]]) -> Flags:
        """Attempt a joint in every box; whether it was the target and moved, shape (num_envs,)."""
        joints = self._listing[self._rows, actions]
        moved: Flags = self._may_move[self._code, joints]
        self._code ^= moved.astype(np.int64) << joints
        self._positions[self._rows, actions] ^= moved
        self._tell(actions, moved)
        self._moved = moved
        self.taken += 1
        solved: Flags = moved & (joints == self._settings.study.box.target_index)
        return solved

    def _tell(self, actions: NDArray[np.integer[Any]], moved: Flags) -> None:
        """Apply :meth:`OutcomeFlip.perceive`, one flip after the other, in all boxes."""
        outcome, positions = moved, self._positions.copy()
        for flip, luck in zip(self._flips, self._luck, strict=True):
            drawn = luck[self._rows, self.taken]
            flipped = drawn < flip.p
            if flip.part != "outcome":
                attempted = positions[self._rows, actions] ^ flipped
                if flip.inverts == "outcome":
                    attempted = self._told[self._rows, actions] ^ outcome ^ flipped
                positions = self._others_told(flip, drawn, positions)
                positions[self._rows, actions] = attempted
            if flip.part != "position":
                outcome = outcome ^ flipped
        self._told = positions
        self._seen[:, 1] = actions + 1
        if self._tells_outcomes:
            self._seen[:, 2] = BLOCKED + outcome

    def _others_told(self, flip: OutcomeFlip, drawn: NDArray[np.float64], positions: Flags) -> Flags:
        """The positions of all joints as they are told where they are not attempted, shape (num_envs, joints)."""
        if flip.keep == 1:
            return self._told.copy()
        if not flip.keep and flip.others != "noisy":
            return positions
        numbers = np.stack([survival(drawn, place) for place in range(positions.shape[1])], axis=1)
        if flip.others == "noisy":
            return positions ^ (numbers < flip.p)
        return np.where(numbers < flip.keep, self._told, positions)

    def observation(self) -> Vector:
        """The agents' observations, shape (num_envs, entries)."""
        joints = self._told.shape[1]
        if self._tells_positions:
            self._seen[:, 3 : 3 + joints] = self._told
        if self._settings.steps_left:
            self._seen[:, -1] = self._settings.study.max_steps - self.taken
        return self._seen.copy()

    def truth(self) -> dict[str, NDArray[Any]]:
        """True positions, shape (num_envs, joints), and whether the last attempt moved its joint, (num_envs,)."""
        return {"positions": self._positions.astype(np.int8), "moved": self._moved.copy()}


def _heeds_luck(flip: OutcomeFlip) -> bool:
    """Whether the numbers that a flip draws decide anything."""
    return 0 < flip.p < 1 or 0 < flip.keep < 1


def _flips(settings: EnvironmentSettings) -> list[OutcomeFlip]:
    """The flips of the condition, in order."""
    flips: list[OutcomeFlip] = []
    for one in settings.chain:
        if isinstance(one, OutcomeFlip) and one == one.at_rate(one.p):
            flips.append(one)
        elif not isinstance(one, TextChannel):
            expected = "a flip of p, inverts, others, keep and part alone"
            raise BadValue("condition", spec_of(one), f'{expected}; vectorization_mode="sync" plays any other')
    return flips

"""Plain boxes, on whose reports nothing but flips acts, and an episode of one without the trial loop.

The loop plays every other condition, and writes the record when it is asked for.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.state_space import space_of
from lockprobe.foundation.errors import BadValue
from lockprobe.interfaces.gymnasium.held_episode import held
from lockprobe.interfaces.gymnasium.observation import BLOCKED, Vector, laid_out
from lockprobe.interfaces.gymnasium.settings import EnvironmentSettings, EpisodeKey
from lockprobe.interventions.flip import OutcomeFlip, told_by
from lockprobe.interventions.words import TextChannel
from lockprobe.trial.condition import spec_of
from lockprobe.trial.luck import numbers
from lockprobe.trial.plan import Names, Plan, drawn_orders
from lockprobe.trial.protocols import Intervention
from lockprobe.trial.record import Ending, Trial


def is_plain(settings: EnvironmentSettings) -> bool:
    """Whether the plant is symbolic, reports are told, and nothing but flips of all attempts alike acts on them."""
    return (settings.observation, settings.plant) == ("symbolic", "symbolic") and all(map(_is_plain, settings.chain))


def _is_plain(one: Intervention) -> bool:
    """Whether it is such a flip, or writes the report."""
    return type(one) is TextChannel or (type(one) is OutcomeFlip and one == one.at_rate(one.p))


class PlainBox:
    """The box of plain settings and the flips that act on its reports.

    Attributes:
        box: The box of the study.
        space: Its configurations.
        flips: The flips, in the order in which they act.
        drawing: The same, each with the name of its random stream; empty if its numbers decide nothing.

    Raises:
        BadValue: If the settings are not plain.
    """

    def __init__(self, settings: EnvironmentSettings) -> None:
        for what, asked in (("observation", settings.observation), ("plant", settings.plant)):
            if asked != "symbolic":
                raise BadValue(what, asked, 'symbolic; vectorization_mode="sync" or "async" plays all others')
        for one in settings.chain:
            if not _is_plain(one):
                expected = "a flip of p, inverts, others, keep and part alone"
                raise BadValue("condition", spec_of(one), f'{expected}; vectorization_mode="sync" plays any other')
        self.box = settings.study.box
        self.space = space_of(self.box)
        self.flips = [one for one in settings.chain if isinstance(one, OutcomeFlip)]
        self.drawing = [
            (f"{flip.stream}-{k}" if 0 < flip.p < 1 or 0 < flip.keep < 1 else "", flip)
            for k, flip in enumerate(self.flips)
        ]
        self._settings = settings

    def listings(self, keys: Sequence[EpisodeKey]) -> NDArray[np.int64]:
        """The joints of the study's box, by index, as trials list them, shape (trials, joints)."""
        study, joints = self._settings.study, self.space.joints
        if (study.shuffle, study.layout) == ("never", "fixed"):
            return np.tile(np.arange(joints), (len(keys), 1))
        if (study.shuffle, study.layout) == ("trial", "fixed"):
            seed, repetition, trial = np.array(keys, object).reshape(-1, 3).T
            luck = partial(numbers, self.box.name, seed=seed, repetition=repetition, trial=trial)
            return drawn_orders(luck("labels", places=2 * joints))[1]
        return np.array([self.listing(self._settings.plan(*key)) for key in keys])

    def listing(self, plan: Plan) -> list[int]:
        """The same of one trial."""
        return [self.box.names.index(plan.box.names[at]) for at in Names(plan).order]


class PlainEpisode:
    """One trial of a plain box, as :class:`lockprobe.interfaces.gymnasium.held_episode.HeldEpisode` plays it.

    Attributes:
        ending: How the trial ended; None before.
    """

    def __init__(self, settings: EnvironmentSettings, box: PlainBox, key: EpisodeKey) -> None:
        self.ending: Ending | None = None
        self._settings, self._box, self._key = settings, box, key
        self._actions: list[int] = []
        self._budget = settings.study.max_steps
        plan = settings.plan(*key)
        self._luck = [(plan.luck.stream(stream) if stream else None, flip) for stream, flip in box.drawing]
        self._listing = box.listing(plan)
        self._target = self._listing.index(box.space.target)
        self._configuration = box.space.start
        self._positions = self._told = sum(
            1 << place for place, joint in enumerate(self._listing) if box.box.initial[joint]
        )
        self._moved = False
        self._outcome = 0

    def attempt(self, action: int) -> None:
        """Attempt the joint at this place of the listing."""
        joint, joints = self._listing[action], len(self._listing)
        self._moved = bool(self._box.space.may_move[self._configuration, joint])
        self._actions.append(action)
        taken = len(self._actions)
        drawn = [
            [0.0] * flip.numbers(joints) if stream is None else stream.at(taken).random(flip.numbers(joints)).tolist()
            for stream, flip in self._luck
        ]
        bit = 1 << action
        self._configuration ^= self._moved << joint
        self._positions ^= self._moved * bit
        outcome, self._told = told_by(self._box.flips, self._positions, self._told, bit, self._moved, drawn)
        self._outcome = BLOCKED + outcome
        if self._moved and action == self._target:
            self.ending = "solved"
        elif taken == self._budget:
            self.ending = "budget"

    def observation(self) -> Vector:
        """The report as a vector."""
        settings, taken = self._settings, len(self._actions)
        return laid_out(
            self._target,
            self._actions[-1] + 1 if taken else 0,
            self._outcome if settings.tells_outcomes else 0,
            self._bits(self._told) if settings.tells_positions else (),
            self._budget - taken if settings.steps_left else None,
        )

    def info(self) -> dict[str, Any]:
        """The truth if it was asked for."""
        if not self._settings.truth:
            return {}
        return {"truth": {"positions": np.array(self._bits(self._positions), dtype=np.int8), "moved": self._moved}}

    def _bits(self, positions: int) -> list[int]:
        return [positions >> place & 1 for place in range(len(self._listing))]

    def words(self) -> str:
        """The task and the last report."""
        return held(self._settings, self._key, self._actions).words()

    @property
    def finished(self) -> PlainEpisode:
        """Itself, from which the record is made if it is asked for."""
        return self

    def record(self) -> Trial:
        """The record of the finished trial: the loop plays it again."""
        trial = held(self._settings, self._key, self._actions).finished
        assert trial is not None
        return trial

    def close(self) -> None:
        """Do nothing: a plain box holds nothing open."""

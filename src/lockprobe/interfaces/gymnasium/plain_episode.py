"""An episode of a plain box without the trial loop: the loop writes the record when it is asked for."""

from __future__ import annotations

from typing import Any

import numpy as np

from lockprobe.foundation.seeds import trial_stream
from lockprobe.interfaces.gymnasium.held_episode import held
from lockprobe.interfaces.gymnasium.observation import BLOCKED, Vector, laid_out
from lockprobe.interfaces.gymnasium.plain_rules import PlainRules, PlainState
from lockprobe.interfaces.gymnasium.settings import EnvironmentSettings, EpisodeKey
from lockprobe.trial.record import Ending, Trial


class PlainEpisode:
    """One trial of a plain box, as :class:`lockprobe.interfaces.gymnasium.held_episode.HeldEpisode` plays it.

    Attributes:
        ending: How the trial ended; None before.
    """

    def __init__(self, settings: EnvironmentSettings, rules: PlainRules, key: EpisodeKey) -> None:
        self.ending: Ending | None = None
        self._settings, self._rules, self._key = settings, rules, key
        self._actions: list[int] = []
        self._budget = settings.study.max_steps
        self._luck = [trial_stream(*key, name).random(self._budget).tolist() for name in rules.streams]
        self._listing = rules.listing(key)
        self._target = self._listing.index(rules.box.target_index)
        positions = rules.listed(self._listing)
        self._state = PlainState(rules.start, positions, positions)
        self._moved = False
        self._outcome = 0

    def attempt(self, action: int) -> None:
        """Attempt the joint at this place of the listing."""
        rules, state, taken, joint = self._rules, self._state, len(self._actions), self._listing[action]
        self._moved = rules.may_move[state.configuration][joint]
        drawn = [numbers[taken] for numbers in self._luck]
        self._outcome = BLOCKED + rules.attempt(state, joint, action, moved=self._moved, drawn=drawn)
        self._actions.append(action)
        if self._moved and action == self._target:
            self.ending = "solved"
        elif taken + 1 == self._budget:
            self.ending = "budget"

    def observation(self) -> Vector:
        """The report as a vector."""
        settings, rules, taken = self._settings, self._rules, len(self._actions)
        return laid_out(
            self._target,
            self._actions[-1] + 1 if taken else 0,
            self._outcome if rules.tells_outcomes else 0,
            rules.bits[self._state.told] if rules.tells_positions else (),
            self._budget - taken if settings.steps_left else None,
        )

    def info(self) -> dict[str, Any]:
        """The truth if it was asked for."""
        if not self._settings.truth:
            return {}
        positions = np.array(self._rules.bits[self._state.positions], dtype=np.int8)
        return {"truth": {"positions": positions, "moved": self._moved}}

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
        """Do nothing: the rules hold nothing open."""

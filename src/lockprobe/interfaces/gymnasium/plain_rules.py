"""Plain boxes, on whose reports nothing but flips acts: what an attempt does and what is told of it, in whole numbers.

Positions are a number whose bit i is the position of the joint at place i of the listing. The same lines play one box,
with numbers, and many at once, with arrays that hold a number for each box. What they tell is what the trial loop
tells, which also plays every other condition and writes the record.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from lockprobe.boxes.state_space import space_of
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.many_streams import generators
from lockprobe.interfaces.gymnasium.settings import EnvironmentSettings, EpisodeKey
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.second_draw import survival
from lockprobe.interventions.words import TextChannel
from lockprobe.trial.condition import spec_of
from lockprobe.trial.plan import Names, drawn_orders
from lockprobe.trial.protocols import Intervention


def is_plain(settings: EnvironmentSettings) -> bool:
    """Whether the plant is symbolic, reports are told, and nothing but flips of all attempts alike acts on them."""
    return (settings.observation, settings.plant) == ("symbolic", "symbolic") and all(map(_is_plain, settings.chain))


def _is_plain(one: Intervention) -> bool:
    """Whether it is such a flip, or writes the report."""
    return type(one) is TextChannel or (type(one) is OutcomeFlip and one == one.at_rate(one.p))


@dataclass(slots=True)
class PlainState:
    """One box, or many: each attribute is one number, or an array with one for each box.

    Attributes:
        configuration: True positions; bit j is joint j of the study's box.
        positions: True positions.
        told: The positions told last.
    """

    configuration: Any
    positions: Any
    told: Any


class PlainRules:
    """The rules under plain settings.

    Attributes:
        box: The box of the study.
        may_move: For every configuration, whether the interlock lets each joint of the study's box move.
        start: The initial configuration.
        bits: For every number the positions that it stands for, 0 or 1, the joint listed first in front.
        tells_positions: Whether reports tell positions.
        tells_outcomes: Whether they tell outcomes.
        same_listing: Whether every trial lists the joints in the order of the study's box.
        streams: The names of the random streams of flips whose numbers decide anything.

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
        space = space_of(self.box)
        self.may_move, self.start = space.may_move.tolist(), space.start
        self.bits = [tuple(number >> i & 1 for i in range(space.joints)) for number in range(2**space.joints)]
        self._order = (settings.study.shuffle, settings.study.layout)
        self.same_listing = self._order == ("never", "fixed")
        self.tells_positions, self.tells_outcomes = settings.tells_positions, settings.tells_outcomes
        self._settings, self._joints = settings, range(space.joints)
        flips = [one for one in settings.chain if isinstance(one, OutcomeFlip)]
        heeding = [k for k, flip in enumerate(flips) if 0 < flip.p < 1 or 0 < flip.keep < 1]
        self._flips = [(flip, heeding.index(k) if k in heeding else None) for k, flip in enumerate(flips)]
        self.streams = [f"{OutcomeFlip.stream}-{k}" for k in heeding]

    def listing(self, key: EpisodeKey) -> Sequence[int]:
        """The joints of the study's box, by index, as a trial lists them."""
        if self.same_listing:
            return self._joints
        plan = self._settings.plan(*key)
        return [self.box.names.index(plan.box.names[joint]) for joint in Names(plan).order]

    def listings(self, keys: Sequence[EpisodeKey]) -> Sequence[Sequence[int]]:
        """The same for many trials; where only the list is drawn, without their plans."""
        if self._order != ("trial", "fixed"):
            return [self.listing(key) for key in keys]
        return [drawn_orders(len(self._joints), rng)[1] for rng in generators(keys, "labels")]

    def listed(self, listing: Sequence[int]) -> int:
        """The initial positions under a listing."""
        return sum(1 << place for place, joint in enumerate(listing) if self.box.initial[joint])

    def attempt(self, state: PlainState, joint: Any, place: Any, *, moved: Any, drawn: Sequence[Any]) -> Any:
        """Attempt a joint: changes the state.

        Args:
            state: The box.
            joint: The joint, by its index in the study's box.
            place: Its place in the listing.
            moved: Whether the interlock lets it move.
            drawn: The next number of each of :attr:`streams`, [0, 1).

        Returns:
            Whether it is said to have moved.
        """
        state.configuration = state.configuration ^ (moved << joint)
        state.positions = state.positions ^ (moved << place)
        outcome, told, attempted = moved, state.positions, 1 << place
        for flip, stream in self._flips:
            number = 0.0 if stream is None else drawn[stream]
            flipped = number < flip.p
            if flip.part != "outcome":
                if flip.inverts == "outcome":
                    shown = state.told ^ ((outcome ^ flipped) << place)
                else:
                    shown = told ^ (flipped << place)
                told = (shown & attempted) | (self._others(flip, number, told, state.told) & ~attempted)
            if flip.part != "position":
                outcome = outcome ^ flipped
        state.told = told
        return outcome

    def _others(self, flip: OutcomeFlip, number: Any, told: Any, before: Any) -> Any:
        """The positions that a flip tells of joints that are not attempted."""
        if flip.keep == 1:
            return before
        if flip.others == "noisy":
            return told ^ self._survivors(number, flip.p)
        if not flip.keep:
            return told
        kept = self._survivors(number, flip.keep)
        return (before & kept) | (told & ~kept)

    def _survivors(self, number: Any, below: float) -> Any:
        """The joints whose second number is below a rate."""
        survivors = 0
        for place in self._joints:
            survivors = survivors | ((survival(number, place) < below) << place)
        return survivors

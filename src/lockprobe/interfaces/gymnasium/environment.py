"""One lockbox as a Gymnasium environment, the trials that its episodes are, and what an agent outside observes of them.

An episode is a trial of a study with one condition: the trial loop, held at each decision (:class:`HeldEpisode`). Where
nothing but flips acts on the reports of a symbolic plant, a :class:`PlainEpisode` says the same a few times faster.

Reports are a vector of whole numbers. With ``n`` joints, numbered as they are listed to the agent, it holds:

=========================  ============  ==================================================================
entry                      values        meaning
=========================  ============  ==================================================================
0                          0 to n - 1    the target joint
1                          0 to n        the joint just attempted, plus one; 0 before the first attempt
2                          0, 1, 2       nothing reported, reported as blocked, reported as moved; always 0 if reports
                                         tell only positions (``symbolic?tell=state``)
3 to n + 2                 0, 1 (, 2)    reported position of each joint, 2 if a report is missing; absent if no report
                                         tells positions
=========================  ============  ==================================================================

Pictures are arrays of colours, or ``{"rgb": colours, "depth": metres}``.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from types import coroutine
from typing import Any, ClassVar, NamedTuple

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from lockprobe.boxes.solve import space_of
from lockprobe.foundation.errors import BadValue, ChannelFault, PlantFault, UnknownName
from lockprobe.foundation.spec import spec_name
from lockprobe.foundation.validation import check_whole
from lockprobe.interventions.conditions import says_modality
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.modality import interventions_for
from lockprobe.interventions.words import TextChannel
from lockprobe.plants.catalogue import plant_of, resolve_plant
from lockprobe.simulation.kernel import flip_alone
from lockprobe.studies.options.studyfile import trial_study
from lockprobe.trial.condition import Condition, place_of, spec_of
from lockprobe.trial.loop import play
from lockprobe.trial.pictures.frame import from_png
from lockprobe.trial.plan import Plan
from lockprobe.trial.protocols import Channel, InterventionTraits
from lockprobe.trial.record import Decision, Ending, Fact, Moment, Percept, Situation, Task, Trial

Vector = NDArray[np.int64]
Images = NDArray[np.uint8] | dict[str, NDArray[np.uint8] | NDArray[np.float32]]
"""Colours, shape (height, width, 3), or with metres of depth, shape (height, width, 1), 0 where there is no reading."""

BLOCKED = 1
"""Entry 2 of the vector; one more if the joint is reported as moved."""

_UNTOLD = 2
"""Position of a joint if a report is missing."""

_FARTHEST = 4.0
"""Largest depth with a reading, metres."""

_KNOWN = ("box", "p", "flip", "condition", "modality", "plant", "layout", "shuffle", "max_steps")


class EpisodeKey(NamedTuple):
    """The trial of a study that an episode plays: the seed of the study, and repetition and trial from 1."""

    seed: int
    repetition: int = 1
    trial: int = 1

    def chosen(self, options: Mapping[str, Any] | None) -> EpisodeKey:
        """The trial of ``reset(options={"repetition": r, "trial": t})``; each option may be left out."""
        for name, value in (options or {}).items():
            if name not in ("repetition", "trial"):
                raise UnknownName("option of reset", str(name), ("repetition", "trial"))
            check_whole(name, value, 1)
        return self._replace(**{name: int(value) for name, value in (options or {}).items()})


class EnvironmentSettings:
    """The trials that episodes play, and their observations.

    Args:
        given: Of the options of a trial ``box``, ``p``, ``flip``, ``condition``, ``modality``, ``plant``, ``layout``,
            ``shuffle`` and ``max_steps``; here ``shuffle`` defaults to ``never``, and ``modality`` to ``symbolic``,
            which tells outcomes too.

    Attributes:
        study: A study with one condition. Its seed is not used.
        chain: The interventions in order.
        flip: The flip of all attempts alike, if nothing else acts on the reports of a symbolic plant; else None. With
            it the rules and the law of false reports are the whole trial, and the trial loop is not needed.
        shown: ``symbolic``, ``rgb`` or ``rgbd``.
        outcomes, positions: Whether reports tell them.
        box: The configurations of the box.
        space: The space of observations.

    Raises:
        UserMistake: If a name does not exist, a value is out of range, or two options conflict.
    """

    def __init__(self, given: Mapping[str, Any]) -> None:
        for name in given:
            if name not in _KNOWN:
                raise UnknownName("setting of the environment", name, _KNOWN)
        asked = {name: value for name, value in given.items() if value is not None}
        condition = asked.get("condition")
        if not (isinstance(condition, Condition) or (isinstance(condition, str) and says_modality(condition))):
            asked = {"modality": "symbolic"} | asked
        self.study = trial_study("gymnasium", name="lockbox", **({"shuffle": "never"} | asked))
        self.box, joints = space_of(self.study.box), len(self.study.box.joints)
        (plant,) = self.study.plants  # with what the condition changes of it
        source = resolve_plant(plant)
        source.check(self.study.box)
        self.chain = interventions_for(self.study.conditions[0])
        for one in self.chain:
            if place_of(type(one)) not in ("told", "done"):
                expected = "interventions on reports or actions: an observation holds no words and no memory"
                raise BadValue("condition", spec_of(one), expected)
        self.shown = spec_name(self.study.conditions[0].modality)
        self.flip = flip_alone(self.chain, plant)
        words = [one for one in self.chain if type(one) is TextChannel]
        self.outcomes = all(one.tell != "state" for one in words)
        self.positions = all(one.tell != "outcome" for one in words)
        self.space: spaces.Space[Any]
        if self.shown == "symbolic":
            gaps = any(isinstance(one, Channel) and not InterventionTraits.of(one).always_tells for one in self.chain)
            told = [2 + gaps] * joints * self.positions
            self.space = spaces.MultiDiscrete([joints, joints + 1, 3 if self.outcomes else 1, *told])
            return
        if source.picture_size is None:
            raise BadValue("modality", self.shown, f"symbolic with {plant}, whose pictures have no size known before")
        width, height = source.picture_size
        self.space = rgb = spaces.Box(0, 255, (height, width, 3), np.uint8)
        if self.shown == "rgbd":
            depth = spaces.Box(0.0, _FARTHEST, (height, width, 1), np.float32)
            self.space = spaces.Dict({"rgb": rgb, "depth": depth})

    def plan(self, key: EpisodeKey) -> Plan:
        """The trial of an episode."""
        return self.study.plan("gymnasium", self.study.conditions[0], key.repetition, key.trial, key.seed)

    def listing(self, plan: Plan) -> list[int]:
        """The joints of the study's box, by index, as a trial lists them."""
        return [self.study.box.names.index(plan.box.names[at]) for at in plan.names.order]


class PlainEpisode:
    """One trial in which nothing but flips acts, by the rules and the law of false reports.

    Attributes:
        ending: How the trial ended; None before.
        actions: The joints attempted so far, by their number in the listing.
    """

    def __init__(self, settings: EnvironmentSettings, key: EpisodeKey) -> None:
        self.ending: Ending | None = None
        self.actions: list[int] = []
        self.key, self._settings, plan = key, settings, settings.plan(key)
        self._flip, self._luck = settings.flip or OutcomeFlip(), plan.luck
        self._listing = settings.listing(plan)
        self._target, self._configuration = self._listing.index(settings.box.target), settings.box.start
        self._positions = sum((settings.box.start >> joint & 1) << i for i, joint in enumerate(self._listing))
        self._told, self._outcome = self._positions, 0

    def attempt(self, action: int) -> None:
        """Attempt the joint at this place of the listing."""
        joint, bit = self._listing[action], 1 << action
        self.actions.append(action)
        taken = len(self.actions)
        drawn = [1.0]
        if (flip := self._flip).p:
            drawn = self._luck.at(f"{flip.stream}-0", taken).random(flip.numbers(len(self._listing))).tolist()
        moved = bool(self._settings.box.may_move[self._configuration, joint])
        self._configuration ^= moved << joint
        self._positions ^= moved * bit
        outcome, self._told = flip.report(self._positions, self._told, bit, moved, drawn)
        self._outcome = BLOCKED + outcome if self._settings.outcomes else 0
        if moved and action == self._target:
            self.ending = "solved"
        elif taken == self._settings.study.max_steps:
            self.ending = "budget"

    def observation(self) -> tuple[Vector, dict[str, Any]]:
        """The report as a vector, which says it all."""
        attempted = self.actions[-1] + 1 if self.actions else 0
        told = [self._told >> i & 1 for i in range(len(self._listing))] if self._settings.positions else ()
        return np.array((self._target, attempted, self._outcome, *told), dtype=np.int64), {}


class HeldEpisode:
    """One trial of the loop, held at each decision, after the actions given.

    It is the agent of the loop, whose decisions come from outside, and the last channel, which keeps every report and
    passes it on: an agent is not asked again after the last one.

    Attributes:
        ending, actions: As of a :class:`PlainEpisode`.
        finished: The record of the finished trial; None before.

    Raises:
        TrialFault: If the plant or a channel breaks.
    """

    facts: ClassVar[Mapping[str, Fact]] = {}

    def __init__(self, settings: EnvironmentSettings, key: EpisodeKey, actions: Sequence[int] = ()) -> None:
        self.ending: Ending | None = None
        self.actions: list[int] = []
        self.finished: Trial | None = None
        self._settings, self._key, plan = settings, key, settings.plan(key)
        self._loop = play(plan, plant=partial(plant_of, plan), interventions=(*settings.chain, self), agent=self)
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

    def attempt(self, action: int) -> None:
        """Run the loop to the next decision."""
        self.actions.append(action)
        self._send(Decision(joint=self._task.joints[action]))

    def observation(self) -> tuple[Vector | Images, dict[str, Any]]:
        """The report as a vector; or the pictures, with the task, which they do not show."""
        settings, task, percept = self._settings, self._task, self._percept
        target = task.joints.index(task.target)
        if settings.shown == "symbolic":
            attempted = 0 if percept.joint is None else task.joints.index(percept.joint) + 1
            told = settings.outcomes and percept.outcome is not None
            outcome = BLOCKED + (percept.outcome == "moved") if told else 0
            positions = (percept.positions or (_UNTOLD,) * len(task.joints)) if settings.positions else ()
            return np.array((target, attempted, outcome, *positions), dtype=np.int64), {}
        seen = {picture.kind: from_png(picture.png) for picture in percept.pictures}
        for kind in ("rgb", "depth16")[: 1 + (settings.shown == "rgbd")]:
            if kind not in seen:
                raise ChannelFault(f"no picture of the kind {kind} reached the agent: a channel removed it")
        rgb, info = seen["rgb"].astype(np.uint8, copy=False), {"target": target, "labels": "".join(task.joints)}
        if settings.shown == "rgb":
            return rgb, info
        metres = seen["depth16"].astype(np.float32)[..., None] / np.float32(1000)
        return {"rgb": rgb, "depth": np.where(metres <= _FARTHEST, metres, np.float32(0))}, info

    def close(self) -> None:
        """End the loop and close the plant."""
        self._loop.close()

    def __reduce__(self) -> tuple[Any, ...]:
        """A copy is made of the actions: it plays them again."""
        return HeldEpisode, (self._settings, self._key, tuple(self.actions))

    def _send(self, decision: Decision | None) -> None:
        try:
            self._loop.send(decision)
        except StopIteration as end:
            self.finished = replace(end.value, channels=end.value.channels[:-1])  # without this one
            self.ending = self.finished.ending
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

    The observation holds the agent's reports or pictures. An action is the index of a joint in the listing. The reward
    is 1 when the target really moves. ``terminated`` means that it did, ``truncated`` that the budget was spent before.
    The k-th episode after ``reset(seed=s)`` has the same luck as trial k of repetition 1 of a study with seed ``s``.

    Args:
        settings: As in :class:`EnvironmentSettings`.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012

    def __init__(self, **settings: Any) -> None:
        self.settings = EnvironmentSettings(settings)
        self.action_space = spaces.Discrete(self.settings.box.joints)
        self.observation_space = self.settings.space
        self._next: EpisodeKey | None = None
        self._episode: PlainEpisode | HeldEpisode | None = None
        self._finished: PlainEpisode | HeldEpisode | None = None

    @property
    def trial(self) -> Trial | None:
        """The record of the last finished episode, truth and told; None before."""
        if isinstance(done := self._finished, PlainEpisode):  # the loop plays it again, and records it
            self._finished = done = HeldEpisode(self.settings, done.key, done.actions)
        return None if done is None else done.finished

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
        if seed is not None or begun is None:
            begun = EpisodeKey(int(self.np_random.integers(2**31)) if seed is None else seed)
        begun = begun.chosen(options)
        self.close()
        self._next = begun._replace(trial=begun.trial + 1)
        self._episode = (HeldEpisode if self.settings.flip is None else PlainEpisode)(self.settings, begun)
        return self._episode.observation()

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
        if episode.ending is not None:
            self._finished = episode
        (told, info), solved = episode.observation(), episode.ending == "solved"
        return told, float(solved), solved, episode.ending == "budget", info

    def close(self) -> None:
        """Drop the unfinished trial and its plant."""
        if isinstance(self._episode, HeldEpisode):
            self._episode.close()
        self._episode = None

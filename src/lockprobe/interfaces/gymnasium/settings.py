"""The settings of an environment, and the trial that each episode plays.

Options of a single trial have the same names here and are read by the same code
(:func:`lockprobe.studies.studyfile.trial_study`). A few options exist only here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from lockprobe.foundation.errors import BadValue, Conflict, UnknownName
from lockprobe.foundation.spec import spec_name, split_specs
from lockprobe.interfaces.gymnasium.observation import sizes
from lockprobe.interventions.burst import Burst
from lockprobe.interventions.camera import CameraChannel
from lockprobe.interventions.catalogue import with_words
from lockprobe.interventions.conditions import MODALITIES
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.phantom import Phantom
from lockprobe.interventions.reword import Reword
from lockprobe.interventions.words import TextChannel
from lockprobe.interventions.yoked import Yoked
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.modality import interventions_for, is_pictured
from lockprobe.studies.study import Study
from lockprobe.studies.studyfile import trial_study
from lockprobe.studies.trial_options import TrialOptions
from lockprobe.trial.condition import Condition, place_of, spec_of
from lockprobe.trial.plan import LABELS, Plan
from lockprobe.trial.protocols import Channel, Intervention
from lockprobe.trial.record import Percept, Task

__all__ = ["NOT_HERE", "EnvironmentSettings", "EpisodeKey", "read_episode_key", "read_settings", "whole"]

_OWN: Mapping[str, Any] = {
    "observation": None, "channels": (), "shuffle": "never", "steps_left": False, "step_cost": 0.0, "info": None,
}  # fmt: skip
"""Options that only an environment has, and defaults that differ from those of a study."""

_PLACE = "reset(), which begins the next trial, or reset(options={'repetition': 2, 'trial': 7})"
_ONE = "condition=, p= and modality=: an environment has one condition"

NOT_HERE: Mapping[str, str] = {
    "agent": "no agent: the caller of step() is the agent",
    "assessment": "no assessment: the caller of step() is not asked what happened",
    "hypothesis": "no hypothesis: the caller of step() is not asked how the box works",
    "seed": "reset(seed=...)",
    **dict.fromkeys(("trial", "trials", "strategy_trials", "repetition", "repetitions"), _PLACE),
    "pictures": "no pictures: observations are not stored",
    **dict.fromkeys(("study", "name", "full", "as_paper", "parts", "sweep", "readings"), _ONE),
}
"""Options of a study or a trial that an environment does not have -> the alternative."""

_CHANNELS: Mapping[str, type[OutcomeFlip | TextChannel]] = {"OutcomeFlip": OutcomeFlip, "TextChannel": TextChannel}
"""Channels that a mapping can describe, by their name in the record."""

_ALWAYS_TELL = (OutcomeFlip, Phantom, Burst, Yoked, Reword, TextChannel, CameraChannel)
"""Channels under which no report is missing. Other channels may drop reports."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EnvironmentSettings:
    """The trials that episodes play, and their observations.

    Attributes:
        study: A study with one condition, whose trials the episodes play. Its seed is not used.
        channels: Channels given instead of a condition, in order; the camera's picture passes through them. None if
            the condition holds the interventions.
        steps_left: Whether the observation holds the steps left.
        step_cost: Subtracted from the reward at every step.
        truth: Whether ``info`` holds the truth.
    """

    study: Study
    channels: tuple[Channel, ...] | None
    steps_left: bool
    step_cost: float
    truth: bool

    @property
    def observation(self) -> str:
        """``symbolic``, ``rgb`` or ``rgbd``."""
        return spec_name(self.study.conditions[0].modality)

    @property
    def chain(self) -> tuple[Intervention, ...]:
        """The interventions in order."""
        if self.channels is None:
            return interventions_for(self.study.conditions[0])
        if self.observation == "symbolic":
            return with_words(self.channels, TextChannel())
        return (CameraChannel(depth="turbo" if self.observation == "rgbd" else "none"), *self.channels)

    @property
    def picture_size(self) -> tuple[int, int] | None:
        """Width and height of the plant's pictures, pixels; None without a simulated camera."""
        return resolve_plant(self.study.plant).picture_size

    @property
    def tells_positions(self) -> bool:
        """Whether reports tell positions, or only outcomes."""
        return self._first_look().positions is not None

    @property
    def tells_outcomes(self) -> bool:
        """Whether reports in words tell outcomes."""
        return not self._first_look().states_only

    @property
    def gaps(self) -> bool:
        """Whether a report can be missing."""
        return any(isinstance(one, Channel) and not isinstance(one, _ALWAYS_TELL) for one in self.chain)

    @property
    def sizes(self) -> tuple[int, ...]:
        """The number of values of each entry of an observation."""
        return sizes(
            len(self.study.box.joints),
            positions=self.tells_positions,
            outcomes=self.tells_outcomes,
            gaps=self.gaps,
            budget=self.study.max_steps if self.steps_left else None,
        )

    def _first_look(self) -> Percept:
        """The report in words before the first attempt."""
        task = Task(joints=tuple(LABELS[: len(self.study.box.joints)]), target=LABELS[0], budget=self.study.max_steps)
        percept = Percept(positions=self.study.box.initial)
        for i, channel in enumerate(self.chain):
            if isinstance(channel, Channel):
                percept = channel.perceive(percept, (), task, np.random.default_rng(i))
        return percept

    def plan(self, seed: int, repetition: int, trial: int) -> Plan:
        """A trial of the study with this seed."""
        return self.study.plan("gymnasium", self.study.conditions[0], repetition, trial, seed)


def read_settings(given: Mapping[str, Any]) -> EnvironmentSettings:
    """The settings from keyword arguments of ``gymnasium.make``.

    Args:
        given: All options of :class:`lockprobe.studies.trial_options.TrialOptions` except :data:`NOT_HERE`; here
            ``shuffle`` defaults to ``never``, and ``modality`` to ``symbolic``, which tells outcomes too. Further
            options: ``observation`` (``"symbolic"``, ``"rgb"`` or ``"rgbd"``), short for that modality; ``channels``
            instead of a condition, a list of channels or of mappings such as ``{"channel": "OutcomeFlip", "p": 0.2}``;
            ``steps_left`` (False); ``step_cost`` (0.0); ``info`` (None or ``"truth"``).

    Raises:
        UserMistake: If a name does not exist, a value is out of range, or two options conflict.
    """
    played = [name for name in TrialOptions.__annotations__ if name not in NOT_HERE]
    for name in given:
        if name in NOT_HERE:
            raise BadValue(name, given[name], NOT_HERE[name])
        if name not in (*played, *_OWN):
            raise UnknownName("setting of the environment", name, dict.fromkeys((*played, *_OWN)))
    asked = {**_OWN, **{name: value for name, value in given.items() if value is not None}}
    if asked["observation"] not in (None, *MODALITIES):
        raise UnknownName("observation", str(asked["observation"]), MODALITIES)
    if asked["info"] not in (None, "truth"):
        raise BadValue("info", asked["info"], "None or 'truth'")
    channels = _channels(asked["channels"])
    trial = {name: asked[name] for name in played if name in asked} | _shown(asked, channels)
    settings = EnvironmentSettings(
        study=trial_study(trial, agent="gymnasium", name="lockbox"),
        channels=channels if channels or not _says_condition(asked) else None,
        steps_left=_flag("steps_left", asked["steps_left"]),
        step_cost=_cost(asked["step_cost"]),
        truth=asked["info"] == "truth",
    )
    _can_be_played(settings)
    return settings


def _says_condition(asked: Mapping[str, Any]) -> bool:
    return any(asked.get(name) is not None for name in ("condition", "p", "flip", "modality"))


def _shown(asked: Mapping[str, Any], channels: Sequence[Channel]) -> dict[str, Any]:
    """``observation`` and ``channels`` as options of a trial. Contradictory options are refused."""
    observation = asked["observation"]
    if observation is not None and asked.get("modality") is not None:
        raise Conflict("observation=", "modality=", "both say how the box is shown")
    if not channels and observation is None and (asked.get("modality") or _says_modality(asked.get("condition"))):
        return {}
    if not channels:
        return {"modality": observation or "symbolic"}
    if _says_condition(asked):
        raise Conflict("channels=", "condition=, p=, flip= or modality=", "both say what acts")
    acting = tuple(one for one in channels if not getattr(one, "shows", False))
    return {"condition": Condition(interventions=acting, modality=observation or "symbolic")}


def _says_modality(condition: object) -> bool:
    if isinstance(condition, str):
        return spec_name(split_specs(condition)[-1]) in MODALITIES
    return isinstance(condition, Condition)


def whole(what: str, value: object) -> int:
    """The value, if it is a whole number of at least 1."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 1:
        raise BadValue(what, value, "a whole number of at least 1")
    return int(value)


@dataclass(frozen=True, slots=True, kw_only=True)
class EpisodeKey:
    """The trial of a study that an episode plays.

    Attributes:
        seed: Seed of the study.
        repetition: From 1.
        trial: From 1.
    """

    seed: int
    repetition: int = 1
    trial: int = 1

    @property
    def next(self) -> EpisodeKey:
        """The next trial."""
        return replace(self, trial=self.trial + 1)


def read_episode_key(before: EpisodeKey, options: Mapping[str, Any] | None) -> EpisodeKey:
    """The trial of ``reset(options={"repetition": r, "trial": t})``.

    Args:
        before: The trial without options.
        options: The options; each may be left out.

    Raises:
        UserMistake: If an option is unknown, or a number is below 1.
    """
    for name in options or {}:
        if name not in ("repetition", "trial"):
            raise UnknownName("option of reset", str(name), ("repetition", "trial"))
    return replace(before, **{name: whole(name, value) for name, value in (options or {}).items()})


def _can_be_played(settings: EnvironmentSettings) -> None:
    """Refuses conflicting options, and plants that this machine or box does not allow."""
    resolve_plant(settings.study.plant).check(settings.study.box)
    _check_acting(settings)
    if settings.observation == "symbolic":
        return
    if settings.steps_left:
        raise Conflict("steps_left=True", "pictures", "a picture does not show the steps left")
    for channel in settings.channels or ():
        if isinstance(channel, TextChannel) or (isinstance(channel, OutcomeFlip) and channel.p > 0):
            raise BadValue("channel", channel, "a channel that changes no report: pictures show what happened")


def _check_acting(settings: EnvironmentSettings) -> None:
    """Refuses a condition that no observation can show."""
    if settings.channels is not None:
        return
    for one in settings.chain:
        if place_of(type(one)) not in ("told", "done"):
            expected = "interventions on reports or actions: an observation holds no words and no memory"
            raise BadValue("condition", spec_of(one), expected)
    if settings.gaps and is_pictured(settings.observation):
        label = settings.study.conditions[0].label
        raise BadValue("condition", label, "a condition without missing reports: a picture cannot be left out")


def _flag(what: str, value: object) -> bool:
    if not isinstance(value, bool):
        raise BadValue(what, value, "True or False")
    return value


def _cost(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, float | int) or not 0 <= value < math.inf:
        raise BadValue("step_cost", value, "a number of at least 0")
    return float(value)


def _channels(asked: object) -> tuple[Channel, ...]:
    if not isinstance(asked, Sequence) or isinstance(asked, str):
        raise BadValue("channels", asked, "a list of channels")
    return tuple(map(_channel, asked))


def _channel(asked: object) -> Channel:
    if isinstance(asked, Channel) and not isinstance(asked, type):
        return asked
    if not isinstance(asked, Mapping) or not isinstance(asked.get("channel"), str):
        raise BadValue("channel", asked, 'a channel, or a mapping such as {"channel": "OutcomeFlip", "p": 0.2}')
    if (kind := _CHANNELS.get(asked["channel"])) is None:
        raise UnknownName("channel", asked["channel"], _CHANNELS)
    settings = {str(name): value for name, value in asked.items() if name != "channel"}
    for name in settings:
        if name not in (known := [field.name for field in fields(kind)]):
            raise UnknownName(f"setting of {kind.__name__}", name, known or ["none"])
    try:
        return kind(**settings)
    except TypeError as error:
        raise BadValue("channel", dict(asked), f"values that {kind.__name__} can take ({error})") from None

"""The settings of an environment, and the trial that each episode plays.

Options of a single trial have the same names here and are read by the same code
(:func:`lockprobe.studies.options.studyfile.trial_study`). A few options exist only here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from lockprobe.foundation.errors import BadValue, Conflict, UnknownName
from lockprobe.foundation.spec import spec_name
from lockprobe.interfaces.gymnasium.observation import sizes
from lockprobe.interventions.conditions import MODALITIES, says_modality
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.modality import interventions_for, is_pictured
from lockprobe.studies.options.studyfile import OF_A_TRIAL, trial_study
from lockprobe.studies.study import Study
from lockprobe.trial.condition import Condition, place_of, spec_of
from lockprobe.trial.plan import LABELS, Plan
from lockprobe.trial.protocols import Channel, Intervention, InterventionTraits
from lockprobe.trial.record import Percept, Task

_OWN: Mapping[str, Any] = {
    "observation": None, "shuffle": "never", "steps_left": False, "step_cost": 0.0, "info": None,
}  # fmt: skip
"""Options that only an environment has, and defaults that differ from those of a study."""

_PLACE = "reset(), which begins the next trial, or reset(options={'repetition': 2, 'trial': 7})"
_ONE = "condition=, p= and modality=: an environment has one condition"

NOT_HERE: Mapping[str, str] = {
    "agent": "no agent: the caller of step() is the agent",
    "assessment": "no assessment: the caller of step() is not asked what happened",
    "hypothesis": "no hypothesis: the caller of step() is not asked how the box works",
    "seed": "reset(seed=...)",
    **dict.fromkeys(("trial", "trials", "strategy_trials", "repetition", "repetitions", "until", "most"), _PLACE),
    "pictures": "no pictures: observations are not stored",
    **dict.fromkeys(("study", "name", "boxes", "full", "as_paper", "parts", "sweep", "readings", "contrasts"), _ONE),
}
"""Options of a study or a trial that an environment does not have -> the alternative."""


@dataclass(frozen=True, kw_only=True)
class EnvironmentSettings:
    """The trials that episodes play, and their observations.

    Attributes:
        study: A study with one condition, whose trials the episodes play. Its seed is not used.
        steps_left: Whether the observation holds the steps left.
        step_cost: Subtracted from the reward at every step.
        truth: Whether ``info`` holds the truth.
    """

    study: Study
    steps_left: bool
    step_cost: float
    truth: bool

    @cached_property
    def observation(self) -> str:
        """``symbolic``, ``rgb`` or ``rgbd``."""
        return spec_name(self.study.conditions[0].modality)

    @cached_property
    def plant(self) -> str:
        """The spec of the plant, with what the condition changes of it."""
        (plant,) = self.study.plants
        return plant

    @cached_property
    def chain(self) -> tuple[Intervention, ...]:
        """The interventions in order."""
        return interventions_for(self.study.conditions[0])

    @property
    def picture_size(self) -> tuple[int, int] | None:
        """Width and height of the plant's pictures, pixels; None without a simulated camera."""
        return resolve_plant(self.plant).picture_size

    @cached_property
    def tells_positions(self) -> bool:
        """Whether reports tell positions, or only outcomes."""
        return self._first_look().positions is not None

    @cached_property
    def tells_outcomes(self) -> bool:
        """Whether reports in words tell outcomes."""
        return not self._first_look().states_only

    @property
    def gaps(self) -> bool:
        """Whether a report can be missing."""
        return any(isinstance(one, Channel) and not InterventionTraits.of(one).always_tells for one in self.chain)

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
        given: All options of :data:`lockprobe.studies.options.studyfile.OF_A_TRIAL` except :data:`NOT_HERE`;
            here ``shuffle`` defaults to ``never``, and ``modality`` to ``symbolic``, which tells outcomes too. Further
            options: ``observation`` (``"symbolic"``, ``"rgb"`` or ``"rgbd"``), short for that modality; ``steps_left``
            (False); ``step_cost`` (0.0); ``info`` (None or ``"truth"``).

    Raises:
        UserMistake: If a name does not exist, a value is out of range, or two options conflict.
    """
    played = [name for name in OF_A_TRIAL if name not in NOT_HERE]
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
    trial = {name: asked[name] for name in played if name in asked} | _shown(asked)
    settings = EnvironmentSettings(
        study=trial_study(trial, agent="gymnasium", name="lockbox"),
        steps_left=_flag("steps_left", asked["steps_left"]),
        step_cost=_cost(asked["step_cost"]),
        truth=asked["info"] == "truth",
    )
    _can_be_played(settings)
    return settings


def _shown(asked: Mapping[str, Any]) -> dict[str, Any]:
    """``observation`` as an option of a trial."""
    observation, modality = asked["observation"], asked.get("modality")
    if observation is not None and modality is not None:
        raise Conflict("observation=", "modality=", "both say how the box is shown")
    condition = asked.get("condition")
    said = modality or isinstance(condition, Condition) or (isinstance(condition, str) and says_modality(condition))
    return {} if said and observation is None else {"modality": observation or "symbolic"}


def whole(what: str, value: object) -> int:
    """The value, if it is a whole number of at least 1."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 1:
        raise BadValue(what, value, "a whole number of at least 1")
    return int(value)


class EpisodeKey(NamedTuple):
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
        return EpisodeKey(self.seed, self.repetition, self.trial + 1)


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
    return before._replace(**{name: whole(name, value) for name, value in (options or {}).items()})


def _can_be_played(settings: EnvironmentSettings) -> None:
    """Refuses what no observation can show, and plants that this machine or box does not allow."""
    resolve_plant(settings.plant).check(settings.study.box)
    for one in settings.chain:
        if place_of(type(one)) not in ("told", "done"):
            expected = "interventions on reports or actions: an observation holds no words and no memory"
            raise BadValue("condition", spec_of(one), expected)
    if not is_pictured(settings.observation):
        return
    if settings.gaps:
        label = settings.study.conditions[0].label
        raise BadValue("condition", label, "a condition without missing reports: a picture cannot be left out")
    if settings.steps_left:
        raise Conflict("steps_left=True", "pictures", "a picture does not show the steps left")


def _flag(what: str, value: object) -> bool:
    if not isinstance(value, bool):
        raise BadValue(what, value, "True or False")
    return value


def _cost(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, float | int) or not 0 <= value < math.inf:
        raise BadValue("step_cost", value, "a number of at least 0")
    return float(value)

"""The settings of an environment: a study with one condition, and what an agent outside observes of its trials.

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
last                       0 to budget   steps left; absent unless asked for
=========================  ============  ==================================================================

Pictures are arrays of colours, or ``{"rgb": colours, "depth": metres}``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from lockprobe.boxes.state_space import Space, space_of
from lockprobe.foundation.errors import BadValue, Conflict, UnknownName
from lockprobe.foundation.spec import spec_name
from lockprobe.foundation.validation import check_whole
from lockprobe.interventions.conditions import MODALITIES, says_modality
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.words import TextChannel
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.modality import interventions_for
from lockprobe.studies.options.studyfile import trial_study
from lockprobe.studies.study import Study
from lockprobe.trial.condition import Condition, place_of, spec_of
from lockprobe.trial.plan import LABELS, Plan
from lockprobe.trial.protocols import Channel, Intervention, InterventionTraits
from lockprobe.trial.record import Percept, Task

Vector = NDArray[np.int64]

BLOCKED = 1
"""Entry 2 of the vector; one more if the joint is reported as moved."""

FARTHEST = 4.0
"""Largest depth with a reading, metres."""

_OF_A_STUDY = ("box", "p", "flip", "condition", "modality", "plant", "layout", "shuffle", "max_steps")
_OWN: Mapping[str, Any] = {
    "observation": None, "shuffle": "never", "steps_left": False, "step_cost": 0.0, "info": None,
}  # fmt: skip
"""Options that only an environment has, and defaults that differ from those of a study."""


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
        return self._replace(trial=self.trial + 1)

    def chosen(self, options: Mapping[str, Any] | None) -> EpisodeKey:
        """The trial of ``reset(options={"repetition": r, "trial": t})``; each option may be left out.

        Raises:
            UserMistake: If an option is unknown, or a number is below 1.
        """
        for name, value in (options or {}).items():
            if name not in ("repetition", "trial"):
                raise UnknownName("option of reset", str(name), ("repetition", "trial"))
            check_whole(name, value, 1)
        return self._replace(**{name: int(value) for name, value in (options or {}).items()})


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

    @cached_property
    def flips(self) -> tuple[OutcomeFlip, ...] | None:
        """The flips of all attempts alike, if nothing else acts on the reports of a symbolic plant; else None.

        Then the rules and the law of false reports are the whole trial, and the trial loop is not needed.
        """
        flips = tuple(one for one in self.chain if type(one) is OutcomeFlip and one == one.at_rate(one.p))
        alone = all(one in flips or type(one) is TextChannel for one in self.chain)
        return flips if alone and (self.observation, self.plant) == ("symbolic", "symbolic") else None

    @cached_property
    def picture_size(self) -> tuple[int, int] | None:
        """Width and height of the plant's pictures, pixels; None without a simulated camera."""
        return resolve_plant(self.plant).picture_size

    @cached_property
    def state_space(self) -> Space:
        """The configurations of the box."""
        return space_of(self.study.box)

    @cached_property
    def first_look(self) -> Percept:
        """The report in words before the first attempt: it shows whether positions and outcomes are told."""
        task = Task(joints=tuple(LABELS[: len(self.study.box.joints)]), target=LABELS[0], budget=self.study.max_steps)
        percept = Percept(positions=self.study.box.initial)
        for i, channel in enumerate(self.chain):
            if isinstance(channel, Channel):
                percept = channel.perceive(percept, (), task, np.random.default_rng(i))
        return percept

    @property
    def gaps(self) -> bool:
        """Whether a report can be missing."""
        return any(isinstance(one, Channel) and not InterventionTraits.of(one).always_tells for one in self.chain)

    @cached_property
    def space(self) -> spaces.Space[Any]:
        """The space of observations."""
        joints = len(self.study.box.joints)
        if self.observation == "symbolic" or self.picture_size is None:
            positions = [2 + self.gaps] * joints if self.first_look.positions is not None else []
            left = [self.study.max_steps + 1] if self.steps_left else []
            return spaces.MultiDiscrete(
                [joints, joints + 1, 1 if self.first_look.states_only else 3, *positions, *left]
            )
        width, height = self.picture_size
        rgb = spaces.Box(0, 255, (height, width, 3), np.uint8)
        if self.observation == "rgb":
            return rgb
        return spaces.Dict({"rgb": rgb, "depth": spaces.Box(0.0, FARTHEST, (height, width, 1), np.float32)})

    def vector(self, target: int, attempted: int | None, outcome: int, told: Sequence[int], taken: int) -> Vector:
        """A report as a vector, shape (entries,).

        Args:
            target: The target joint.
            attempted: The joint just attempted; None before the first attempt.
            outcome: 0 if nothing is reported, else :data:`BLOCKED`, or one more.
            told: Reported position of each joint.
            taken: Steps taken.
        """
        first = (target, 0 if attempted is None else attempted + 1, 0 if self.first_look.states_only else outcome)
        positions = told if self.first_look.positions is not None else ()
        left = (self.study.max_steps - taken,) if self.steps_left else ()
        return np.array((*first, *positions, *left), dtype=np.int64)

    def plan(self, key: EpisodeKey) -> Plan:
        """The trial of an episode."""
        return self.study.plan("gymnasium", self.study.conditions[0], key.repetition, key.trial, key.seed)


def read_settings(given: Mapping[str, Any]) -> EnvironmentSettings:
    """The settings from keyword arguments of ``gymnasium.make``.

    Args:
        given: The options ``box``, ``p``, ``flip``, ``condition``, ``modality``, ``plant``, ``layout``, ``shuffle`` and
            ``max_steps`` of a trial; here ``shuffle`` defaults to ``never``, and ``modality`` to ``symbolic``, which
            tells outcomes too. Further options: ``observation`` (``"symbolic"``, ``"rgb"`` or ``"rgbd"``), short for
            that modality; ``steps_left`` (False); ``step_cost`` (0.0); ``info`` (None or ``"truth"``).

    Raises:
        UserMistake: If a name does not exist, a value is out of range, or two options conflict.
    """
    for name in given:
        if name not in (*_OF_A_STUDY, *_OWN):
            raise UnknownName("setting of the environment", name, dict.fromkeys((*_OF_A_STUDY, *_OWN)))
    asked = {**_OWN, **{name: value for name, value in given.items() if value is not None}}
    for name, fits, expected in (
        ("observation", asked["observation"] in (None, *MODALITIES), f"one of {', '.join(MODALITIES)}"),
        ("info", asked["info"] in (None, "truth"), "None or 'truth'"),
        ("steps_left", isinstance(asked["steps_left"], bool), "True or False"),
        ("step_cost", _is_cost(asked["step_cost"]), "a number of at least 0"),
    ):
        if not fits:
            raise BadValue(name, asked[name], expected)
    trial = {name: asked[name] for name in _OF_A_STUDY if name in asked}
    condition, shown = asked.get("condition"), asked["observation"]
    if shown is not None and "modality" in trial:
        raise Conflict("observation=", "modality=", "both say how the box is shown")
    says = isinstance(condition, Condition) or (isinstance(condition, str) and says_modality(condition))
    if shown is not None or not (says or "modality" in trial):
        trial["modality"] = shown or "symbolic"
    settings = EnvironmentSettings(
        study=trial_study(trial, agent="gymnasium", name="lockbox"),
        steps_left=asked["steps_left"],
        step_cost=float(asked["step_cost"]),
        truth=asked["info"] == "truth",
    )
    resolve_plant(settings.plant).check(settings.study.box)
    for one in settings.chain:
        if place_of(type(one)) not in ("told", "done"):
            expected = "interventions on reports or actions: an observation holds no words and no memory"
            raise BadValue("condition", spec_of(one), expected)
    if settings.observation != "symbolic" and (settings.gaps or settings.steps_left):
        lacking = "steps_left=True" if settings.steps_left else settings.study.conditions[0].label
        raise Conflict(lacking, "pictures", "a picture shows no steps left, and cannot be left out")
    return settings


def _is_cost(value: object) -> bool:
    return isinstance(value, float | int) and 0 <= value < math.inf

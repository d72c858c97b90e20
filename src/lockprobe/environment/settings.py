"""What an environment was asked for, checked: one line of refusal for what does not exist."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from lockprobe.environment.observation import sizes
from lockprobe.errors import BadValue, UnknownName
from lockprobe.interventions.camera import CameraChannel
from lockprobe.interventions.catalogue import with_words
from lockprobe.interventions.condition import Condition
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.words import TextChannel
from lockprobe.lockbox.box import Lockbox
from lockprobe.lockbox.families import DEFAULT_BOX, find_box
from lockprobe.plan import LABELS, Plan
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.record import Percept, Task
from lockprobe.seams import Channel

__all__ = ["Settings", "read_settings", "whole"]

_OBSERVATIONS = ("symbolic", "rgb", "rgbd")
_LONGEST_BUDGET = 10_000
_CHANNELS: Mapping[str, type[OutcomeFlip | TextChannel]] = {"OutcomeFlip": OutcomeFlip, "TextChannel": TextChannel}
"""Channels that can be asked for as a mapping, by the name in the record."""

_NO_FLIP = OutcomeFlip()


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """What is played, and what is told of it.

    Attributes:
        box: The box.
        observation: ``symbolic``, ``rgb`` or ``rgbd``.
        plant: What is acted on, as its spec.
        channels: In the order in which they act; what the camera sees comes before them.
        max_steps: Budget in steps.
        shuffle: Whether each trial deals labels and listing anew, as studies do.
        steps_left: Whether the observation holds the steps left.
        step_cost: Taken from the reward at every step.
        truth: Whether ``info`` holds the truth.
    """

    box: Lockbox
    observation: str
    plant: str
    channels: tuple[Channel, ...]
    max_steps: int
    shuffle: bool
    steps_left: bool
    step_cost: float
    truth: bool

    @property
    def chain(self) -> tuple[Channel, ...]:
        """All that acts on what is told, in order: words in front of pictures, or behind reports."""
        if self.observation == "symbolic":
            return with_words(self.channels, TextChannel())
        return (CameraChannel(depth="turbo" if self.observation == "rgbd" else "none"), *self.channels)

    @property
    def has_camera(self) -> bool:
        """Whether the plant can be looked at."""
        return resolve_plant(self.plant).has_camera

    @property
    def picture_size(self) -> tuple[int, int]:
        """Height and width of the plant's pictures, pixels."""
        scene = resolve_plant(self.plant).settings
        assert scene is not None  # of a plant with a camera
        return scene.height, scene.width

    @property
    def tells_positions(self) -> bool:
        """Whether the agent is told where joints stand, or only outcomes."""
        task = Task(joints=tuple(LABELS[: len(self.box.joints)]), target=LABELS[0], budget=self.max_steps)
        percept = Percept(positions=self.box.initial)
        for i, channel in enumerate(self.channels):
            percept = channel.perceive(percept, (), task, np.random.default_rng(i))
        return percept.positions is not None

    @property
    def sizes(self) -> tuple[int, ...]:
        """How many values each entry of an observation can take."""
        budget = self.max_steps if self.steps_left else None
        return sizes(len(self.box.joints), positions=self.tells_positions, budget=budget)

    def plan(self, seed: int, repetition: int, trial: int) -> Plan:
        """The trial that a study with this seed has at this place."""
        acting = tuple(one for one in self.channels if not getattr(one, "shows", False))
        condition = Condition(interventions=acting or (_NO_FLIP,), modality=self.observation)
        shown = "" if self.observation == "symbolic" else f"{self.observation}/"
        said = condition.label if condition.p is None else f"{shown}p={condition.p:g}"
        return Plan(
            key=f"lockbox/gymnasium/{said}/rep={repetition}/trial={trial}",
            study="lockbox",
            agent="gymnasium",
            box=self.box,
            condition=condition,
            repetition=repetition,
            trial=trial,
            seed=seed,
            budget=self.max_steps,
            plant=self.plant,
            shuffle=self.shuffle,
            named=condition.p is None,
        )


def read_settings(given: Mapping[str, Any]) -> Settings:
    """The settings that keyword arguments of ``gymnasium.make`` describe.

    Args:
        given: Any of ``box`` (a name, a :class:`Lockbox` or the path of a TOML file; ``"chain-4"``), ``observation``
            (``"symbolic"``, or ``"rgb"``, ``"rgbd"``), ``plant`` (a spec; ``"symbolic"``), ``channels`` (a list of
            channels, or of mappings such as ``{"channel": "OutcomeFlip", "p": 0.2}``; none), ``max_steps`` (20),
            ``shuffle`` (False), ``steps_left`` (False), ``step_cost`` (0.0) and ``info`` (None, or ``"truth"``).

    Raises:
        UserMistake: If a name does not exist, a value is out of range, or two of them do not go together.
    """
    known: dict[str, Any] = {
        "box": DEFAULT_BOX, "observation": "symbolic", "plant": "symbolic", "channels": (), "max_steps": 20,
        "shuffle": False, "steps_left": False, "step_cost": 0.0, "info": None,
    }  # fmt: skip
    for name in given:
        if name not in known:
            raise UnknownName("setting of the environment", name, known)
    asked = known | dict(given)
    if asked["observation"] not in _OBSERVATIONS:
        raise UnknownName("observation", str(asked["observation"]), _OBSERVATIONS)
    if asked["info"] not in (None, "truth"):
        raise BadValue("info", asked["info"], "None or 'truth'")
    settings = Settings(
        box=find_box(asked["box"]),
        observation=asked["observation"],
        plant=str(asked["plant"]),
        channels=_channels(asked["channels"]),
        max_steps=whole("max_steps", asked["max_steps"], _LONGEST_BUDGET),
        shuffle=_flag("shuffle", asked["shuffle"]),
        steps_left=_flag("steps_left", asked["steps_left"]),
        step_cost=_cost(asked["step_cost"]),
        truth=asked["info"] == "truth",
    )
    _can_be_played(settings)
    return settings


def whole(what: str, value: object, largest: int | None = None) -> int:
    """The value, if it is a whole number from 1 on."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not 1 <= value <= (largest or value):
        raise BadValue(what, value, f"a whole number from 1 {'on' if largest is None else f'to {largest}'}")
    return int(value)


def _can_be_played(settings: Settings) -> None:
    """Refuses what does not go together, or not with this box or machine."""
    plant = resolve_plant(settings.plant)
    plant.check(settings.box)
    if settings.observation == "symbolic":
        return
    if not plant.has_camera:
        with_camera = "symbolic, or plant='fast-twin' or 'twin': this one has no camera"
        raise BadValue("observation", settings.observation, with_camera)
    if settings.steps_left:
        raise BadValue("steps_left", True, "False where pictures are seen")
    for channel in settings.channels:
        if isinstance(channel, TextChannel) or (isinstance(channel, OutcomeFlip) and channel.p > 0):
            raise BadValue("channel", channel, "none that changes reports: pictures show what happened")


def _flag(what: str, value: object) -> bool:
    if not isinstance(value, bool):
        raise BadValue(what, value, "True or False")
    return value


def _cost(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, float | int) or not 0 <= value < math.inf:
        raise BadValue("step_cost", value, "a number from 0 on")
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

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
=========================  ============  ==================================================================

Pictures are arrays of colours, or ``{"rgb": colours, "depth": metres}``.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from lockprobe.boxes.state_space import space_of
from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.foundation.spec import spec_name
from lockprobe.foundation.validation import check_whole
from lockprobe.interventions.conditions import says_modality
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.words import TextChannel
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.modality import interventions_for
from lockprobe.studies.options.studyfile import trial_study
from lockprobe.trial.condition import Condition, place_of, spec_of
from lockprobe.trial.plan import Plan
from lockprobe.trial.protocols import Channel, InterventionTraits

Vector = NDArray[np.int64]

BLOCKED = 1
"""Entry 2 of the vector; one more if the joint is reported as moved."""

FARTHEST = 4.0
"""Largest depth with a reading, metres."""

KNOWN = ("box", "p", "flip", "condition", "modality", "plant", "layout", "shuffle", "max_steps", "info")
"""The settings of an environment: those of a trial, and ``info``."""


class EpisodeKey(NamedTuple):
    """The trial of a study that an episode plays: the seed of the study, and repetition and trial from 1."""

    seed: int
    repetition: int = 1
    trial: int = 1

    @property
    def next(self) -> EpisodeKey:
        """The next trial."""
        return self._replace(trial=self.trial + 1)

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
            which tells outcomes too. ``info`` is None or ``"truth"``.

    Attributes:
        study: A study with one condition. Its seed is not used.
        truth: Whether ``info`` holds the truth.
        chain: The interventions in order.
        flips: The flips of all attempts alike, if nothing else acts on the reports of a symbolic plant; else None. With
            them the rules and the law of false reports are the whole trial, and the trial loop is not needed.
        shown: ``symbolic``, ``rgb`` or ``rgbd``.
        outcomes, positions: Whether reports tell them.
        box: The configurations of the box.
        space: The space of observations.

    Raises:
        UserMistake: If a name does not exist, a value is out of range, or two options conflict.
    """

    def __init__(self, given: Mapping[str, Any]) -> None:
        for name in given:
            if name not in KNOWN:
                raise UnknownName("setting of the environment", name, KNOWN)
        asked = {name: value for name, value in given.items() if value is not None}
        if (info := asked.pop("info", None)) not in (None, "truth"):
            raise BadValue("info", info, "None or 'truth'")
        condition = asked.get("condition")
        if not (isinstance(condition, Condition) or (isinstance(condition, str) and says_modality(condition))):
            asked = {"modality": "symbolic"} | asked
        self.truth = info == "truth"
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
        flips = tuple(one for one in self.chain if type(one) is OutcomeFlip and one == one.at_rate(one.p))
        words = [one for one in self.chain if type(one) is TextChannel]
        alone = len(flips) + len(words) == len(self.chain) and (self.shown, plant) == ("symbolic", "symbolic")
        self.flips: tuple[OutcomeFlip, ...] | None = flips if alone else None
        self.outcomes = all(one.tell != "state" for one in words)
        self.positions = all(one.tell != "outcome" for one in words)
        self.space: spaces.Space[Any]
        if self.shown == "symbolic":
            gaps = any(isinstance(one, Channel) and not InterventionTraits.of(one).always_tells for one in self.chain)
            told = [2 + gaps] * joints if self.positions else []
            self.space = spaces.MultiDiscrete([joints, joints + 1, 3 if self.outcomes else 1, *told])
            return
        if source.picture_size is None:
            raise BadValue("modality", self.shown, f"symbolic with {plant}, whose pictures have no size known before")
        width, height = source.picture_size
        self.space = rgb = spaces.Box(0, 255, (height, width, 3), np.uint8)
        if self.shown == "rgbd":
            depth = spaces.Box(0.0, FARTHEST, (height, width, 1), np.float32)
            self.space = spaces.Dict({"rgb": rgb, "depth": depth})

    def plan(self, key: EpisodeKey) -> Plan:
        """The trial of an episode."""
        return self.study.plan("gymnasium", self.study.conditions[0], key.repetition, key.trial, key.seed)

    def listing(self, plan: Plan) -> list[int]:
        """The joints of the study's box, by index, as a trial lists them."""
        return [self.study.box.names.index(plan.box.names[at]) for at in plan.names.order]

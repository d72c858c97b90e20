"""A study as data: which agents play which box under which conditions, how often, from which seed."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, get_args

from lockprobe.errors import BadValue
from lockprobe.interventions.flip import FlipKind, OutcomeFlip
from lockprobe.lockbox.box import Lockbox
from lockprobe.lockbox.layouts import redealt
from lockprobe.options import PEOPLE, group_of
from lockprobe.plan import Plan
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.record import Trial
from lockprobe.seeds import trial_stream
from lockprobe.studies.modality import SYMBOLIC, check_distinct, check_tellable, is_pictured, taken_in

__all__ = ["IDENTITY_VERSION", "LARGEST_SEED", "LATER", "LayoutKind", "Study", "joined_agents", "record_identity"]

LayoutKind = Literal["fixed", "shuffled"]
"""Whether every trial has the box's own panel, or one on which the same joints are dealt anew to the same places."""

LATER: Mapping[str, object] = {"layout": "fixed", "modalities": list(SYMBOLIC), "assessment": True}
"""Settings that came later, as JSON holds them, with what they were before they could be set."""

_IN_KEYS = {"agents", "added", "p", "repetitions", "trials", "modalities"}
"""Settings that a record's key says itself."""

IDENTITY_VERSION = 1
"""Raised whenever the same settings would play other trials than before."""

CLOSEST_P = 1e-6
LARGEST_SEED = 2**63
LIMITS = {"trials": 1_000_000, "repetitions": 10_000, "max_steps": 10_000}


@dataclass(frozen=True, slots=True, kw_only=True)
class Study:
    """Every setting that changes what is played, and none that does not.

    Attributes:
        name: ``flips`` or ``modalities``.
        agents: Agent specs, in the order in which they play.
        box: The box.
        p: Flip probabilities, [0, 1], each once.
        flip: Kind of outcome flip.
        repetitions: Times the whole is repeated; the paper's flip study has 3.
        trials: Trials per repetition and condition; the paper has 10.
        max_steps: Budget of a trial in steps; the paper has 20.
        seed: Seed of everything.
        shuffle: Whether labels and their listing are shuffled per trial.
        plant: What is acted on, as its spec.
        layout: ``fixed``, or ``shuffled``: same interlock, new layout every trial, the protocol of the human studies
            (Zenkri, Bolenz, Pachur and Brock, Adaptive Behavior 2025). The deal depends on seed, repetition and trial,
            not on condition and agent.
        modalities: How the box is shown, as specs of :mod:`lockprobe.studies.modality`. An agent that reads reports
            plays those only that tell.
        assessment: Whether agents are asked what their last action did (the paper's always are). Asking may change
            behaviour.

    Raises:
        BadValue: If a setting is out of range, or two modalities show the same.
        UnknownName: If there is no such plant or modality, or it has no such option.
    """

    name: str
    agents: tuple[str, ...]
    box: Lockbox
    p: tuple[float, ...]
    flip: FlipKind = "transient"
    repetitions: int = 3
    trials: int = 10
    max_steps: int = 20
    seed: int = 1
    shuffle: bool = True
    plant: str = "symbolic"
    layout: LayoutKind = "fixed"
    modalities: tuple[str, ...] = SYMBOLIC
    assessment: bool = True

    def __post_init__(self) -> None:
        for setting, known in (("flip", get_args(FlipKind)), ("layout", get_args(LayoutKind))):
            if (chosen := getattr(self, setting)) not in known:
                raise BadValue(setting, chosen, f"one of {', '.join(known)}")
        for value in self.p:
            OutcomeFlip(p=value)
        for what, values in (("p", self.p), ("agents", self.agents), ("modality", self.modalities)):
            if not values or len(set(values)) != len(values):
                raise BadValue(what, list(values), "at least one, and every one once")
        close = any(second - first < CLOSEST_P for first, second in pairwise(sorted(self.p)))
        if close or len({f"{value:g}" for value in self.p}) < len(self.p):
            raise BadValue("p", list(self.p), "values that differ by 0.000001 or more, within six digits")
        for setting, largest in LIMITS.items():
            if not 1 <= (value := getattr(self, setting)) <= largest:
                raise BadValue(setting, value, f"a whole number from 1 to {largest}")
        if not 0 <= self.seed <= LARGEST_SEED:
            raise BadValue("seed", self.seed, f"a whole number from 0 to {LARGEST_SEED}")
        self._check_pictures()

    def _check_pictures(self) -> None:
        """Refuses pictures where there is no camera, and modalities that cannot show what is flipped."""
        has_camera = resolve_plant(self.plant).has_camera
        for modality in self.modalities:
            if is_pictured(modality) and not has_camera:
                raise BadValue("modality", modality, f"a plant with a camera, fast-twin or twin, not {self.plant}")
            check_tellable(modality, self.flip, self.p)
        check_distinct(self.modalities)

    def settings(self) -> dict[str, object]:
        """The study as JSON would hold it; equal settings mean equal trials.

        A setting that came later is left out where it has its default, so that studies played before keep their names.
        """
        now = {"layout": self.layout, "modalities": list(self.modalities), "assessment": self.assessment}
        later = {name: now[name] for name, default in LATER.items() if now[name] != default}
        return {
            "identity": IDENTITY_VERSION,
            "study": self.name,
            "agents": list(self.agents),
            "box": self.box.as_data(),
            "p": list(self.p),
            "flip": self.flip,
            "repetitions": self.repetitions,
            "trials": self.trials,
            "max_steps": self.max_steps,
            "seed": self.seed,
            "shuffle": self.shuffle,
            "plant": self.plant,
            **later,
        }

    @property
    def identity(self) -> str:
        """Twelve hexadecimal digits that change with any setting."""
        text = json.dumps(self.settings(), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:12]

    @property
    def record_identity(self) -> str:
        """Twelve hexadecimal digits that a record of this study bears; see :func:`record_identity`."""
        return record_identity(self.settings())

    @property
    def has_pictures(self) -> bool:
        """Whether any of its modalities shows pictures."""
        return any(map(is_pictured, self.modalities))

    @property
    def simulated(self) -> bool:
        """Whether its plant takes a processor."""
        return not self.plant.startswith("symbolic")

    def check_agents(self) -> None:
        """Refuse agents that would have nothing to play.

        Raises:
            UnknownName: If there is no such agent.
            BadValue: If an agent reads reports, and all modalities are pictures.
        """
        for agent in self.agents:
            if not self.modalities_of(agent):
                shown = ", ".join(self.modalities)
                raise BadValue(
                    "modality", shown, f"symbolic too for {agent}, which reads reports and looks at no pictures"
                )

    def modalities_of(self, agent: str) -> tuple[str, ...]:
        """Those of its modalities that an agent plays.

        Raises:
            UnknownName: If there is no such agent.
        """
        return taken_in(agent, self.modalities)

    def plans(self, agent: str) -> Iterator[Plan]:
        """The trials of one agent: repetitions outermost, conditions innermost, so that a part is balanced."""
        modalities = self.modalities_of(agent)
        for repetition in range(1, self.repetitions + 1):
            for trial in range(1, self.trials + 1):
                for modality in modalities:
                    for p in self.p:
                        yield self.plan(agent, p, repetition, trial, modality)

    def plan(self, agent: str, p: float, repetition: int, trial: int, modality: str = "symbolic") -> Plan:
        """One trial of the study. Where a person plays it, it is one of those that people have together."""
        box = self.box
        if self.layout == "shuffled":
            box = redealt(box, trial_stream(self.seed, repetition, trial, "layout"))
        shown = "" if self.modalities == SYMBOLIC else f"/{modality}"
        return Plan(
            key=f"{self.name}/{group_of(agent)}{shown}/p={p:g}/rep={repetition}/trial={trial}",
            study=self.name,
            agent=agent,
            box=box,
            modality=modality,
            p=p,
            flip=self.flip,
            repetition=repetition,
            trial=trial,
            seed=self.seed,
            budget=self.max_steps,
            plant=self.plant,
            shuffle=self.shuffle,
            assessment=self.assessment,
        )

    def asks_for(self, trial: Trial) -> bool:
        """Whether a trial on record is one of this study: its key, its place, its settings and its panel agree."""
        if not (group_of(trial.agent) in self.agents and trial.p in self.p):
            return False
        if not (1 <= trial.repetition <= self.repetitions and 1 <= trial.trial <= self.trials):
            return False
        if trial.modality not in self.modalities_of(trial.agent):
            return False
        plan = self.plan(trial.agent, trial.p, trial.repetition, trial.trial, trial.modality)
        return (
            trial.key == plan.key
            and (trial.study, trial.flip, trial.seed, trial.budget) == (self.name, self.flip, self.seed, self.max_steps)
            and trial.joints == plan.box.names
            and trial.assessment == self.assessment
        )

    @property
    def size(self) -> int:
        """Number of trials, over all agents and conditions."""
        return sum(map(self._size_of, self.agents))

    @property
    def invited(self) -> int:
        """Of these, the trials of people, who are invited to play and not run."""
        return self._size_of(PEOPLE) if PEOPLE in self.agents else 0

    def _size_of(self, agent: str) -> int:
        return len(self.modalities_of(agent)) * len(self.p) * self.repetitions * self.trials


def record_identity(settings: Mapping[str, object]) -> str:
    """Of which study a record is: twelve hexadecimal digits that change with any setting that its key does not say.

    Agents, p, repetitions, trials and modalities are in the key, so that a study can be added to.

    Args:
        settings: Of the study, as :meth:`Study.settings` has them.
    """
    said = {name: value for name, value in {**LATER, **settings}.items() if name not in _IN_KEYS}
    text = json.dumps(json.loads(json.dumps(said), parse_float=_number), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def _number(text: str) -> float:
    """A number as JSON has it; 1.0 and 1 are the same."""
    return int(number) if (number := float(text)).is_integer() else number


def joined_agents(there: Sequence[str], asked: Sequence[str]) -> tuple[str, ...]:
    """The agents of a study in whose directory these are asked for: new ones come after those that are there.

    People are invited and not run; they stand last where agents are added.

    >>> joined_agents(["random"], ["round-robin"]), joined_agents(["participant"], ["random"])
    (('random', 'round-robin'), ('random', 'participant'))

    Args:
        there: The agents that it has.
        asked: Those asked for.
    """
    if {*asked} <= {*there}:
        return tuple(there)
    together = dict.fromkeys((*there, *asked))
    return (*(agent for agent in together if agent != PEOPLE), *((PEOPLE,) if PEOPLE in together else ()))

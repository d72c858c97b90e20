"""A study: which agents play which box under which conditions, how often, and from which seed.

Its fields are its settings: ``study.json`` is this object as JSON (:func:`settings_of`).
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, partial
from itertools import product
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, PlainSerializer, TypeAdapter
from pydantic.dataclasses import dataclass as model

from lockprobe.agents.catalogue import is_strategy
from lockprobe.boxes.box import LayoutKind, Lockbox, Shuffle
from lockprobe.boxes.layouts import redealt
from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.seeds import generator
from lockprobe.foundation.spec import PEOPLE, spec_name
from lockprobe.foundation.validation import AS_WRITTEN, Text, check_number
from lockprobe.interventions.conditions import flip_alone, tells_positions
from lockprobe.interventions.flip import OutcomeFlip, with_rates
from lockprobe.interventions.modality import check_shown, is_pictured, refuse_blind, taken_in
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.statistics.design import Design, SeriesArm
from lockprobe.studies.options.study_options import Repetitions, Seed, Steps, Trials
from lockprobe.studies.running.playable import PERSON, check_playable
from lockprobe.trial.condition import Condition, Contrast
from lockprobe.trial.doses import modality_doses
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Ask, Trial, TrialName

_LONGEST_NAME, _LONGEST_LABEL = 100, 200
"""Characters of the name of a study, and of what keys, tables and pages call an agent."""

SIZES = ("repetitions", "trials", "strategy_trials", "until")
"""The settings that say how much is played."""

_WHO = ("agents", "names")
"""The settings that say who plays."""

_BESIDE = ("contrasts", "earlier", "shard")
"""What ``study.json`` holds beside the settings: it changes no trial."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Until:
    """When a study stops before all of its trials are played.

    Attributes:
        rule: ``decided``: every difference is shown to be an effect, or to be smaller than ``points``. ``width``: the
            interval of every difference reaches at most ``points`` to either side.
        points: As a difference of shares, [0.01, 0.5]. The default of the margin is a convention.
    """

    __pydantic_config__ = AS_WRITTEN

    rule: Literal["decided", "width"]
    points: Annotated[float, Field(ge=0.01, le=0.5)] = 0.1

    @classmethod
    def parse(cls, text: str) -> Self:
        """The rule of a text: ``decided``, or ``±10`` (also ``+-10`` or ``10``) for a width.

        >>> Until.parse("±10")
        Until(rule='width', points=0.1)
        """
        if text.strip() == "decided":
            return cls(rule="decided")
        found = re.fullmatch(r"\s*(?:±|\+-|\+/-)?\s*([0-9]{1,2}(?:\.[0-9]{1,3})?)\s*", text)
        if found is None or not 1 <= float(found[1]) <= 50:
            raise BadValue("until", text, "decided, ±10 or another number of points, from 1 to 50")
        return cls(rule="width", points=float(found[1]) / 100)

    def __str__(self) -> str:
        return "decided" if self.rule == "decided" else f"±{100 * self.points:g}"

    @property
    def margin(self) -> float | None:
        """The largest difference that counts as none; None where the study says of none that it is small."""
        return self.points if self.rule == "decided" else None


@dataclass(frozen=True, slots=True)
class EarlierSize:
    """The size that a study had before it was extended, in the fields of :class:`Study`.

    Blocks of an earlier size come before those that were added to it, in what holds at every look.
    """

    __pydantic_config__ = AS_WRITTEN

    repetitions: Repetitions
    trials: Trials
    strategy_trials: Trials | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Shard:
    """Part ``number`` (from 1) ``of`` the trials of a study, which several machines play without communication.

    A hash of its key assigns every trial to exactly one; ``lockprobe import`` merges the directories of all shards.
    """

    number: int
    of: int

    def __str__(self) -> str:
        return f"{self.number}/{self.of}"

    @classmethod
    def parse(cls, text: str) -> Self:
        """The shard of a text such as ``3/16``, of at most 100 000."""
        found = re.fullmatch(r"([0-9]{1,6})/([0-9]{1,6})", text)
        if found is None or not 1 <= int(found[1]) <= int(found[2]) <= 100_000:
            raise BadValue("shard", text, "i/n, for example 3/16 for the third of 16 parts, of at most 100000")
        return cls(number=int(found[1]), of=int(found[2]))

    def has(self, key: str) -> bool:
        """Whether the trial with this key is in the shard."""
        return int.from_bytes(hashlib.sha256(key.encode()).digest()[:8]) % self.of == self.number - 1


_json_sorted = partial(json.dumps, sort_keys=True)
"""A value as JSON, the same for equal values."""

_Shard = Annotated[Shard, BeforeValidator(lambda said: Shard.parse(said) if isinstance(said, str) else said)]


@model(frozen=True, kw_only=True, config=AS_WRITTEN)
class Study:
    """Every setting that changes what is played; beside them what it asks, and how it grew or is shared out.

    Attributes:
        name: ``flips``, ``modalities``, or a name that the experimenter gives it.
        agents: Agent specs, in the order in which they play.
        names: Agent spec -> the experimenter's name for it, for those that have one; those of other agents are dropped.
            Keys, tables and pages show it in place of the spec. It changes no draw.
        conditions: Each once: flip rates, as :func:`lockprobe.interventions.conditions.flips` makes them, or any
            others. An agent that reads reports plays those only that tell.
        repetitions: Times the whole is repeated; the paper's flip study has 3.
        trials: Trials per repetition and condition, of all boxes together; the paper has 10.
        strategy_trials: The same for strategies (:func:`lockprobe.agents.catalogue.is_strategy`), which
            cost nothing; ``trials`` if None. All agents share the luck of the trials that all of them play.
        strategy_conditions: Labels of conditions that strategies alone play, since a model's trials cost.
        until: When it stops, before ``trials`` are played; None if all of them are.
        boxes: One or several. Trials take turns on them (:meth:`box_of`), so that each has luck of its own.
        max_steps: Budget of a trial in steps; the paper has 20.
        seed: Seed of everything.
        shuffle: How often labels and their listing are drawn: in every ``trial``, once for the ``study``, or ``never``.
        plant: What is acted on, as its spec; conditions may change its options (:meth:`plant_of`).
        layout: ``fixed``, the box's own; ``dealt``, another one for all trials; or ``shuffled``, a new one in every
            trial (:func:`lockprobe.boxes.layouts.redealt`), the same under every condition and for every agent.
        assessment: Whether agents are asked what their last action did. Asking may change behaviour.
        hypothesis: When hosted models are asked how the box works, unless a condition says otherwise.
        contrasts: What it asks, by its name; no setting, since it changes no trial.
        earlier: The sizes that it had before it was extended; no setting, since they change no trial.
        shard: The part of its trials that is played; None for all. It is no setting either.

    Raises:
        UnknownName: If there is no such plant or modality.
        BadValue: If two conditions are the same, its plant cannot show them, or people take part who cannot play them.
        ValidationError: If a setting has another type, or is out of range.
    """

    name: Text
    agents: tuple[Text, ...]
    names: Mapping[Text, Text] = field(default_factory=dict, hash=False)
    conditions: tuple[Condition, ...]
    repetitions: Repetitions = 3
    trials: Trials = 10
    strategy_trials: Trials | None = None
    until: Until | None = None
    strategy_conditions: tuple[Text, ...] = ()
    boxes: tuple[Lockbox, ...]
    max_steps: Steps = 20
    seed: Seed = 1
    shuffle: Shuffle = "trial"
    plant: Text = "symbolic"
    layout: LayoutKind = "fixed"
    assessment: bool = True
    hypothesis: Ask = "before"
    contrasts: Mapping[Text, Contrast] = field(default_factory=dict, compare=False)
    earlier: tuple[EarlierSize, ...] = field(default=(), compare=False)
    shard: Annotated[_Shard | None, PlainSerializer(lambda one: one and str(one))] = field(default=None, compare=False)

    def __post_init__(self) -> None:
        names = {agent: name for agent in self.agents if (name := self.names.get(agent)) and name != agent}
        object.__setattr__(self, "names", names)
        object.__setattr__(self, "strategy_conditions", tuple(sorted(self.strategy_conditions)))
        _check_names(self)
        _check_conditions(self)
        for one in self.earlier:
            if one.repetitions > self.repetitions or one.trials > self.trials:
                raise BadValue("earlier", one, "a study that was no larger than it is now")
        if self.until and (PEOPLE in self.agents or len(self.boxes) > 1):
            raise BadValue(
                "until", str(self.until), "none with people or several boxes, which are compared at one look"
            )
        for spec, conditions in grouped(self.conditions, self.plant_of).items():
            plant = resolve_plant(spec)
            check_shown(conditions, plant)
            pictured = any(is_pictured(one.modality) for one in conditions)
            if self.shuffle != "never" and plant.photographs and pictured:
                expected = "never with pictures of a real box, on which labels are painted"
                raise BadValue("shuffle", self.shuffle, expected)
            if self.layout != "fixed" and plant.lays_out is False:
                raise BadValue("layout", self.layout, f"fixed with {plant.spec}, whose joints stay where they are")

    @property
    def labels(self) -> tuple[str, ...]:
        """What keys, tables and pages call the agents: their names, or their specs if they have none."""
        return tuple(map(self.label_of, self.agents))

    def label_of(self, agent: str) -> str:
        """What keys, tables and pages call the agent of a spec."""
        return self.names.get(agent, agent)

    @cached_property
    def flip_axis(self) -> tuple[Condition, ...]:
        """Those of its conditions that differ in flip rate and modality alone (:func:`flip_axis`)."""
        return flip_axis(self.conditions)

    @property
    def p(self) -> tuple[float, ...]:
        """The flip rates of those conditions in which nothing else acts, each once."""
        return tuple(dict.fromkeys(one.p for one in self.flip_axis if one.p is not None))

    @property
    def of_flips(self) -> bool:
        """Whether nothing but flip rates and modalities differs between its conditions."""
        return len(self.flip_axis) == len(self.conditions)

    @property
    def flip(self) -> OutcomeFlip:
        """What a false report is in those conditions: a flip at rate 0."""
        flips = (flip.at_rate(0) for one in self.flip_axis if one.specs and (flip := flip_alone(one)))
        return next(flips, OutcomeFlip())

    @property
    def flip_kind(self) -> str:
        """What a false report is in those conditions, in the words of the field: ``memoryless state noise``."""
        return self.flip.reading if any(map(tells_positions, self.modalities)) else "outcomes without positions"

    def plant_of(self, condition: Condition) -> str:
        """The spec of the plant on which a condition is played: the study's, with the options that it changes."""
        return condition.plant.on(self.plant)

    @property
    def plants(self) -> tuple[str, ...]:
        """The plants of its conditions, each once."""
        return tuple(dict.fromkeys(map(self.plant_of, self.conditions)))

    @property
    def modalities(self) -> tuple[str, ...]:
        """How the box is shown, each way once."""
        return tuple(dict.fromkeys(one.modality for one in self.conditions))

    def settings(self) -> dict[str, Any]:
        """What changes its trials, as JSON would hold it."""
        return {name: value for name, value in settings_of(self).items() if name not in _BESIDE}

    def differences(self, other: Study, *, but: Collection[str] = ()) -> dict[str, tuple[object, object]]:
        """The settings in which another study differs, with its value and this one's, in words.

        Which agents play, and their order and that of conditions, are no settings here; names of agents of both are,
        unless they are among those that may differ (``but``).
        """
        words: dict[str, Callable[[Any], object]] = {
            "boxes": lambda boxes: ", ".join(box.name for box in boxes),
            "conditions": lambda own: "; ".join(f"{one.name}={one.spec}".lstrip("=") for one in own),
            "until": lambda one: str(one or "never"),
        }
        found = dict[str, tuple[object, object]]()
        for name in (one.name for one in fields(self) if one.compare and one.name not in (*_WHO, *but)):
            there, here = getattr(other, name), getattr(self, name)
            if there != here and not (name == "conditions" and {*there} == {*here}):
                there, here = map(words.get(name, lambda value: value), (there, here))
                here = f"another {here}" if there == here else here
                found["box" if name == "boxes" else name] = there, here
        for agent in {*self.agents} & {*other.agents} if "names" not in but else ():
            if other.label_of(agent) != self.label_of(agent):
                found[f"name of {agent}"] = other.label_of(agent), self.label_of(agent)
        return found

    def joined(self, asked: Iterable[str]) -> tuple[str, ...]:
        """Its agents after agents are added: new ones follow those that are there, and people stand last."""
        new = [agent for agent in asked if agent not in self.agents]
        return tuple(sorted((*self.agents, *new), key=lambda agent: agent == PEOPLE)) if new else self.agents

    def ordered_as(self, other: Study) -> Study:
        """The study with its conditions in the order of another one that has the same; else as it is."""
        same = {*self.conditions} == {*other.conditions}
        return replace(self, conditions=other.conditions) if same else self

    @property
    def settings_hash(self) -> str:
        """Thirty-two hexadecimal digits that change with any setting, and are the same read back from disk.

        The order of agents and conditions is no setting: it changes no trial. The digits stand under a preregistration,
        so they are too many to find two studies with equal ones by trying.
        """
        settings = self.settings()
        settings |= {name: sorted(settings[name], key=_json_sorted) for name in ("agents", "conditions")}
        return hashlib.sha256(_json_sorted(settings).encode()).hexdigest()[:32]

    @property
    def identity(self) -> str:
        """The first twelve digits of the hash of the settings, for names of directories."""
        return self.settings_hash[:12]

    def record_identity(self, condition: Condition) -> str:
        """What a record under a condition is of: twelve hexadecimal digits that change with whatever acts in its trial.

        They cover what a condition does and not what it is called, so that trials of two studies whose conditions share
        a name are never taken for each other. Study, agent, label, repetition and trial are in the record itself.
        """
        beside = {"name", "conditions", "strategy_conditions", *_WHO, *SIZES}
        acting = {name: value for name, value in self.settings().items() if name not in beside}
        acting |= {"specs": list(condition.specs), "modality": condition.modality}
        return hashlib.sha256(_json_sorted(acting).encode()).hexdigest()[:12]

    @property
    def simulated(self) -> bool:
        """Whether its plant takes a processor."""
        return spec_name(self.plant) != "symbolic"

    @property
    def attended(self) -> bool:
        """Whether somebody at the terminal answers questions of its plant, so that trials are played one at a time."""
        return resolve_plant(self.plant).is_attended()

    def check_agents(self) -> None:
        """Refuse agents that would have nothing to play."""
        for agent in self.agents:
            if not self.modalities_of(agent):
                refuse_blind(agent, ", ".join(self.modalities))

    def modalities_of(self, agent: str) -> tuple[str, ...]:
        """Those of its modalities that an agent plays."""
        return taken_in(agent, self.modalities)

    def conditions_of(self, agent: str) -> tuple[Condition, ...]:
        """Those of its conditions that an agent plays."""
        shown, spared = self.modalities_of(agent), () if is_strategy(agent) else self.strategy_conditions
        return tuple(one for one in self.conditions if one.modality in shown and one.label not in spared)

    def trials_of(self, agent: str, size: EarlierSize | None = None) -> int:
        """Trials per repetition and condition that an agent plays, or played when the study had an earlier size."""
        of = size or self
        return of.strategy_trials if of.strategy_trials is not None and is_strategy(agent) else of.trials

    @property
    def box(self) -> Lockbox:
        """Its box, or the first of several."""
        return self.boxes[0]

    @property
    def boxes_in_words(self) -> str:
        """The name of its box, or how many it has."""
        return f"{len(self.boxes)} boxes" if len(self.boxes) > 1 else self.box.name

    def box_of(self, trial: int) -> Lockbox:
        """The box of a trial by its number, from 1: boxes take turns, so that a part of a study is balanced."""
        return self.boxes[(trial - 1) % len(self.boxes)]

    def plans(self, agent: str) -> Iterator[Plan]:
        """The trials of one agent: repetitions outermost, conditions innermost, so that a part is balanced."""
        conditions = self.conditions_of(agent)
        for repetition, trial in self.blocks_of(agent):
            for condition in conditions:
                if self.in_shard(agent, condition, repetition, trial):
                    yield self.plan(agent, condition, repetition, trial)

    def blocks_of(self, agent: str) -> Iterator[tuple[int, int]]:
        """The repetitions and trials of an agent, those of other shards too."""
        return product(range(1, self.repetitions + 1), range(1, self.trials_of(agent) + 1))

    def in_shard(self, agent: str, condition: Condition, repetition: int, trial: int) -> bool:
        """Whether a trial is one of its shard; whole blocks are, where it stops when it is decided."""
        if self.shard is None:
            return True
        name = TrialName(self.name, self.label_of(agent), condition.label, repetition, trial)
        return self.shard.has(f"{repetition}/{trial}" if self.until else str(name))

    def plan(self, agent: str, condition: Condition, repetition: int, trial: int, seed: int | None = None) -> Plan:
        """One trial of the study; repetition and trial count from 1. People share the trials of ``participant``.

        ``seed`` replaces the study's own, for the same trial in a study that differs in its seed alone.
        """
        seed, box = self.seed if seed is None else seed, self.box_of(trial)
        if self.layout == "shuffled":
            box = redealt(box, generator(seed, "rep", repetition, "trial", trial, "layout"))
        elif self.layout == "dealt":
            box = redealt(box, generator(seed, "study", "layout"), neutral=True)
        plan = Plan(
            study=self.name,
            agent=agent,
            box=box,
            condition=condition,
            repetition=repetition,
            trial=trial,
            seed=seed,
            budget=self.max_steps,
            plant=self.plant_of(condition),
            shuffle=self.shuffle,
            assessment=self.assessment,
            hypothesis=self.hypothesis,
            called=self.names.get(agent, ""),
        )
        return with_rates(plan)

    def labelled(self, label: str, what: str = "condition") -> Condition:
        """The condition of a label; ``what`` it is of, where it is unknown."""
        for one in self.conditions:
            if one.label == label:
                return one
        raise UnknownName(what, label, [one.label for one in self.conditions])

    @property
    def place_of(self) -> Callable[[Trial], tuple[int, int, int, int]]:
        """A sort key of this study's trials: by agent, condition, repetition and trial."""
        agents = {agent: i for i, agent in enumerate(self.agents)}
        conditions = {one.label: i for i, one in enumerate(self.conditions)}
        return lambda trial: (agents[trial.spec], conditions[trial.condition], trial.repetition, trial.trial)

    def places_filled(self, trials: Iterable[Trial]) -> int:
        """The number of places of the plan with a finished trial among trials of this study.

        Two people may have played the same place, where one was away and came back.
        """
        ended = (one for one in trials if not one.owed_again)
        return len({(one.spec, one.condition, one.repetition, one.trial) for one in ended})

    @property
    def run_agents(self) -> tuple[str, ...]:
        """The agents that are run: all but people, who are invited."""
        return tuple(agent for agent in self.agents if agent != PEOPLE)

    @property
    def size(self) -> int:
        """Number of trials, over all agents and conditions."""
        return sum(map(self.size_of, self.agents))

    @property
    def invited(self) -> int:
        """Of these, the trials of people, who are invited to play and not run."""
        return sum(self.size_of(agent) for agent in self.agents if agent not in self.run_agents)

    def size_of(self, agent: str) -> int:
        """Number of trials of one agent, over all conditions."""
        if self.shard is None:
            return len(self.conditions_of(agent)) * self.repetitions * self.trials_of(agent)
        every = product(self.conditions_of(agent), self.blocks_of(agent))
        return sum(self.in_shard(agent, condition, *block) for condition, block in every)


def flip_axis(conditions: Sequence[Condition]) -> tuple[Condition, ...]:
    """Flips of one reading, that of the first, and the truth: each rate once in each modality."""
    flips = [(one, flip) for one in conditions if one.p is not None and (flip := flip_alone(one)) is not None]
    reading = next((flip.at_rate(0) for one, flip in flips if one.specs), None)
    found: dict[tuple[str, float | None], Condition] = {}
    for one, flip in flips:
        if not one.specs or flip.at_rate(0) == reading:
            found.setdefault((one.modality, one.p), one)
    return tuple(found.values())


def _check_names(study: Study) -> None:
    """Refuse names that keys and pages cannot show or would mix up, and more than one of anything."""
    labels, boxes = [one.label for one in study.conditions], [one.name for one in study.boxes]
    several = (("agents", study.agents), ("agents", study.labels), ("condition", labels), ("box", boxes))
    for what, values in several:
        if not values or len({value.replace("/", "%2F") for value in values}) != len(values):
            raise BadValue(what, list(values), "at least one, and every one once")
    for label in study.labels:
        if not label.isprintable() or label != label.strip() or len(label) > _LONGEST_LABEL:
            expected = f"at most {_LONGEST_LABEL} visible characters without blanks around them: NAME=SPEC names it"
            raise BadValue("name of an agent", label, expected)
    if PEOPLE in study.names or PEOPLE in study.names.values():
        raise BadValue("name of an agent", study.names, f"{PEOPLE} without a name, and no other agent of this name")
    if "/" in study.name or not study.name.strip() or len(study.name) > _LONGEST_NAME:
        raise BadValue("name", study.name, f"a name of at most {_LONGEST_NAME} characters without slashes")


def _check_conditions(study: Study) -> None:
    """Refuse unknown labels, doses to which no curve can be fitted, and what people cannot play."""
    for name, contrast in study.contrasts.items():
        labels = (*contrast.of, *contrast.minus)
        for label in labels:
            study.labelled(label, f"condition of the contrast {name}")
        if len({*labels}) < len(labels):
            raise BadValue(f"condition of the contrast {name}", labels, "every one once, and on one side alone")
    for one in study.conditions:
        # fits square a dose, and must not lose it
        if unfit := {name: dose for name, dose in one.doses.items() if not 1e-9 <= abs(dose) <= 1e9}:
            expected = "0, or a number from 1e-09 to 1e+09 or from -1e+09 to -1e-09, which curves can be fitted to"
            raise BadValue(f"a dose of {one.label}", unfit, expected)
        if one.p is not None:
            check_number(f"the flip rate of {one.label}", one.p)
    if PEOPLE in study.agents:
        check_playable((one for one in study.conditions if not one.is_recorded), PERSON)


def design_of(study: Study) -> Design:
    """What differs between the conditions of a study."""
    return Design(
        agents=study.labels,
        arms=arms_of(study.conditions),
        axis=frozenset(one.label for one in study.flip_axis),
        specs=dict(zip(study.labels, study.agents, strict=True)),
    )


def arms_of(conditions: Iterable[Condition]) -> tuple[SeriesArm, ...]:
    """Conditions as their specs tell them; doses of pictures and of the plant stand among those of interventions."""
    found = []
    for one in conditions:
        specs, doses = tuple(spec for spec, _ in one.parts), tuple(names for _, names in one.parts)
        found.append(SeriesArm(label=one.label, specs=specs, doses=doses, modality=modality_doses(one.modality)[0]))
    return tuple(found)


AS_JSON = TypeAdapter(Study)
"""How a study is read from ``study.json``, and written."""


def settings_of(study: Study) -> dict[str, Any]:
    """A study as ``study.json`` holds it: what changes its trials, and beside it contrasts, earlier sizes and a shard.

    What is empty is left out.
    """
    found = AS_JSON.dump_python(study, mode="json")
    for condition in found["conditions"]:
        if not condition["plant"]["options"]:
            del condition["plant"]
    return {name: value for name, value in found.items() if value not in (None, [], {})}

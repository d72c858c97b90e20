"""The contracts: laws of agents, boxes, interventions, measures and plants, run over one of them.

Each raises AssertionError where a law is broken; the message says which. Hosted models cannot keep the contract of an
agent, because their answers vary.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from lockprobe.agents.catalogue import resolve
from lockprobe.boxes.box import Lockbox, data_of
from lockprobe.boxes.boxfile import box_from_data, toml_of
from lockprobe.boxes.families import find_box
from lockprobe.boxes.solve import fault_of
from lockprobe.foundation.errors import UserMistake
from lockprobe.foundation.plugins import allow
from lockprobe.foundation.spec import settings_of
from lockprobe.interventions.conditions import interventions_of
from lockprobe.interventions.modality import is_pictured, shown
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.statistics.measures import Measure, find_measure, measured
from lockprobe.studies.running.single import run_trial
from lockprobe.testing.trials import make_trial, play_trials
from lockprobe.trial.condition import PLACES, place_of, spec_of
from lockprobe.trial.labels import LABELS
from lockprobe.trial.luck import Luck
from lockprobe.trial.protocols import Agent, Intervention, InterventionTraits, Plant
from lockprobe.trial.record import STATES, Decision, Fact, Percept, Situation, Trial
from lockprobe.trial.trial_json import trial_from_json, trial_to_json

Box = str | Path | Lockbox


def _check_facts(facts: object, whose: str) -> None:
    """Facts map names to text, numbers, bools or None, and survive JSON."""
    assert isinstance(facts, Mapping), f"the facts of {whose} are no mapping"
    plain = all(isinstance(fact, str | int | float | None) for fact in facts.values())
    assert plain, f"a fact of {whose} is no text, number, yes or no"
    assert json.loads(json.dumps(dict(facts))) == dict(facts), f"the facts of {whose} do not survive JSON"


def _check_record(trial: Trial, whose: str) -> None:
    """A trial did not break and survives JSON."""
    assert trial.error is None, f"a trial of {whose} broke: {trial.error and trial.error.message}"
    assert trial_from_json(trial_to_json(trial)) == trial, f"a trial of {whose} does not survive the record"


@dataclass
class _Beside:
    """An agent whose calls are noted: situation, random stream before the call, decision.

    Before each call it repeats one of ``others``, of another trial.
    """

    agent: Agent
    others: Sequence[tuple[Situation, np.random.Generator, Decision]] = ()
    calls: list[tuple[Situation, np.random.Generator, Decision]] = field(default_factory=list)

    @property
    def facts(self) -> Mapping[str, Fact]:
        return self.agent.facts

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        if len(self.calls) < len(self.others):
            other, stream, decided = self.others[len(self.calls)]
            assert await self.agent.decide(other, deepcopy(stream)) == decided, "it answers otherwise beside a trial"
        stream = deepcopy(rng)
        self.calls.append((situation, stream, await self.agent.decide(situation, rng)))
        return self.calls[-1][2]


def check_agent(
    agent: str | Agent,
    *,
    boxes: Sequence[Box] = ("chain-4", "gray-code"),
    plant: str = "symbolic",
    modality: str = "symbolic",
) -> None:
    """Check that an agent fulfils its contract.

    It chooses listed joints. It plays the same trial identically again, drawing only from the given stream. It keeps
    nothing between calls: two interleaved trials equal two separate ones. Its facts and decisions survive the record.

    Args:
        agent: Its spec, or an agent.
        boxes: The boxes it plays, with true and with false reports.
        plant: The plant, as its spec.
        modality: How the box is shown, as its spec; with pictures no report is false.

    Raises:
        AssertionError: If it breaks one of these.
    """
    if isinstance(agent, str):
        allow(agent)
    player = resolve(agent).make() if isinstance(agent, str) else agent
    name = agent if isinstance(agent, str) else type(agent).__name__
    assert isinstance(player, Agent), f"{name} has no `facts` or no `decide`"
    _check_facts(player.facts, name)
    before: Sequence[tuple[Situation, np.random.Generator, Decision]] = ()
    for box in boxes:
        for seed in (1, 2, 3):
            for p in (0.0,) if is_pictured(modality) else (0.0, 0.4):
                noted = _Beside(player)
                alone, again, beside = (
                    run_trial(agent=one, box=box, seed=seed, p=p, plant=plant, modality=modality)
                    for one in (noted, player, _Beside(player, before))
                )
                _check_record(alone, name)
                for other, broken in (
                    (again, "plays the same trial differently again: it keeps something, or draws elsewhere"),
                    (beside, "keeps something between calls: trials side by side are not as one by one"),
                ):
                    assert (alone.steps, alone.ending) == (other.steps, other.ending), f"{name} {broken}"
                before = noted.calls


def check_box(box: Box | Callable[[], Lockbox]) -> None:
    """Check that a box fulfils its contract.

    It can be solved, and no alternative of its target is contradictory. Asking for it again returns the same box, and
    so does writing it as data, settings or TOML and reading it back. It can be played.

    Args:
        box: A name, a path, a box, or a function that returns one.

    Raises:
        AssertionError: If it breaks one of these.
    """
    found, again = (find_box(box) if isinstance(box, str | Path | Lockbox) else box() for _ in range(2))
    assert isinstance(found, Lockbox), f"{found!r} is no Lockbox"
    assert found == again, f"{found.name} is another box when it is asked for again"
    fault = fault_of(found)
    assert fault is None, f"{found.name} is {fault}"
    try:
        read = box_from_data(json.loads(json.dumps(data_of(found))))
        toml_of(found)
    except UserMistake as mistake:
        raise AssertionError(f"{found.name} cannot be written down: {mistake}") from mistake
    assert read == found, f"{found.name} is another box when it is written down and read"
    _check_record(play_trials("random", 1, box=found)[0], found.name)


def check_intervention(one: Intervention, *, doses: Sequence[object] = (0, 1), modality: str = STATES) -> None:
    """Check that an intervention fulfils its contract.

    It is a frozen dataclass that acts at exactly one place. A spec can name it, and its settings survive JSON. It keeps
    nothing between calls. At 0 of its first dose every agent plays as in truth, byte for byte. If it changes reports,
    it changes something that they show: the default report (``symbolic?tell=state``) shows ``joint`` and ``positions``
    of a percept, and no ``outcome``. It leaves no report out if it declares ``always_tells``.

    Args:
        one: The intervention, with the settings to test.
        doses: Values of its first dose that are tried; unused where it has no dose.
        modality: How reports are shown: ``symbolic`` shows ``outcome`` too.

    Raises:
        AssertionError: If it breaks one of these.
    """
    kind: Any = type(one)
    name, place, traits = kind.__name__, place_of(kind), InterventionTraits.of(one)
    assert is_dataclass(kind), f"{name} is no dataclass"
    assert getattr(kind, "__dataclass_params__").frozen, f"{name} is not frozen"  # noqa: B009
    allow(spec_of(one))
    assert interventions_of(spec_of(one)) == (one,), f"{name} is not made again by its spec {spec_of(one)!r}"
    assert json.loads(json.dumps(settings_of(one))) == settings_of(one), f"the settings of {name} do not survive JSON"
    assert isinstance(traits.doses, tuple), f"doses of {name} is no tuple of names of its options: {traits.doses!r}"
    calls: list[tuple[Any, ...]] = []

    def note(witness: object, given: object, *rest: object) -> object:
        calls.append((given, *rest[:-1]))
        return given

    witness: Any = type("Witness", (), {PLACES[place]: note})()
    run_trial(agent="random", condition=(witness,), max_steps=30, box="chain-7")
    luck = Luck(seed=7, box="chain-7", repetition=1, trial=1)

    def answers(other: Intervention) -> list[Any]:
        """The answers to the calls of one trial, each with the luck of its own step."""
        return [getattr(other, PLACES[place])(*call, luck.at(name, step)) for step, call in enumerate(calls)]

    at_doses: list[Any] = [replace(kept, **{traits.doses[0]: dose}) for kept in [one] for dose in doses if traits.doses]  # type: ignore[type-var]
    for other in (one, *at_doses):
        again = answers(other)
        assert answers(other) == again, (
            f"{spec_of(other)} answers differently when it is asked again: it keeps something"
        )
    told = answers(one)
    if place == "told" and traits.always_tells:
        assert all(percept.positions for percept in told), f"{name} leaves a report out: it must not have always_tells"
    if place == "told":
        words, pairs = shown(modality), [(call[0], percept) for call, percept in zip(calls, told, strict=True)]
        parts = [part.name for part in fields(Percept) if part.compare]
        changed = {part for was, now in pairs for part in parts if getattr(was, part) != getattr(now, part)}
        assert not changed or any(words.shown(was) != words.shown(now) for was, now in pairs), (
            f"{name} changes {', '.join(sorted(changed))}, and no report in {modality} shows that: symbolic?tell=state "
            "shows joint and positions, symbolic (modality=) outcome too, and text is written afterwards"
        )
    if traits.doses:
        none: Any = replace(one, **{traits.doses[0]: 0})  # type: ignore[type-var]
        for agent in ("random", "human-inspired", "cognitive:perseverant"):
            for seed in (1, 2, 3):
                nothing: dict[str, Any] = {"specs": (), "doses": {}, "channels": (), "interventions": (), "changed": {}}
                nothing |= {"key": "", "condition": "", "changed_steps": 0}  # the names of the condition
                truth, under = (
                    trial_to_json(replace(run_trial(agent=agent, seed=seed, condition=acting), **nothing))
                    for acting in ((), (none,))
                )
                assert truth == under, f"{agent} does not play as in truth under {spec_of(none)}"


def check_measure(measure: str | Measure, *, trials: Sequence[Trial] = ()) -> None:
    """Check that a measure fulfils its contract.

    For any trial, also one that broke before its first step, it returns a finite number, a bool, or None. It never
    mixes numbers and bools. It returns the same value again and leaves the trial unchanged. It applies to at least one
    trial.

    Args:
        measure: Its spec, or the function.
        trials: Further trials; two agents always play true, false and missing reports.

    Raises:
        AssertionError: If it breaks one of these.
        UserMistake: If it is not a measure, or returns an invalid value.
    """
    found = find_measure(measure)
    played = [
        trial
        for agent in ("random", "human-inspired")
        for condition in ("truth", "flip?p=0.4", "drop?p=1", "tremble?p=0.5")
        for trial in play_trials(agent, 3, condition=condition)
    ]
    every = [*trials, *played, make_trial((), broken=True), make_trial((0, 1), broken=True), make_trial((3,))]
    before = [trial_to_json(trial) for trial in every]
    values = [found(trial) for trial in every]
    assert [found(trial) for trial in every] == values, f"{found.name} is another number when it is asked for again"
    assert [trial_to_json(trial) for trial in every] == before, f"{found.name} changes the trial"
    kinds = {type(value) for value in values if value is not None}
    assert kinds, f"{found.name} applies to no trial"
    assert len(kinds) == 1, f"{found.name} is a number of one trial, and yes or no of another"
    measured(every, found)


def check_plant(
    plant: str | Callable[..., Plant],
    *,
    boxes: Sequence[Box] = ("chain-4", "bichain-4", "gray-code"),
    attempts: int = 40,
) -> None:
    """Check that a plant fulfils its contract.

    It starts with the box's initial configuration, and looking changes nothing. An attempt toggles the joint if the
    interlock allows that and changes nothing else; the snapshot says so. A new plant starts afresh. Its sensors and
    facts survive the record. It can be closed.

    Args:
        plant: Its spec, or a callable with ``box``, ``labels`` and ``rng``.
        boxes: The boxes that it is made for.
        attempts: Number of random attempts on each box.

    Raises:
        AssertionError: If it breaks one of these.
    """
    name = plant if isinstance(plant, str) else getattr(plant, "__name__", type(plant).__name__)
    if isinstance(plant, str):
        allow(plant)
    for box in map(find_box, boxes):
        labels, rng, luck = tuple(LABELS[: len(box.joints)]), np.random.default_rng(7), np.random.default_rng(11)
        first, other = (
            resolve_plant(plant).make(box, labels, rng)
            if isinstance(plant, str)
            else plant(box=box, labels=labels, rng=rng)
            for _ in range(2)
        )
        assert isinstance(first, Plant), f"{name} has no `facts`, `observe`, `attempt` or `close`"
        _check_start(first, box, name)
        now = box.initial
        for _ in range(attempts):
            joint = int(luck.integers(len(box.joints)))
            allowed = box.may_move(now, joint)
            now, _moved = box.attempt(now, joint)
            seen = first.attempt(joint)
            where = f"on {box.name}, where the interlock {'lets' if allowed else 'does not let'} joint {joint} move"
            assert seen.joint == joint, f"{name} reports another joint than the one attempted, {joint}"
            assert seen.configuration == now, f"{name} does not obey the interlock {where}"
            assert seen.outcome == ("moved" if allowed else "blocked"), f"{name} reports a wrong outcome {where}"
            _check_facts(seen.sensed, f"{name}, what it senses,")
        _check_start(other, box, name)
        _check_facts(first.facts, name)
        first.close()
        other.close()
        if isinstance(plant, str):
            _check_record(run_trial(agent="random", box=box, plant=plant), name)


def _check_start(plant: Plant, box: Lockbox, name: str) -> None:
    for _ in range(2):
        seen = plant.observe()
        assert seen.configuration == box.initial, f"{name} does not start as {box.name} does, or looking changes it"
        assert (seen.joint, seen.outcome) == (None, None), f"{name} reports an attempt before the first one"

"""The contract of an intervention."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, is_dataclass, replace
from typing import Any

import numpy as np

from lockprobe.interventions.catalogue import PLACES, interventions_of, place_of, spec_of
from lockprobe.protocols import Intervention
from lockprobe.record import Briefing, Moment, Percept, Task, Trial, Turn
from lockprobe.spec import settings_of
from lockprobe.studies.single import run_trial
from lockprobe.trial_json import trial_to_json

__all__ = ["check_intervention"]

AGENTS = ("random", "human-inspired", "cognitive:perseverant")
"""Who plays where a whole trial is looked at."""


def check_intervention(one: Intervention, *, doses: Sequence[object] = (0, 1)) -> None:
    """Check that an intervention fulfils its contract.

    It is a frozen dataclass that acts at exactly one place. A spec can name it, and its settings survive JSON. It keeps
    nothing between calls and draws equally often whatever its dose. At dose 0 every agent plays as in truth, byte for
    byte.

    Args:
        one: The intervention, with the settings to test.
        doses: Doses between which draws are compared; unused where it has no dose.

    Raises:
        AssertionError: If it breaks one of these; the message says which.
    """
    kind: Any = type(one)
    name, place = kind.__name__, place_of(kind)
    assert is_dataclass(kind) and getattr(kind, "__dataclass_params__").frozen, f"{name} is no frozen dataclass"  # noqa: B009, PT018
    assert interventions_of(spec_of(one)) == (one,), f"{name} is not made again by its spec {spec_of(one)!r}"
    settings = settings_of(one)
    assert json.loads(json.dumps(settings)) == settings, f"the settings of {name} do not survive JSON"
    dose = getattr(kind, "dose", None)
    same = [one] if dose is None else [one, *(replace(one, **{dose: value}) for value in doses)]  # type: ignore[type-var]
    calls = _calls(place)
    for other in same:
        first, again = (_answers(other, place, calls) for _ in range(2))
        assert first == again, f"{spec_of(other)} answers differently when it is asked again: it keeps something"
    states = {_state_after(other, place, calls) for other in same}
    assert len(states) == 1, f"{name} does not draw equally often at every dose"
    if dose is not None:
        _check_nothing_happens(replace(one, **{dose: 0}))  # type: ignore[type-var]


def _check_nothing_happens(none: Intervention) -> None:
    for agent in AGENTS:
        for seed in (1, 2, 3):
            truth, changed = (run_trial(agent=agent, seed=seed, condition=acting) for acting in ((), (none,)))
            assert _unnamed(truth) == _unnamed(changed), f"{agent} does not play as in truth under {spec_of(none)}"


def _unnamed(trial: Trial) -> bytes:
    """The record without the name of the condition."""
    return trial_to_json(replace(trial, key="", p=0.0, flip="", channels=(), interventions=(), condition="", schema=1))


@dataclass(frozen=True)
class _Witness:
    """Notes the arguments of an intervention at its place, and changes nothing."""

    seen: list[tuple[object, ...]] = field(default_factory=list)


class _Told(_Witness):
    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        self.seen.append((percept, past, task))
        return percept


class _Asked(_Witness):
    def brief(self, briefing: Briefing, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Briefing:
        self.seen.append((briefing, past, task))
        return briefing


class _Remembered(_Witness):
    def recall(self, past: tuple[Turn, ...], task: Task, rng: np.random.Generator) -> tuple[Turn, ...]:
        self.seen.append((past, task))
        return past


class _Done(_Witness):
    def act(self, joint: str, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> str:
        self.seen.append((joint, past, task))
        return joint


_WITNESSES: dict[str, Callable[[], Any]] = {"told": _Told, "asked": _Asked, "remembered": _Remembered, "done": _Done}


def _calls(place: str) -> list[tuple[object, ...]]:
    """The arguments of an intervention at this place in one trial."""
    witness = _WITNESSES[place]()
    run_trial(agent="random", condition=(witness,), max_steps=30, box="chain-7")
    calls: list[tuple[object, ...]] = witness.seen
    return calls


def _answers(one: Intervention, place: str, calls: Sequence[tuple[object, ...]]) -> list[object]:
    rng = np.random.default_rng(7)
    return [getattr(one, PLACES[place])(*call, rng) for call in calls]


def _state_after(one: Intervention, place: str, calls: Sequence[tuple[object, ...]]) -> str:
    rng = np.random.default_rng(7)
    for call in calls:
        getattr(one, PLACES[place])(*call, rng)
    return str(rng.bit_generator.state)

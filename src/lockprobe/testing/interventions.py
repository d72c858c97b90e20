"""The contract test of an intervention."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any

from lockprobe.foundation.plugins import allow
from lockprobe.foundation.spec import settings_of
from lockprobe.interventions.catalogue import interventions_of
from lockprobe.studies.modality import shown
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.condition import PLACES, place_of, spec_of
from lockprobe.trial.luck import Luck
from lockprobe.trial.protocols import Intervention, InterventionTraits
from lockprobe.trial.record import STATES, Percept, Trial
from lockprobe.trial.trial_json import trial_to_json

AGENTS = ("random", "human-inspired", "cognitive:perseverant")
"""Who plays where a whole trial is looked at."""


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
        AssertionError: If it breaks one of these; the message says which.
    """
    kind: Any = type(one)
    name, place = kind.__name__, place_of(kind)
    assert is_dataclass(kind) and getattr(kind, "__dataclass_params__").frozen, f"{name} is no frozen dataclass"  # noqa: B009, PT018
    allow(spec_of(one))
    assert interventions_of(spec_of(one)) == (one,), f"{name} is not made again by its spec {spec_of(one)!r}"
    settings = settings_of(one)
    assert json.loads(json.dumps(settings)) == settings, f"the settings of {name} do not survive JSON"
    traits = InterventionTraits.of(one)
    named = traits.doses
    assert isinstance(named, tuple), f"doses of {name} is no tuple of names of its options: {named!r}"
    same = [one, *(replace(one, **{named[0]: value}) for value in doses if named)]  # type: ignore[type-var]
    calls = _calls(place)
    for other in same:
        first, again = (_answers(other, place, calls) for _ in range(2))
        assert first == again, f"{spec_of(other)} answers differently when it is asked again: it keeps something"
    if place == "told" and traits.always_tells:
        told: Any = _answers(one, place, calls)
        assert all(percept.positions for percept in told), f"{name} leaves a report out: it must not have always_tells"
    if place == "told" and not traits.after_words:
        _check_shown(one, calls, modality)
    if named:
        _check_nothing_happens(replace(one, **{named[0]: 0}))  # type: ignore[type-var]


def _check_shown(one: Intervention, calls: Sequence[tuple[object, ...]], modality: str) -> None:
    """Check that a report shows some of what it changes, if it changes anything in these calls."""
    given: Sequence[Any] = [call[0] for call in calls]
    answers: Any = _answers(one, "told", calls)
    changed = {
        field.name
        for before, after in zip(given, answers, strict=True)
        for field in fields(Percept)
        if field.compare and getattr(before, field.name) != getattr(after, field.name)
    }
    words: Any = shown(modality)
    unseen = all(words.shown(before) == words.shown(after) for before, after in zip(given, answers, strict=True))
    assert not (changed and unseen), (
        f"{type(one).__name__} changes {', '.join(sorted(changed))}, and no report in {modality} shows that: {_SHOWN}"
    )


_SHOWN = (
    "symbolic?tell=state shows joint and positions, symbolic (modality=) outcome too, and text is written afterwards "
    "(after_words = True)"
)


def _check_nothing_happens(none: Intervention) -> None:
    for agent in AGENTS:
        for seed in (1, 2, 3):
            truth, changed = (run_trial(agent=agent, seed=seed, condition=acting) for acting in ((), (none,)))
            assert _unnamed(truth) == _unnamed(changed), f"{agent} does not play as in truth under {spec_of(none)}"


def _unnamed(trial: Trial) -> bytes:
    """The record without the name of the condition."""
    return trial_to_json(
        replace(
            trial, key="", condition="", specs=(), doses={}, channels=(), interventions=(), changed={}, changed_steps=0
        )
    )


def _calls(place: str) -> list[tuple[object, ...]]:
    """The arguments of an intervention at this place in one trial, without the random stream."""
    calls: list[tuple[object, ...]] = []

    def note(witness: object, given: object, *rest: object) -> object:
        calls.append((given, *rest[:-1]))
        return given

    witness: Any = type("Witness", (), {PLACES[place]: note})()
    run_trial(agent="random", condition=(witness,), max_steps=30, box="chain-7")
    return calls


def _answers(one: Intervention, place: str, calls: Sequence[tuple[object, ...]]) -> list[object]:
    """The answers to these calls, each with the luck of its own step."""
    luck = Luck(seed=7, box="chain-7", repetition=1, trial=1).stream(type(one).__name__)
    return [getattr(one, PLACES[place])(*call, luck.at(step)) for step, call in enumerate(calls)]

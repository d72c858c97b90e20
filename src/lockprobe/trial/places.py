"""The interventions of a condition by the place at which they act, and what the record of every trial says of them."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, is_dataclass
from typing import Self

from lockprobe.foundation.spec import settings_of
from lockprobe.trial.condition import spec_of
from lockprobe.trial.protocols import Actuator, Channel, Intervention, InterventionTraits, Memory, Prompt
from lockprobe.trial.record import Fact, Percept


@dataclass(frozen=True, slots=True, kw_only=True)
class Places:
    """Interventions, and at which place of the loop each of them acts.

    All trials of a condition have it alike, so it is made once for them.

    Attributes:
        all: The interventions, in the order in which they act. The other attributes hold their numbers in it.
        streams: The name of the random stream of each, and how many trials ahead it lies.
        channels: Those that change reports before these become words or pictures.
        showing: The one that makes words or pictures; empty without one.
        after: Those that change words or pictures.
        prompts, memories, actuators: Those that act where the agent is asked, remembers and attempts.
        shown: What the agent gets of a report.
        specs: The spec of each that has one, with its number among equal ones.
        channel_facts: What records say of those that act on reports.
        other_facts: What records say of all others.
    """

    all: tuple[Intervention, ...]
    streams: tuple[tuple[str, int], ...]
    channels: tuple[int, ...]
    showing: tuple[int, ...]
    after: tuple[int, ...]
    prompts: tuple[int, ...]
    memories: tuple[int, ...]
    actuators: tuple[int, ...]
    shown: Callable[[Percept], object]
    specs: Mapping[int, str]
    channel_facts: tuple[Mapping[str, Fact], ...]
    other_facts: tuple[Mapping[str, Fact], ...]

    @classmethod
    def of(cls, interventions: Sequence[Intervention]) -> Self:
        """The places of interventions, in the order in which they act."""
        every = tuple(interventions)
        traits = [InterventionTraits.of(one) for one in every]
        told = [number for number, one in enumerate(every) if isinstance(one, Channel)]
        others = [number for number in range(len(every)) if number not in told]
        last = max((at for at, number in enumerate(told) if traits[number].shows), default=len(told))
        showing = tuple(told[last : last + 1])
        return cls(
            all=every,
            streams=_streams(every),
            channels=tuple(told[:last]),
            showing=showing,
            after=tuple(told[last + 1 :]),
            prompts=tuple(number for number in others if isinstance(every[number], Prompt)),
            memories=tuple(number for number in others if isinstance(every[number], Memory)),
            actuators=tuple(number for number in others if isinstance(every[number], Actuator)),
            shown=next((shown for number in showing if (shown := traits[number].shown)), whole),
            specs=_specs(every),
            channel_facts=tuple(_said(every[number], "channel") for number in told),
            other_facts=tuple(_said(every[number], "intervention") for number in others),
        )


def _streams(interventions: Sequence[Intervention]) -> tuple[tuple[str, int], ...]:
    """The random stream of each intervention, named after its kind and its number among those of its kind.

    So an intervention has the same luck whatever else is in its condition. Its ``stream`` and ``ahead``
    (:class:`lockprobe.trial.protocols.InterventionTraits`) give it another.
    """
    seen: Counter[str] = Counter()
    streams = list[tuple[str, int]]()
    for one in interventions:
        kind, traits = type(one).__name__, InterventionTraits.of(one)
        streams.append((f"{traits.stream or kind}-{seen[kind]}", traits.ahead))
        seen[kind] += 1
    return tuple(streams)


def whole(value: object) -> object:
    """All of a value, and its way to take a picture if it has one: equality leaves that out."""
    return value, getattr(value, "look", None)


def facts_of(said: Mapping[str, object]) -> dict[str, Fact]:
    """Facts as a record holds them: what is neither text, number nor truth value is written as text."""
    facts: dict[str, Fact] = {}
    for name, value in said.items():
        plain = value is None or isinstance(value, str | int) or (isinstance(value, float) and math.isfinite(value))
        facts[str(name)] = value if plain else str(value)  # type: ignore[assignment]
    return facts


def _said(one: Intervention, what: str) -> dict[str, Fact]:
    """The specification of an intervention: its class and its settings."""
    return facts_of({what: type(one).__name__} | (settings_of(one) if is_dataclass(one) else {}))


def _specs(interventions: Sequence[Intervention]) -> dict[int, str]:
    """The number of every intervention that has a spec -> the spec, and how often it came before if it did."""
    seen: Counter[str] = Counter()
    names: dict[int, str] = {}
    for number, one in enumerate(interventions):
        if is_dataclass(one) and not InterventionTraits.of(one).shows:
            spec = spec_of(one)
            seen[spec] += 1
            names[number] = spec if seen[spec] == 1 else f"{spec} ({seen[spec]})"
    return names

"""The interventions of a condition at their places in the loop."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import is_dataclass
from typing import Any, NamedTuple

import numpy as np

from lockprobe.foundation.spec import settings_of
from lockprobe.trial.condition import PLACES, spec_of
from lockprobe.trial.protocols import Intervention, InterventionTraits
from lockprobe.trial.record import Fact, Moment, Task, facts_of


class Placed(NamedTuple):
    """An intervention at its place.

    Attributes:
        number: Its number in the condition, from 0.
        traits: What its class declares.
        stream: Its random stream, named after its kind and its number among those of its kind: an intervention has the
            same luck whatever else is in its condition.
        act: Makes of a value, the past, the task and its luck at the step another value.
    """

    number: int
    one: Intervention
    traits: InterventionTraits
    stream: str
    act: Callable[[Any, tuple[Moment, ...], Task, np.random.Generator], Any]


class Places:
    """Interventions, and at which place of the loop each of them acts. All trials of a condition have them alike.

    Attributes:
        specs: The spec of each, and how often it came before if it did; empty for what makes words or pictures.
        at: Those of each place, in the order in which they act; of those that change what is *told*, the ones that act
            before reports become words or pictures.
        showing: The one that makes words or pictures; None without one.
        after: Those that get reports as the agent does; none of them is in a condition.
        channel_facts, other_facts: What records say of those that act on reports, and of all others: the class of each
            and its settings.
    """

    def __init__(self, interventions: Sequence[Intervention]) -> None:
        seen, self.specs = Counter[str](), list[str]()
        self.at: dict[str, list[Placed]] = {place: [] for place in PLACES}
        facts: dict[bool, list[Mapping[str, Fact]]] = {True: [], False: []}
        for number, one in enumerate(interventions):
            kind, traits, told = type(one).__name__, InterventionTraits.of(one), hasattr(one, PLACES["told"])
            spec = spec_of(one) if is_dataclass(one) and traits.shown is None else ""
            self.specs.append(f"{spec} ({seen[spec] + 1})" if spec and seen[spec] else spec)
            stream = f"{traits.stream or kind}-{seen[f'class {kind}']}"
            seen.update((spec, f"class {kind}"))
            for place, method in PLACES.items():
                if (act := getattr(one, method, None)) is not None:
                    self.at[place].append(Placed(number, one, traits, stream, act))
            said = {"channel" if told else "intervention": kind} | (settings_of(one) if is_dataclass(one) else {})
            facts[told].append(facts_of(said))
        channels = self.at["told"]
        last = max((at for at, one in enumerate(channels) if one.traits.shown is not None), default=len(channels))
        self.at["told"], self.after = channels[:last], channels[last + 1 :]
        self.showing = channels[last] if last < len(channels) else None
        self.channel_facts, self.other_facts = tuple(facts[True]), tuple(facts[False])

"""The interventions of a condition at their places in the loop: what they are, and what they do in one trial."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import is_dataclass, replace
from typing import Any, NamedTuple, TypeVar

import numpy as np

from lockprobe.foundation.errors import ChannelFault
from lockprobe.foundation.spec import settings_of
from lockprobe.trial.condition import PLACES, spec_of
from lockprobe.trial.plan import Plan
from lockprobe.trial.protocols import Intervention, InterventionTraits
from lockprobe.trial.record import Fact, Moment, Percept, Task, facts_of

_V = TypeVar("_V")


class Placed(NamedTuple):
    """An intervention at its place: its number in the condition, from 0, what its class declares, and what it does.

    ``act`` makes of a value, the past, the task and its luck at the step another value.
    """

    number: int
    one: Intervention
    traits: InterventionTraits
    act: Callable[[Any, tuple[Moment, ...], Task, np.random.Generator], Any]


class Places:
    """Interventions, and at which place of the loop each of them acts. All trials of a condition have them alike.

    Attributes:
        streams: The random stream of each. It is named after its kind and its number among those of its kind, so an
            intervention has the same luck whatever else is in its condition.
        specs: The spec of each, and how often it came before if it did; empty for what makes words or pictures.
        at: Those of each place, in the order in which they act; of those that change what is *told*, the ones that act
            before reports become words or pictures.
        showing: The one that makes words or pictures; empty without one.
        after: Those that change words or pictures.
        channel_facts, other_facts: What records say of those that act on reports, and of all others: the class of each
            and its settings.
    """

    def __init__(self, interventions: Sequence[Intervention]) -> None:
        seen = Counter[str]()
        self.streams, self.specs = list[str](), list[str]()
        self.at: dict[str, list[Placed]] = {place: [] for place in PLACES}
        facts: dict[bool, list[Mapping[str, Fact]]] = {True: [], False: []}
        for number, one in enumerate(interventions):
            kind, traits, told = type(one).__name__, InterventionTraits.of(one), hasattr(one, PLACES["told"])
            spec = spec_of(one) if is_dataclass(one) and traits.shown is None else ""
            self.specs.append(f"{spec} ({seen[spec] + 1})" if spec and seen[spec] else spec)
            self.streams.append(f"{traits.stream or kind}-{seen[f'class {kind}']}")
            seen.update((spec, f"class {kind}"))
            for place, method in PLACES.items():
                if (act := getattr(one, method, None)) is not None:
                    self.at[place].append(Placed(number, one, traits, act))
            said = {"channel" if told else "intervention": kind} | (settings_of(one) if is_dataclass(one) else {})
            facts[told].append(facts_of(said))
        channels = self.at["told"]
        last = max((at for at, one in enumerate(channels) if one.traits.shown is not None), default=len(channels))
        self.at["told"], self.showing, self.after = channels[:last], channels[last : last + 1], channels[last + 1 :]
        self.channel_facts, self.other_facts = tuple(facts[True]), tuple(facts[False])


class Acting:
    """The interventions of one trial: what they tell, let remember, ask and do, and at which steps.

    An intervention changes a step if it changed what it was given, and the agent would have got something else without
    it: what no report shows, or a later intervention hides, is no change. A report counts at the step whose decision it
    precedes: no agent reads the last one. ``past`` holds all moments so far, so its length is the number of the step,
    or, for a report, the number of that step's decision less one.
    """

    def __init__(self, places: Places, plan: Plan) -> None:
        self._places, self._task, self._fork = places, plan.names.task, plan.fork
        self._changed: dict[int, set[int]] = defaultdict(set)
        self._together: set[int] = set()
        self.luck = plan.luck

    def told(self, percept: Percept, past: tuple[Moment, ...]) -> tuple[Percept, Percept | None]:
        """What the agent gets of a report, and the facts from which words or pictures were made.

        Without a way to look, which is for channels. The facts are None where the report holds them itself.
        ``ChannelFault`` for a value that no record can hold, or it breaks.
        """
        facts, places, step, joints = None, self._places, len(past), self._task.joints
        shown = places.showing[0].traits.shown if places.showing else None
        percept = self._passed(self._heard(places.at["told"], step), percept, past, step, step + 1, shown)
        for placed in places.showing:
            facts = percept if percept.look is None else replace(percept, look=None)
            percept = placed.act(percept, past, self._task, self._rng(placed, step))
        if places.after:
            worded, percept = percept, self._passed(self._heard(places.after, step), percept, past, step, step + 1)
            if (worded.outcome, worded.positions) != (percept.outcome, percept.positions):
                facts = None  # something after the words changed what is told: that holds the facts now
        percept.text.encode()
        if percept.joint is not None and percept.joint not in joints:
            raise ChannelFault(f"{percept.joint!r} is not a joint")
        positions = percept.positions
        if positions is not None and not (len(positions) == len(joints) and {*positions} <= {False, True}):
            raise ChannelFault(f"positions {positions!r} are not one truth value for each of {len(joints)} joints")
        return percept if percept.look is None else replace(percept, look=None), facts

    def _rng(self, placed: Placed, step: int) -> np.random.Generator:
        return self.luck.at(self._places.streams[placed.number], step)

    def _heard(self, channels: Sequence[Placed], step: int) -> Sequence[Placed]:
        """Those that act on the report of a step: an arm of a fork acts in place of those that act on its facts."""
        fork = self._fork
        if fork is None or not fork.replaces(step):
            return channels
        own = {id(one) for one in fork.acting}
        return [one for one in channels if one.traits.after_words or id(one.one) in own]

    def passed(self, place: str, value: _V, past: tuple[Moment, ...]) -> _V:
        """What is remembered, asked or done after the interventions of that place; their luck is that of the step.

        What is remembered and asked has the luck of the report before.
        """
        step = len(past)
        return self._passed(self._places.at[place], value, past, step - (place != "done"), step)

    def changes(self, steps: int) -> tuple[dict[str, int], int]:
        """Of so many steps, those that each intervention with a spec changed, and those that all together did."""
        counts = Counter(number for step, numbers in self._changed.items() if step <= steps for number in numbers)
        changed = {spec: counts[number] for number, spec in enumerate(self._places.specs) if spec}
        return changed, sum(step <= steps for step in self._together)

    def _passed(
        self,
        acting: Sequence[Placed],
        given: _V,
        past: tuple[Moment, ...],
        drawn: int,
        noted: int,
        shown: Callable[[Any], object] | None = None,
    ) -> _V:
        """A value after interventions; those of them that changed what the agent gets are noted.

        ``drawn`` is the step of their luck, ``noted`` that at which their changes count. ``shown`` is the part of the
        value that the agent gets; all of it without one.
        """
        value, shown = given, shown or (lambda whole: whole)
        changers: list[tuple[Placed, _V]] = []
        for placed in acting:
            before, value = value, placed.act(value, past, self._task, self._rng(placed, drawn))
            if value is not before and value != before:
                changers.append((placed, before))
        if changers:
            end = shown(value)
            if shown(given) != end:
                self._together.add(noted)
            for at, (placed, before) in enumerate(changers, 1):
                try:  # what the agent would have got without it: later ones act again, on the value before it
                    without = before
                    for later, _ in changers[at:]:
                        without = later.act(without, past, self._task, self._rng(later, drawn))
                    changed = shown(without) != end
                except Exception:  # noqa: BLE001  one that breaks needs what was changed before it
                    changed = True
                if changed:
                    self._changed[noted].add(placed.number)
        return value

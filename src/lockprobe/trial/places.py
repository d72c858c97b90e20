"""The interventions of a condition at their places in the loop: what they are, and what they do in one trial."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, is_dataclass, replace
from typing import Generic, NamedTuple, Self, TypeVar

import numpy as np

from lockprobe.foundation.errors import ChannelFault
from lockprobe.foundation.spec import settings_of
from lockprobe.trial.briefing import Briefing
from lockprobe.trial.condition import spec_of
from lockprobe.trial.luck import Luck
from lockprobe.trial.plan import Fork
from lockprobe.trial.protocols import Actuator, Channel, Intervention, InterventionTraits, Memory, Prompt
from lockprobe.trial.record import Fact, Moment, Percept, Task, Turn, facts_of

_V = TypeVar("_V")
_Turns = tuple[Turn, ...]


class Placed(NamedTuple, Generic[_V]):
    """An intervention at one place, as a function of a value, the past, the task and its luck at the step.

    Attributes:
        number: Its number in the condition, from 0.
        one: The intervention.
        act: What it makes of the value.
    """

    number: int
    one: Intervention
    act: Callable[[_V, tuple[Moment, ...], Task, np.random.Generator], _V]


@dataclass(frozen=True, slots=True, kw_only=True)
class Places:
    """Interventions, and at which place of the loop each of them acts.

    All trials of a condition have it alike, so it is made once for them.

    Attributes:
        streams: The name of the random stream of each, and how many trials ahead it lies.
        channels: Those that change reports before these become words or pictures, in the order in which they act.
        showing: The one that makes words or pictures; empty without one.
        after: Those that change words or pictures.
        prompts, memories, actuators: Those that act where the agent is asked, remembers and attempts.
        shown: What the agent gets of a report.
        specs: The number of each that has a spec -> the spec, and how often it came before if it did.
        channel_facts: What records say of those that act on reports.
        other_facts: What records say of all others.
    """

    streams: tuple[tuple[str, int], ...]
    channels: tuple[Placed[Percept], ...]
    showing: tuple[Placed[Percept], ...]
    after: tuple[Placed[Percept], ...]
    prompts: tuple[Placed[Briefing], ...]
    memories: tuple[Placed[_Turns], ...]
    actuators: tuple[Placed[str], ...]
    shown: Callable[[Percept], object]
    specs: Mapping[int, str]
    channel_facts: tuple[Mapping[str, Fact], ...]
    other_facts: tuple[Mapping[str, Fact], ...]

    @classmethod
    def of(cls, interventions: Sequence[Intervention]) -> Self:
        """The places of interventions, in the order in which they act."""
        every = list(enumerate(interventions))
        traits = [InterventionTraits.of(one) for one in interventions]
        told = [Placed(number, one, one.perceive) for number, one in every if isinstance(one, Channel)]
        last = max((at for at, placed in enumerate(told) if traits[placed.number].shows), default=len(told))
        showing = tuple(told[last : last + 1])
        return cls(
            streams=_streams(interventions),
            channels=tuple(told[:last]),
            showing=showing,
            after=tuple(told[last + 1 :]),
            prompts=tuple(Placed(number, one, one.brief) for number, one in every if isinstance(one, Prompt)),
            memories=tuple(Placed(number, one, _recall(one)) for number, one in every if isinstance(one, Memory)),
            actuators=tuple(Placed(number, one, one.act) for number, one in every if isinstance(one, Actuator)),
            shown=next((shown for placed in showing if (shown := traits[placed.number].shown)), _whole),
            specs=_specs(interventions),
            channel_facts=tuple(_said(placed.one, "channel") for placed in told),
            other_facts=tuple(_said(one, "intervention") for one in interventions if not isinstance(one, Channel)),
        )


def _recall(memory: Memory) -> Callable[[_Turns, object, Task, np.random.Generator], _Turns]:
    return lambda turns, past, task, rng: memory.recall(turns, task, rng)


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


def _specs(interventions: Sequence[Intervention]) -> dict[int, str]:
    seen: Counter[str] = Counter()
    names: dict[int, str] = {}
    for number, one in enumerate(interventions):
        if is_dataclass(one) and not InterventionTraits.of(one).shows:
            spec = spec_of(one)
            seen[spec] += 1
            names[number] = spec if seen[spec] == 1 else f"{spec} ({seen[spec]})"
    return names


def _said(one: Intervention, what: str) -> dict[str, Fact]:
    """The class of an intervention and its settings."""
    return facts_of({what: type(one).__name__} | (settings_of(one) if is_dataclass(one) else {}))


class Acting:
    """The interventions of one trial: what they tell, let remember, ask and do, and at which steps.

    An intervention changes a step if it changed what it was given, and the agent would have got something else without
    it: what no report shows, or a later intervention hides, is no change. A report counts at the step whose decision it
    precedes: no agent reads the last one. ``past`` holds all moments so far, so its length is the number of the step,
    or, for a report, the number of that step's decision less one.
    """

    def __init__(self, places: Places, luck: Luck, task: Task, fork: Fork | None) -> None:
        self._places, self._task, self._fork = places, task, fork
        self._changed: dict[int, set[int]] = defaultdict(set)
        self._together: set[int] = set()
        self.deal(luck)

    def deal(self, luck: Luck) -> None:
        """Give every intervention its random stream."""
        self._luck = [luck.stream(name, ahead) for name, ahead in self._places.streams]

    def told(self, percept: Percept, past: tuple[Moment, ...]) -> tuple[Percept, Percept | None]:
        """What the agent gets of a report, and the facts from which words or pictures were made.

        Without a way to look, which is for channels. The facts are None where the report holds them itself.

        Raises:
            ChannelFault: If no record can hold it.
        """
        facts, places, step = None, self._places, len(past)
        if places.channels:
            channels = self._not_replaced(places.channels, step)
            percept = self._passed(channels, percept, past, step, step + 1, places.shown)
        for placed in places.showing:
            facts = percept if percept.look is None else without_look(percept)
            percept = placed.act(percept, past, self._task, self._luck[placed.number].at(step))
        if places.after:
            worded = percept
            percept = self._passed(self._not_replaced(places.after, step), percept, past, step, step + 1)
            if (worded.outcome, worded.positions) != (percept.outcome, percept.positions):
                facts = None  # something after the words changed what is told: that holds the facts now
        _check_report(percept, self._task.joints)
        return percept if percept.look is None else without_look(percept), facts

    def _not_replaced(self, channels: tuple[Placed[Percept], ...], step: int) -> Sequence[Placed[Percept]]:
        """Those that act on the report of a step: an arm of a fork acts in place of those that act on its facts."""
        fork = self._fork
        if fork is None or not fork.replaces(step):
            return channels
        traits = [InterventionTraits.of(placed.one) for placed in channels]
        on_words = [placed for placed, of in zip(channels, traits, strict=True) if of.shows or of.after_words]
        return [one for one in channels if one in on_words or any(one.one is acting for acting in fork.acting)]

    def remembered(self, turns: tuple[Turn, ...], past: tuple[Moment, ...]) -> tuple[Turn, ...]:
        """The exchanges that the agent still has.

        Raises:
            ChannelFault: If a memory returns none.
        """
        left = self._passed(self._places.memories, turns, past, len(past) - 1, len(past))
        if not isinstance(left, tuple):
            raise ChannelFault(f"recall returned {type(left).__name__}, and no tuple of turns")
        return left

    def asked(self, briefing: Briefing, past: tuple[Moment, ...]) -> Briefing:
        """The requests and remarks of a step."""
        asked = self._passed(self._places.prompts, briefing, past, len(past) - 1, len(past))
        asked.remark.encode()  # what no record can hold breaks here
        return asked

    def done(self, chosen: str, past: tuple[Moment, ...]) -> str:
        """The label of the joint that is really attempted.

        Raises:
            ChannelFault: If there is no such joint.
        """
        joint = self._passed(self._places.actuators, chosen, past, len(past), len(past))
        if joint not in self._task.joints:
            raise ChannelFault(f"{joint!r} is not a joint")
        return joint

    def changes(self, steps: int) -> tuple[dict[str, int], int]:
        """Of so many steps, those that each intervention with a spec changed, and those that all together did."""
        counts = Counter(number for step, numbers in self._changed.items() if step <= steps for number in numbers)
        return (
            {spec: counts[number] for number, spec in self._places.specs.items()},
            sum(step <= steps for step in self._together),
        )

    def _passed(
        self,
        acting: Sequence[Placed[_V]],
        given: _V,
        past: tuple[Moment, ...],
        drawn: int,
        noted: int,
        shown: Callable[[_V], object] | None = None,
    ) -> _V:
        """A value after interventions; those of them that changed what the agent gets are noted.

        ``drawn`` is the step of their luck, ``noted`` that at which their changes count. ``shown`` is the part of the
        value that the agent gets; all of it without one.
        """
        value = given
        changers: list[tuple[Placed[_V], _V]] = []
        for placed in acting:
            before, value = value, placed.act(value, past, self._task, self._luck[placed.number].at(drawn))
            if value is not before and _whole(value) != _whole(before):
                changers.append((placed, before))
        if changers:
            shown = shown or _whole
            end = shown(value)
            if shown(given) != end:
                self._together.add(noted)
            for at, (placed, before) in enumerate(changers, 1):
                later = [other for other, _ in changers[at:]]
                if self._shown_without(before, later, past, drawn, shown) != end:
                    self._changed[noted].add(placed.number)
        return value

    def _shown_without(
        self,
        value: _V,
        later: Sequence[Placed[_V]],
        past: tuple[Moment, ...],
        drawn: int,
        shown: Callable[[_V], object],
    ) -> object:
        """What the agent would have got without an intervention: ``later`` ones act again, on the value before it.

        One that breaks needs what was changed before it.
        """
        try:
            for placed in later:
                value = placed.act(value, past, self._task, self._luck[placed.number].at(drawn))
            return shown(value)
        except Exception:  # noqa: BLE001  anybody's code runs here, and the trial has gone on without this
            return object()


def _check_report(percept: Percept, joints: tuple[str, ...]) -> None:
    """Refuse a report that no record can hold, of channels that anybody may have written."""
    percept.text.encode()  # breaks if it is no text, or none that can be written
    if percept.joint is not None and percept.joint not in joints:
        raise ChannelFault(f"{percept.joint!r} is not a joint")
    positions = percept.positions
    if positions is not None and not (len(positions) == len(joints) and {*positions} <= {False, True}):
        raise ChannelFault(f"positions {positions!r} are not one truth value for each of {len(joints)} joints")


def _whole(value: object) -> object:
    """All of a value, and its way to take a picture if it has one: equality leaves that out."""
    return value, getattr(value, "look", None)


def without_look(percept: Percept) -> Percept:
    """The percept without a way to take a picture."""
    return replace(percept, look=None)

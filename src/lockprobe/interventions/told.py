"""What is *told*, beside the flip: reports that are missing, late, corrected, or false of another joint."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from lockprobe.foundation.validation import Checked, Share, StepNumber, Within
from lockprobe.interventions.flip import Inverts, OutcomeFlip
from lockprobe.trial.record import Moment, Percept, Task

if TYPE_CHECKING:
    import numpy as np

Luck = Literal["own", "flip"]
"""With ``flip`` the numbers come from the stream of the flip: equal doses hit equal steps."""

Says = Literal["lie", "truth"]
"""What a statement says: a false report, or the true one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AtRate(Checked):
    """An intervention that hits each step with probability p; the steps at a smaller p are among those at a larger one.

    They are those at which ``flip`` lies at the same p. Only the steps ``at`` can be hit, or all if there is none.
    """

    name: ClassVar[str]
    doses: ClassVar[tuple[str, ...]] = ("p",)
    stream: ClassVar[str] = OutcomeFlip.stream
    p: Share = 0.0

    def hits(self, drawn: float, step: int) -> bool:
        """Whether it acts at a step for which this number was drawn, in [0, 1)."""
        return drawn < self.p and (not (at := getattr(self, "at", ())) or step in at)


@dataclass(frozen=True, slots=True, kw_only=True)
class AtRandomSteps(AtRate):
    """One that hits random steps of its own, unless its ``luck`` is that of the flip."""

    luck: Luck = "own"
    at: tuple[StepNumber, ...] = ()

    @property
    def stream(self) -> str:  # type: ignore[override]  # that of the class is the flip's
        """The name of its random stream."""
        return OutcomeFlip.stream if self.luck == "flip" else type(self).__name__


@dataclass(frozen=True, slots=True, kw_only=True)
class Drop(AtRandomSteps):
    """With probability p the report of an attempt is missing; the box and all other reports stay unchanged."""

    name: ClassVar[str] = "drop"

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept, or an empty one."""
        if percept.joint is None or not self.hits(rng.random(), len(past)):
            return percept
        return replace(percept, outcome=None, positions=None, corrects=None)


@dataclass(frozen=True, slots=True, kw_only=True)
class Delay(Checked):
    """Every report is late: it tells the truth of ``lag`` attempts ago, and names the joint attempted then.

    Until the first late report nothing is told. Each report starts from the truth, so changes by earlier interventions
    are lost. Nothing is drawn.
    """

    name: ClassVar[str] = "delay"
    doses: ClassVar[tuple[str, ...]] = ("lag",)
    lag: Annotated[int, Within(0)] = 1

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept of some attempts ago."""
        if percept.joint is None or self.lag == 0:
            return percept
        # the first look is no report of an attempt
        late = past[len(past) - self.lag].was if len(past) > self.lag else Percept()
        return replace(percept, joint=late.joint, outcome=late.outcome, positions=late.positions, corrects=None)


@dataclass(frozen=True, slots=True, kw_only=True)
class Phantom(AtRate):
    """With probability p a report tells a false position of one joint that was not attempted.

    Each of the other joints is equally likely. The next report tells its true position again, unless a flip keeps false
    positions, and no told outcome is changed: so a phantom has what a false report has, a false position and its
    correction, without the false outcome. Where reports tell no outcomes, an agent that compares two reports is misled
    if it attempts the very joint next.
    """

    name: ClassVar[str] = "phantom"
    always_tells: ClassVar[bool] = True

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept with the position of another joint inverted, or not."""
        if percept.joint is None:
            return percept
        (drawn, which), positions = rng.random(2), percept.positions
        others = [place for place, label in enumerate(task.joints) if label != percept.joint]
        if drawn >= self.p or positions is None or not others:
            return percept
        jumps = others[int(which * len(others))]
        return replace(percept, positions=tuple(at ^ (place == jumps) for place, at in enumerate(positions)))


@dataclass(frozen=True, slots=True, kw_only=True)
class Correction(AtRate):
    """With probability p a report is made of two statements: the first, and with the word "Correction" the last.

    The four combinations have one form and differ in what they say: a lie that the truth corrects (the default), a
    truth that is repeated, a truth that a lie "corrects", and a lie that is repeated. A lie is the false report that
    ``flip`` with these ``inverts`` and ``others`` tells, and later reports agree with the last statement. Corrections
    are made in words; pictures cannot be corrected.
    """

    name: ClassVar[str] = "correction"
    always_tells: ClassVar[bool] = True
    first: Says = "lie"
    last: Says = "truth"
    inverts: Inverts = "outcome"
    others: Literal["fresh", "kept"] = "fresh"
    at: tuple[StepNumber, ...] = ()

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept as its last statement tells it, with the first one if it is corrected."""
        if percept.joint is None:
            return percept
        lies = OutcomeFlip(p=self.p, inverts=self.inverts, others=self.others)
        hit = self.hits(rng.random(), len(past))

        def said(says: Says) -> Percept:
            if self.last == says == "truth":  # nothing that was told stays false
                return percept
            return lies.told(percept, past, task, flipped=hit and says == "lie", lasting=-int(lies.keep))

        last = said(self.last)
        return replace(last, corrects=said(self.first)) if hit else last

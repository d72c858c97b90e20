"""The intervention ``flip``: false reports, the noise of the paper (Sec. 3.2). The box stays as it is.

``flip?like=…`` tells them at the rates at which an agent misread what its attempts did: a confusion matrix by joint, as
text in a spec. ``slider:0.2:0.05`` says that of the attempts that moved the slider 20 % were taken for failures (hidden
moves), and of those that did not 5 % for moves (invented moves).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any, ClassVar, Literal, get_args

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import Spec, with_options
from lockprobe.foundation.validation import Checked, Share, StepNumber, check_choice
from lockprobe.trial.record import Moment, Percept, Task

if TYPE_CHECKING:  # the options of a study rest on this module, and their help needs no arithmetic
    import numpy as np

    from lockprobe.statistics.misinterpretation import Claim
    from lockprobe.trial.plan import Plan

FlipKind = Literal[
    "transient", "sticky", "outcome-only", "memoryless", "latched", "independent", "re-observed", "integrated"
]
"""What ``--flip`` takes: the readings of a false report by the first word of their names, and short words for three
studies. ``transient`` is memoryless, ``sticky`` is latched; ``outcome-only`` is re-observed and tells no positions."""

DEFAULT: FlipKind = "re-observed"
"""The reading of the paper's study. The paper leaves the reading open, so this is a judgement: it is the only one that
inverts a share p of the outcomes (Sec. 3.2), tells them through states, and shows the other joints as they are, as the
next picture would ("mimicking the effect of misinterpreting a visual observation")."""


Inverts = Literal["position", "outcome"]
Others = Literal["fresh", "kept", "partly", "noisy"]
Part = Literal["both", "outcome", "position"]
Only = Literal["moved", "blocked", "any"]
While = Literal["looping", "always"]

READINGS: Mapping[tuple[Inverts, Others], str] = {
    ("position", "fresh"): "memoryless state noise",
    ("position", "kept"): "latched state noise",
    ("position", "partly"): "partly latched state noise",
    ("position", "noisy"): "independent state noise",
    ("outcome", "fresh"): "re-observed outcome noise",
    ("outcome", "kept"): "integrated outcome noise",
    ("outcome", "partly"): "partly integrated outcome noise",
}
"""What is inverted, and what becomes of the false positions of other joints -> the name of the reading."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OutcomeFlip(Checked):
    """With probability ``p`` the report says the opposite of what the action did (paper, Sec. 3.2).

    The paper leaves open how, in two respects. What is inverted:

    * ``inverts=outcome``: the opposite outcome is told, and the position that follows from it and from what was told of
      the joint before. So exactly a share ``p`` of the outcomes that an agent infers by comparing reports is inverted.
    * ``inverts=position``: the outcome in the report and the reported position of the attempted joint are the opposite
      of the true ones.

    What becomes of the false positions of other joints:

    * ``others=fresh``: their positions are true in every report.
    * ``others=kept``: they stay as they were last told, until their joint is attempted.
    * ``keep``: each false one survives a report with this probability; 0 is ``fresh``, 1 is ``kept``.
    * ``others=noisy``: each of them is inverted with probability ``p`` too, in every report and independently.

    A false report has two parts. ``part`` tells one of them alone, to an agent that is told outcomes and positions:

    * ``part=outcome``: the outcome in the report is the opposite one, and all positions are true.
    * ``part=position``: the outcome in the report is true, and the reported position of the attempted joint is not.

    The flips at a smaller ``p`` are a subset of those at a larger one, the surviving positions at a smaller ``keep``
    are a subset too, and further options only leave some flips out. Above p = 0.5 the report is informative again,
    with its meaning inverted. A report that says nothing is not inverted.

    Attributes:
        p, keep: Probabilities, [0, 1].
        others: As above; ``partly`` with ``keep`` between 0 and 1.
        only: Which outcomes are inverted.
        at: The steps, from 1, whose reports can be inverted; empty for all of them. In a spec: ``at=4;8``.
        while_: With ``looping`` only a report is inverted whose attempt continues an action loop: the last three
            attempts, this one among them, have stood in this order before, and not overlapping.
    """

    name: ClassVar[str] = "flip"
    doses: ClassVar[tuple[str, ...]] = ("p", "keep")
    stream: ClassVar[str] = "channel"
    always_tells: ClassVar[bool] = True
    p: Share = 0.0
    inverts: Inverts = "outcome"
    others: Others = "fresh"
    keep: Share = 0.0
    part: Part = "both"
    only: Only = "any"
    at: tuple[StepNumber, ...] = ()
    while_: While = "always"

    def __post_init__(self) -> None:
        Checked.__post_init__(self)
        if self.part == "outcome" and (self.inverts, self.others, self.keep) != ("outcome", "fresh", 0):
            raise BadValue("part", self.part, "none with inverts, others or keep: with it every position is true")
        if self.others == "noisy":
            if (self.inverts, self.keep, self.part, self.only, self.while_) != ("position", 0, "both", "any", "always"):
                raise BadValue("others", self.others, "inverts=position with it, and no keep, part, only or while")
            return
        # others and keep say the same; each may be said alone
        said: Others = "fresh" if self.keep == 0 else "kept" if self.keep == 1 else "partly"
        if self.others == "kept" and self.keep == 0:
            object.__setattr__(self, "keep", 1.0)
        elif self.others == "fresh":
            object.__setattr__(self, "others", said)
        elif self.others != said:
            raise BadValue("others", self.others, f"none with keep={self.keep:g}, which says it already")

    @property
    def implied(self) -> tuple[str, ...]:
        """The option that its spec leaves out, because another one says it."""
        return ("others",) if self.others == "partly" else ("keep",)

    @property
    def reading(self) -> str:
        """What this false report is in the words of the field: ``memoryless state noise``."""
        name = READINGS[self.inverts, self.others]
        if self.part == "outcome":
            return "outcome noise with true positions"
        name = f"{name} (keep = {self.keep:g})" if self.others == "partly" else name
        return name if self.part == "both" else f"{name} with true outcomes"

    def check_told(self, modality: str, *, both: bool) -> None:
        """Refuse one part of a false report where reports do not tell both outcomes and positions."""
        if self.part != "both" and not both:
            raise BadValue("part", self.part, f"both with {modality}; symbolic tells outcomes and positions")

    def at_rate(self, p: float, at: tuple[int, ...] = ()) -> OutcomeFlip:
        """A flip of the same reading at another rate, of all reports or of those of given steps.

        The options ``only`` and ``while`` are left out.
        """
        return OutcomeFlip(p=p, inverts=self.inverts, others=self.others, keep=self.keep, part=self.part, at=at)

    def falls_on(self, step: int) -> bool:
        """Whether the report of this step, from 1, can be inverted."""
        return not self.at or step in self.at

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept with its outcome inverted, or not."""
        if percept.joint is None:
            return percept
        outcome, step, numbers = percept.outcome, len(past), rng.random(self.numbers(len(task.joints))).tolist()
        can_lie = outcome is not None and self.falls_on(step)
        flipped = can_lie and self.only in ("any", outcome) and numbers[0] < self.rate(percept)
        if flipped and self.while_ == "looping":  # three attempts or more that stood so before (paper, Sec. 3.3)
            attempted = (*(was.attempted for was in past[1:]), percept.joint)
            flipped = any(attempted[i : i + 3] == attempted[-3:] for i in range(len(attempted) - 5))
        lasting = 0 if self.others == "noisy" and not can_lie else self.lasting(numbers)
        return self.told(percept, past, task, flipped=flipped, lasting=lasting)

    def rate(self, percept: Percept) -> float:
        """The rate at which the outcome of this attempt is inverted, [0, 1]."""
        return self.p

    def told(self, percept: Percept, past: tuple[Moment, ...], task: Task, *, flipped: bool, lasting: int) -> Percept:
        """The percept of an attempt as this flip tells it, inverted or not, with what :meth:`lasting` gives."""
        outcome, positions = percept.outcome, percept.positions
        if positions is not None and percept.joint is not None:
            place = task.joints.index(percept.joint)
            before, moved, bit = past[-1].reported.positions if past else None, outcome == "moved", 1 << place
            if not (flipped or lasting or (before and before[place] == (positions[place] == moved))):
                return percept  # nor was its position told falsely before
            now, last = (sum(at << place for place, at in enumerate(said)) for said in (positions, before or positions))
            if before is None or outcome is None:  # nothing to compare the joint with: its position follows the truth
                last = (last & ~bit) | ((now ^ moved * bit) & bit)
            told = self.positions(now, last, bit, moved=moved, flipped=flipped, lasting=lasting)
            positions = tuple(bool(told >> place & 1) for place in range(len(positions)))
        if flipped and outcome is not None and self.part != "position":
            outcome = "blocked" if outcome == "moved" else "moved"
        return percept.but(outcome=outcome, positions=positions)

    def numbers(self, joints: int) -> int:
        """How many random numbers of a report decide what it tells: one, or one more for each joint."""
        return 1 + joints * (0 < self.keep < 1 or self.others == "noisy")

    def lasting(self, numbers: Any) -> Any:
        """The joints whose false positions survive a report, or which it inverts (``others=noisy``), one bit each.

        ``numbers`` are those of the report, in [0, 1), after the first in the order of the listing; each is a number,
        or an array with one for each trial.
        """
        if len(numbers) == 1:
            return -int(self.keep)
        chance = self.p if self.others == "noisy" else self.keep
        return sum((number < chance) * (1 << place) for place, number in enumerate(numbers[1:]))

    def positions(self, now: Any, last: Any, bit: Any, *, moved: Any, flipped: Any, lasting: Any) -> Any:
        """The positions that a report tells, one bit for each joint: the law of false reports, for one trial or many.

        All arguments are whole numbers or truth values, or arrays with one for each trial: the positions without this
        flip, those told last, the attempted joint, whether it moved, whether the report is inverted, and what
        :meth:`lasting` gives.
        """
        if self.part == "outcome":
            return now
        own = last ^ bit * (moved ^ flipped) if self.inverts == "outcome" else now ^ bit * flipped
        others = now ^ (lasting if self.others == "noisy" else (now ^ last) & lasting)
        return others & ~bit | own & bit

    def report(self, now: Any, last: Any, bit: Any, moved: Any, numbers: Any) -> Any:
        """The outcome and the positions that a report tells, given its random numbers, if this flip acts on all alike.

        The arguments are those of :meth:`positions` and :meth:`lasting`.
        """
        flipped = numbers[0] < self.p
        told = self.positions(now, last, bit, moved=moved, flipped=flipped, lasting=self.lasting(numbers))
        return moved ^ flipped if self.part != "position" else moved, told


_WORDS = {"transient": "memoryless", "sticky": "latched", "outcome-only": "re-observed"}


def flip_of(kind: FlipKind, p: float = 0.0) -> OutcomeFlip:
    """The flip that a word of ``--flip`` means, at this rate."""
    check_choice("flip", kind, get_args(FlipKind))
    name = _WORDS.get(kind, kind)
    inverts, others = next(key for key, reading in READINGS.items() if reading.startswith(f"{name} "))
    return OutcomeFlip(p=p, inverts=inverts, others=others)


By = Literal["joint", "direction", "total"]

Rates = Mapping[str, tuple[float, float]]
"""Joint -> the rates at which its moves are hidden and at which moves of it are invented, [0, 1]."""


def misread_rates(said: Mapping[Claim, int], joints: Sequence[str], by: By = "joint") -> Rates:
    """The confusion matrix of what an agent said, with how often it said each.

    The rates are those of the joint and outcome, of the outcome (``direction``), or the total rate. A joint without a
    claim about an outcome has the rate of that outcome over all joints; an outcome without a claim has the rate 0.
    """

    def rate(truth: str, joint: str = "") -> float:
        about = {one: n for one, n in said.items() if truth in ("", one.truth) and joint in ("", one.joint)}
        if joint and not about:
            return rate(truth)
        return sum(n for one, n in about.items() if one.false_belief) / (sum(about.values()) or 1)

    moved, blocked = ("", "") if by == "total" else ("moved", "blocked")
    own = {joint: joint if by == "joint" else "" for joint in joints}
    return {joint: (rate(moved, of), rate(blocked, of)) for joint, of in own.items()}


def entries_of(rates: Rates) -> tuple[str, ...]:
    """The entries of a confusion matrix, as a spec holds them: ``slider:0.2:0.05``."""
    return tuple(f"{joint}:{hidden:g}:{invented:g}" for joint, (hidden, invented) in rates.items())


@cache
def rates_of(entries: tuple[str, ...]) -> Rates:
    """The confusion matrix that entries describe."""
    found = dict[str, tuple[float, float]]()
    for entry in entries:
        joint, *texts = entry.rsplit(":", 2)
        try:
            hidden, invented = map(float, texts)
            known = joint and joint not in found and 0 <= hidden <= 1 and 0 <= invented <= 1
        except ValueError:
            known = False
        if not known:
            expected = "joints with the rates of hidden and of invented moves, such as slider:0.2:0.05;lever:0:0.1"
            raise BadValue("rates", entry, expected)
        found[joint] = hidden, invented
    return found


@dataclass(frozen=True, slots=True, kw_only=True)
class MisreadFlip(OutcomeFlip):
    """False reports at the rates at which an agent misread what its attempts did: its confusion matrix.

    A move of a joint is reported as a failure as often as the agent took moves of this joint for failures (hidden
    moves), and a failure as a move as often as it took failures for moves (invented moves). So the paper's comparison
    of misreadings with flips (Sec. 3.2) can be made with flips of the same rate and kind.

    ``like=DIR/CONDITION`` is a condition of a finished study, by its directory; ``of`` names the agent there. The rates
    are read when the study is made and stand in its settings, so that it needs no other directory afterwards. The draws
    are those of ``flip``.

    Attributes:
        p: Share of the rates that acts, [0, 1]: at 0.5 a report is false half as often as the agent misread.
        by: What the rates depend on: joint and outcome, outcome alone, or neither (the total rate).
        rates: The confusion matrix by joint, which is read from the study.
        size: Attempts of which the agent said what they did, from which the rates come; read too.
        by_label: The rates of one trial, by the labels of its joints, which the study fills in.
    """

    variant: ClassVar[str] = "like"
    p: Share = 1.0
    like: str = ""
    of: str = ""
    by: By = "joint"
    rates: tuple[str, ...] = ()
    size: int = 0
    by_label: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        OutcomeFlip.__post_init__(self)
        rates_of(self.rates)
        if self.others == "noisy" or self.part != "both":
            raise BadValue("like", self.like, "none with others=noisy or part: a misreading is of one outcome")

    @property
    def implied(self) -> tuple[str, ...]:
        """The options that its spec leaves out: others say them, or they are filled in."""
        unread = () if self.rates else ("rates", "size")
        return ("others" if self.others == "partly" else "keep", "by_label", *unread)

    def rate(self, percept: Percept) -> float:
        """The rate at which the outcome of this attempt is told falsely."""
        if percept.joint is None or percept.outcome is None or not self.p:
            return 0.0
        if percept.joint not in (rates := rates_of(self.by_label)):
            raise BadValue("condition", f"flip?like={self.like}", "a study that has it, with the rates that it read")
        hidden, invented = rates[percept.joint]
        return self.p * (hidden if percept.outcome == "moved" else invented)


@lru_cache(maxsize=1024)
def _misread(spec: str) -> MisreadFlip | None:
    """The flip that a part of a condition's spec names, if it has the rates of a confusion matrix."""
    part = Spec.parse(spec)
    if part.full_name != MisreadFlip.name or "rates" not in part.options:
        return None
    return with_options(MisreadFlip, MisreadFlip.name, part.options)


def with_rates(plan: Plan) -> Plan:
    """The plan with the rates of its confusion matrix by the labels of its joints; a joint without rates has none."""
    if not any(flips := [*map(_misread, plan.condition.specs)]):
        return plan
    acting = [*plan.condition.interventions]
    for at, flip in ((at, flip) for at, flip in enumerate(flips) if flip):
        rates, labelled = rates_of(flip.rates), zip(plan.box.names, plan.names.labels, strict=True)
        by_label = {label: rates.get(name, (0.0, 0.0)) for name, label in labelled}
        acting[at] = replace(flip, by_label=entries_of(by_label))
    return replace(plan, condition=replace(plan.condition, interventions=tuple(acting)))

"""The intervention ``flip?like=…``: false reports at the rates at which an agent misread what its attempts did.

The rates are a confusion matrix by joint, as text in a spec. ``slider:0.2:0.05`` says that of the attempts that moved
the slider 20 % were taken for failures (hidden moves), and of those that did not 5 % for moves (invented moves).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from typing import TYPE_CHECKING, ClassVar, Literal

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import Spec, with_options
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Percept

if TYPE_CHECKING:
    from lockprobe.statistics.misinterpretation import Claim

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
        except ValueError:
            hidden = invented = -1.0
        if not joint or joint in found or not (0 <= hidden <= 1 and 0 <= invented <= 1):
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
    p: float = 1.0
    like: str = ""
    of: str = ""
    by: By = "joint"
    rates: tuple[str, ...] = ()
    size: int = 0
    by_label: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        OutcomeFlip.__post_init__(self)
        rates_of(self.rates)
        if not self.like:
            raise BadValue("like", self.like, "DIR/CONDITION, with the directory of a finished study")
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
def takes_rates(specs: tuple[str, ...]) -> bool:
    """Whether a condition of these specs has the rates of a confusion matrix."""
    found = map(Spec.parse, specs)
    return any(one.full_name == MisreadFlip.name and MisreadFlip.variant in one.options for one in found)


def with_rates(plan: Plan) -> Plan:
    """The plan with the rates of its confusion matrix by the labels of its joints; a joint without rates has none."""
    if not takes_rates(plan.condition.specs):
        return plan
    acting = [*plan.condition.interventions]
    for at, spec in enumerate(plan.condition.specs[: len(acting)]):
        flip = with_options(MisreadFlip, MisreadFlip.name, Spec.parse(spec).options) if takes_rates((spec,)) else None
        if flip is not None and flip.rates:
            rates = rates_of(flip.rates)
            labelled = zip(plan.box.names, plan.names.labels, strict=True)
            by_label = {label: rates.get(name, (0.0, 0.0)) for name, label in labelled}
            acting[at] = replace(flip, by_label=entries_of(by_label))
    return replace(plan, condition=replace(plan.condition, interventions=tuple(acting)))

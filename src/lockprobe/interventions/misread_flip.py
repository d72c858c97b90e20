"""The intervention ``flip?like=…``: false reports at the rates at which an agent misread what its attempts did."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import ClassVar, Literal, get_args

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import Spec, with_options
from lockprobe.foundation.validation import check_choice
from lockprobe.interventions.confusion import entries_of, rates_of
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.trial.condition import Recorded
from lockprobe.trial.plan import Names, Plan
from lockprobe.trial.protocols import Intervention
from lockprobe.trial.record import Percept

By = Literal["joint", "direction", "total"]


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
        like: The study and the condition whose misreadings give the rates.
        of: The agent of that study; empty for the only one.
        by: What the rates depend on: joint and outcome, outcome alone, or neither (the total rate).
        rates: The confusion matrix by joint (:mod:`lockprobe.interventions.confusion`), which are read from
            the study.
        size: Attempts of which the agent said what they did, from which the rates come; read too.
        by_label: The rates of one trial, by the labels of its joints, which the study fills in.

    Raises:
        BadValue: As ``flip``, or if a false report is not of one outcome.
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
        check_choice("by", self.by, get_args(By))
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
        """The rate at which the outcome of this attempt is told falsely.

        Raises:
            BadValue: If no study has filled the rates in.
        """
        if percept.joint is None or percept.outcome is None or not self.p:
            return 0.0
        if percept.joint not in (rates := rates_of(self.by_label)):
            raise BadValue("condition", f"flip?like={self.like}", "a study that has it, with the rates that it read")
        hidden, invented = rates[percept.joint]
        return self.p * (hidden if percept.outcome == "moved" else invented)


@lru_cache(maxsize=1024)
def takes_rates(specs: tuple[str, ...]) -> bool:
    """Whether a condition of these specs has the rates of a confusion matrix."""
    return any(map(_is_misread, specs))


def _is_misread(text: str) -> bool:
    spec = Spec.parse(text)
    return spec.full_name == MisreadFlip.name and MisreadFlip.variant in spec.options


def with_rates(plan: Plan) -> Plan:
    """The plan with the rates of its confusion matrix by the labels of its joints; a joint without rates has none."""
    if not takes_rates(plan.condition.specs):
        return plan
    acting = tuple(_labelled(one, plan) for one in plan.condition.interventions)
    return replace(plan, condition=replace(plan.condition, interventions=acting))


def _labelled(one: Intervention | Recorded, plan: Plan) -> Intervention | Recorded:
    if isinstance(one, Recorded) and _is_misread(one.spec):
        one = with_options(MisreadFlip, MisreadFlip.name, Spec.parse(one.spec).options)
    if not isinstance(one, MisreadFlip) or not one.rates:
        return one
    rates, labels = rates_of(one.rates), Names(plan).labels
    by_label = {label: rates.get(name, (0.0, 0.0)) for name, label in zip(plan.box.names, labels, strict=True)}
    return replace(one, by_label=entries_of(by_label))

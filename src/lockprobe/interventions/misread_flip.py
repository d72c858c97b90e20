"""The intervention ``flip?like=…``: false reports at the rates at which an agent misread what its attempts did."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal, get_args

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.validation import check_choice
from lockprobe.interventions.confusion import rates_of
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.trial.record import Percept

__all__ = ["By", "MisreadFlip"]

By = Literal["joint", "direction", "total"]


@dataclass(frozen=True, slots=True, kw_only=True)
class MisreadFlip(OutcomeFlip):
    """False reports at the rates at which an agent misread what its attempts did: its confusion matrix.

    A move of a joint is reported as a failure as often as the agent took moves of this joint for failures (hidden
    moves), and a failure as a move as often as it took failures for moves (invented moves). So the paper's comparison
    of misreadings with flips (Sec. 3.2) can be made with flips of the same rate and kind.

    ``like=CONDITION`` is a condition of the same study, and every agent has its own matrix. ``like=STUDY/CONDITION``
    is one of another study, by its directory; ``of`` names the agent there. The record holds the matrix. The draws are
    those of ``flip``.

    Attributes:
        p: Share of the rates that acts, [0, 1]: at 0.5 a report is false half as often as the agent misread.
        like: The condition whose misreadings give the rates, by its label.
        of: The agent of the other study; empty for the only one.
        by: What the rates depend on: joint and outcome, outcome alone, or neither (the total rate).
        rates: The confusion matrix by joint (:mod:`lockprobe.interventions.confusion`), which the study fills in.
        size: Attempts of which the agent said what they did, from which the rates come; filled in too.
        by_label: The rates of one trial, by the labels of its joints; filled in too.

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
            raise BadValue("like", self.like, "CONDITION of this study, or STUDY/CONDITION")
        if self.others == "noisy" or self.part != "both":
            raise BadValue("like", self.like, "none with others=noisy or part: a misreading is of one outcome")

    @property
    def implied(self) -> tuple[str, ...]:
        """The options that its spec leaves out: others say them, or the study fills them in."""
        filled = ("by_label",) if self.rates else ("by_label", "rates", "size")
        return ("others" if self.others == "partly" else "keep", *filled)

    def rate(self, percept: Percept) -> float:
        """The rate at which the outcome of this attempt is told falsely.

        Raises:
            BadValue: If no study has filled the rates in.
        """
        if percept.joint is None or percept.outcome is None or not self.p:
            return 0.0
        if percept.joint not in (rates := rates_of(self.by_label)):
            raise BadValue("condition", f"flip?like={self.like}", "a study that has it: the rates come from its trials")
        hidden, invented = rates[percept.joint]
        return self.p * (hidden if percept.outcome == "moved" else invented)

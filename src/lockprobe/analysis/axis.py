"""The axis on which conditions are placed that differ in one dose: how it is called in sentences and figures."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["AGENT", "FLIPS", "Axis"]

PICTURED = ("rgb", "rgbd")
"""Modalities, whose pictures can be false, blurred, noisy or covered."""

AGENT = "agent"
"""The kind of an axis that is an option of agents, such as their temperature."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """What conditions differ in.

    Attributes:
        kind: Name of the intervention, for example ``tremble``; of an agent's option ``agent``.
        dose: The option that is its dose.
        rest: What else acts in all conditions, as specs with plus signs between; empty where nothing does.
    """

    kind: str
    dose: str
    rest: str = ""

    @property
    def name(self) -> str:
        """What the dose is called in a sentence.

        >>> Axis(kind="tremble", dose="p").name, FLIPS.name
        ('tremble p', 'flip rate')
        """
        if self.kind == AGENT:
            return self.dose
        return "flip rate" if (self.kind, self.dose) == ("flip", "p") else f"{self.kind} {self.dose}"

    @property
    def label(self) -> str:
        """What stands below the axis in a figure; a flip rate has the letter of the paper."""
        return "flip rate $p$" if self.name == "flip rate" else self.name.replace("$", r"\$")

    @property
    def cause(self) -> str:
        """What may change an agent's success, in a sentence."""
        if self.kind == AGENT:
            return f"higher values of {self.dose}"
        return "false reports" if self.name == "flip rate" else f"higher doses of {self._short}"

    @property
    def zero(self) -> str:
        """The condition at dose 0, in a sentence."""
        if self.rest:
            return f"under {self.rest} alone"
        if self.kind == AGENT:
            return f"at a {self.dose} of 0"
        return "when told the truth" if self.name == "flip rate" else f"without {self._short}"

    @property
    def _short(self) -> str:
        """An intervention goes by its name; pictures have several doses."""
        return self.name if self.kind in PICTURED else self.kind

    def said(self, sentence: str) -> str:
        """A sentence about flip rates as one about this dose.

        >>> Axis(kind="tremble", dose="p").said("False reports change nothing from a flip rate of 0 to 0.2.")
        'Higher doses of tremble change nothing from a tremble p of 0 to 0.2.'
        """
        if self == FLIPS:
            return sentence
        cause = f"{self.cause[0].upper()}{self.cause[1:]}"
        words = {
            "when told the truth": self.zero,
            "False reports": cause,
            "false reports": self.cause,
            "flip rate": self.name,
        }
        for before, after in words.items():
            sentence = sentence.replace(before, after)
        return sentence


FLIPS = Axis(kind="flip", dose="p")
"""The axis of the paper (Sec. 3.2)."""

"""The axis on which conditions are placed that differ in one dose."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["AGENT", "FLIPS", "Axis"]

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
        """What the dose is called.

        >>> Axis(kind="tremble", dose="p").name, FLIPS.name
        ('tremble p', 'flip rate')
        """
        if self.kind == AGENT:
            return self.dose
        return "flip rate" if (self.kind, self.dose) == ("flip", "p") else f"{self.kind} {self.dose}"


FLIPS = Axis(kind="flip", dose="p")
"""The axis of the paper (Sec. 3.2)."""

"""The axis of a dose-response analysis: the one option in which conditions differ."""

from __future__ import annotations

from dataclasses import dataclass

AGENT = "agent"
"""The kind of an axis that is an option of agents, such as their temperature."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """The dose axis: the one option in which conditions differ.

    Attributes:
        kind: Name of the intervention, for example ``tremble``; :data:`AGENT` for an option of agents.
        dose: The option that is its dose.
        options: Its other options, equal in all conditions, as in a spec: ``others=kept``; empty without any.
        rest: The other interventions, equal in all conditions, as specs joined by plus signs; empty if there are none.
    """

    kind: str
    dose: str
    options: str = ""
    rest: str = ""

    @property
    def name(self) -> str:
        """The name of the dose.

        >>> Axis(kind="tremble", dose="p").name, FLIPS.name
        ('tremble p', 'flip rate')
        """
        if self.kind == AGENT:
            return self.dose
        return "flip rate" if (self.kind, self.dose) == ("flip", "p") else f"{self.kind} {self.dose}"

    @property
    def of_flips(self) -> bool:
        """Whether its levels are rates of flips alone, of one reading of a false report."""
        return (self.kind, self.dose, self.rest) == ("flip", "p", "")

    @property
    def plural(self) -> str:
        """What several doses are called.

        >>> Axis(kind="tremble", dose="p").plural, Axis(kind=AGENT, dose="t").plural, FLIPS.plural
        ('doses', 'values of t', 'flip rates')
        """
        if self.kind == AGENT:
            return f"values of {self.dose}"
        return "flip rates" if self.name == "flip rate" else "doses"


FLIPS = Axis(kind="flip", dose="p")
"""The axis of the paper (Sec. 3.2)."""


def axis_key(name: str, options: str = "", rest: str = "", number: int = 1) -> str:
    """What the column ``axis`` says of a dose: its name, what is equal at all levels, and which of several it is."""
    said = f"{name} ({options})" if options else name
    return f"{said}{f', with {rest}' if rest else ''}{f' ({number})' if number > 1 else ''}"

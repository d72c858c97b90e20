"""Views of the rows of results: one agent under one condition, and one agent over the doses of an axis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from lockprobe.report.rows.row import Curve, Estimate, clearness

if TYPE_CHECKING:
    from lockprobe.report.rows.results import Results


@dataclass(frozen=True, slots=True, kw_only=True)
class _View:
    """The rows of results that have the values of some columns."""

    found: Results

    @property
    def _own(self) -> dict[str, str]:
        raise NotImplementedError

    def get(self, quantity: str, of: str = "") -> Estimate | None:
        """A number of it; None if it has none."""
        return self.found.get(quantity, **self._own, of=of)

    def value(self, quantity: str, of: str = "") -> float | None:
        """The value of a number of it; None if it has none."""
        row = self.get(quantity, of)
        return None if row is None else row.value

    def curve(self, quantity: str, of: str = "") -> Curve | None:
        """A curve of it; None if it has none."""
        return self.found.curve(quantity, **self._own, of=of)


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell(_View):
    """One agent under one condition.

    Attributes:
        p: Flip rate; None if other things than flips can act.
        dose: Its dose on the axis on which it is shown.
        label: What tables call the agent here.
        same_at_every_p: Whether the agent plays the same trials at every flip rate.
    """

    agent: str
    modality: str
    condition: str
    p: float | None
    dose: float | None
    label: str
    same_at_every_p: bool

    @property
    def _own(self) -> dict[str, str]:
        return {"agent": self.agent, "condition": self.condition, "control": "", "versus": ""}

    @property
    def trials(self) -> int:
        """Trials that ended as solved or out of budget."""
        return int(self.value("trials") or 0)

    @property
    def points(self) -> list[tuple[Estimate, Estimate]]:
        """Success and loop rate of each repetition."""
        rows = [row for row in self.found.where("success", **self._own) if row.of.startswith("rep=")]
        pairs = ((row, self.get("loop_rate", row.of)) for row in rows)
        return [(success, loops) for success, loops in pairs if loops is not None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Course(_View):
    """One agent over the doses of an axis.

    Attributes:
        agent, modality, label, shown, subject, blind: As those of its player in the design.
        axis: The key of the axis, which its rows have in their column ``axis``.
        name: What sentences call the dose.
        cells: Its cells by dose, ascending.
        of_agents: Whether its doses are an option of agents.
    """

    agent: str
    modality: str
    label: str
    shown: str
    subject: bool
    blind: bool
    axis: str
    name: str
    cells: tuple[Cell, ...]
    of_agents: bool = False

    @property
    def played(self) -> tuple[Cell, ...]:
        """Its cells that have an ended trial."""
        return tuple(cell for cell in self.cells if cell.trials)

    @property
    def _own(self) -> dict[str, str]:
        return {"agent": self.agent, "modality": self.modality, "axis": self.axis, "condition": "", "versus": ""}

    def changes(self, of: str = "", quantity: str = "success_difference") -> list[tuple[Cell, Estimate]]:
        """A number that compares each dose with the lowest, with what the agent did at that dose."""
        found = []
        for cell in self.cells[1:]:
            place = {"condition": cell.condition, "of": of}
            if self.of_agents:  # agents that differ in an option have no condition each
                place = {"condition": "", "of": ", ".join(filter(None, (f"{cell.dose:.15g}", of)))}
            rows = self.found.where(quantity, agent=self.agent, axis=self.axis, versus="", **place)
            found += [(cell, row) for row in rows if row.control or self.of_agents]
        return found

    @property
    def clearest(self) -> tuple[Cell, Estimate] | None:
        """The change with the smallest P value, of equal ones the largest; None if nothing was compared.

        Intervals and P values are corrected for this choice.
        """
        return min(self.changes(), key=lambda pair: clearness(pair[1]), default=None)

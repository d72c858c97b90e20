"""What differs between the trials of a study, and how far it has come, as parts of its results."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from lockprobe.report.rows.row import Part
from lockprobe.statistics.design import Axis, axis_key


class Condition(Part):
    """A condition of the study."""

    name: str = Field(description="Its name: its specs, or what the experimenter calls it.")
    specs: tuple[str, ...] = Field(default=(), description="What acts.")
    modality: str = Field(description="How the box is shown.")
    doses: dict[str, float] = Field(default={}, description="Its doses.")
    p: float | None = Field(default=None, description="Flip rate, if nothing but flips can act.")
    control: str = Field(default="", description="The condition that it is compared with; empty for a control.")


class Contrast(Part):
    """What the study asks by itself: a mean under some conditions minus that under others."""

    name: str = Field(description="What the study calls it.")
    of: tuple[str, ...] = Field(description="The conditions of one side.")
    minus: tuple[str, ...] = Field(description="The conditions of the other side.")
    measure: str = Field(default="success", description="Of what the mean is: success, or misreading.")


class Player(Part):
    """An agent in one modality."""

    agent: str = Field(description="Name of the agent, or its spec if it has none.")
    modality: str = Field(description="How the box was shown.")
    shown: str = Field(default="", description="What tells it apart in words: the modality, if it has several.")
    subject: bool = Field(default=False, description="Whether the study is about it; others are baselines.")
    blind: bool = Field(default=False, description="Whether it plays alike at every dose.")
    doses: tuple[float, ...] = Field(default=(), description="Its doses with trials, of an axis of its own, ascending.")

    @property
    def label(self) -> str:
        """What tables call it."""
        return f"{self.agent} ({self.shown})" if self.shown else self.agent

    @property
    def named(self) -> dict[str, Any]:
        """What a course of it says of it."""
        return {name: getattr(self, name) for name in ("agent", "modality", "label", "shown", "subject", "blind")}


class DoseAxis(Part):
    """Conditions that differ in one dose alone, or agents that differ in one option alone."""

    name: str = Field(description="What sentences call the dose.")
    intervention: str = Field(description="Name of the intervention; agent for an option of agents.")
    dose: str = Field(description="The option that is the dose.")
    options: str = Field(default="", description="Other options of the intervention in all of them.")
    rest: str = Field(default="", description="Other interventions in all of them.")
    modality: str = Field(description="How the box is shown in all of them.")
    doses: dict[str, float] = Field(description="Condition, or agent -> dose, ascending.")
    condition: str = Field(default="", description="For an option of agents: the condition of all of them.")
    players: tuple[Player, ...] = Field(default=(), description="Agents with trials on it; of flips the design's.")
    number: int = Field(default=1, ge=1, description="Which it is of several of that name.")

    @property
    def axis(self) -> Axis:
        """The dose alone."""
        return Axis(kind=self.intervention, dose=self.dose, options=self.options, rest=self.rest)

    @property
    def of_flips(self) -> bool:
        """Whether its levels are rates of flips alone, of one reading of a false report."""
        return self.axis.of_flips

    @property
    def key(self) -> str:
        """Its name in the column ``axis``: the dose, and what else acts at all of its levels."""
        return axis_key(self.name, self.options, self.rest, self.number)


class Design(Part):
    """What differs between the trials of the study."""

    conditions: tuple[Condition, ...] = Field(description="Its conditions, in the order of the settings.")
    players: tuple[Player, ...] = Field(description="The agents that have trials, each in each of its modalities.")
    axes: tuple[DoseAxis, ...] = Field(default=(), description="The doses; flip rates first.")
    contrasts: tuple[Contrast, ...] = Field(default=(), description="What it asks by itself; the first is primary.")
    flip_kind: str = Field(default="", description="What a false report is.")


EveryLook = Literal["", "until", "extended", "unfinished"]
"""Why numbers must hold at every look: the study stops when it is decided, was extended, or is unfinished."""


class Progress(Part):
    """How far the study has come."""

    planned: int = Field(ge=0, description="Planned trials; for people, the places to be filled.")
    finished: int = Field(ge=0, description="Of these, finished trials.")
    every_look: EveryLook = Field(
        default="", description="Why success and its differences are shown as they hold at every look; empty: at one."
    )
    not_counted: int = Field(default=0, ge=0, description="Finished trials behind an open block, in no number yet.")
    broken: dict[str, int] = Field(
        default={}, description="Agent -> its trials without a valid end, if a run has gone through all of them."
    )

    @property
    def partial(self) -> bool:
        """Whether planned trials are open: neither finished nor broken."""
        return self.finished + sum(self.broken.values()) < self.planned


class LeftOut(Part):
    """A section of the report that could not be made; the others do not depend on it."""

    section: str = Field(description="What it is called.")
    reason: str = Field(description="Why, in one line.")

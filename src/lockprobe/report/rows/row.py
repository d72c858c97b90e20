"""The kinds of rows of results: numbers, curves and properties."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from lockprobe.statistics.proportions import Proportion


def _finite(value: object) -> object:
    """None for what is not a number, as JSON has it."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


Number = Annotated[float | None, BeforeValidator(_finite)]
Probability = Annotated[float | None, Field(ge=0, le=1), BeforeValidator(_finite)]


class Part(BaseModel):
    """A part of the results: frozen, described, and written without what has its default."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    def plain(self) -> dict[str, Any]:
        """The part as JSON holds it."""
        return self.model_dump(mode="json", exclude_defaults=True)


class _Measured(Part):
    """What an estimate and a curve have in common: the columns that say what they are of.

    No two rows of a study are equal in all of :data:`IDENTITY`.
    """

    quantity: str = Field(description="What is measured, for example success or success_by_step.")
    agent: str = Field(
        default="", description="Name of the agent, or its spec if it has none; empty for what no agent did."
    )
    modality: str = Field(default="", description="How the box was shown; under the condition, if under one.")
    condition: str = Field(default="", description="Name of the condition; empty for several.")
    control: str = Field(default="", description="The condition that is subtracted, in a difference.")
    versus: str = Field(default="", description="The agent that is subtracted, in a comparison of agents.")
    versus_modality: str = Field(default="", description="How that agent was shown the box.")
    axis: str = Field(default="", description="The dose over which it is computed, for example flip rate; or step.")
    of: str = Field(default="", description="What part of the quantity: a null model, an outcome, a repetition.")
    doses: dict[str, float] = Field(default={}, description="The doses of the condition, for example flip.p: 0.4.")
    n: int | None = Field(default=None, ge=0, description="How many trials, actions or claims it is of.")
    source: str = Field(default="", description="The package that measures it; empty for Lockprobe.")

    @property
    def identity(self) -> tuple[str, ...]:
        """What it is of."""
        return tuple(getattr(self, name) for name in IDENTITY)

    @property
    def pair(self) -> dict[str, str]:
        """The two agents that it compares, as columns."""
        return {name: getattr(self, name) for name in ("agent", "modality", "versus", "versus_modality")}


IDENTITY = (
    *("quantity", "agent", "modality", "condition", "control"),
    *("versus", "versus_modality", "axis", "of", "source"),
)
"""The columns that say what a row is of."""


BOUNDS = ("at least", "at most")
"""Parts of a share or a difference of trials some of which broke: what it is at least and at most, whatever became of
these."""

PERMUTED = "permutation within blocks, and interval"
"""The test of success where outcomes are exchanged between conditions; its interval has to exclude 0 too."""

UNITS = (
    *("share", "points", "ratio", "yes or no", "direction", "dose"),
    *("steps", "trials", "people", "claims", "reports", "decisions", "ms", "records", "lines"),
    *("boxes", "blocks", "restarts", "interlocks", "permutations"),
    *("bits", "logits", "score", "coefficient", "r", "z"),
)
"""The units of Lockprobe's numbers."""


class Estimate(_Measured):
    """One number, with its interval and test where it has them."""

    unit: str = Field(
        default="share",
        description=f"{', '.join(UNITS)}, or what a package says; empty if it has none. Points are differences of "
        "shares, from -1 to 1; the column axis names a dose.",
    )
    count: int | None = Field(default=None, ge=0, description="Of a share: how many of them.")
    clusters: int | None = Field(default=None, ge=0, description="Clusters that the interval counts as independent.")
    value: Number = Field(default=None, description="The number; null where only its interval is known.")
    low: Number = Field(default=None, description="Lower end of its 95 % interval; null if open or unknown.")
    high: Number = Field(default=None, description="Upper end.")
    p_value: Probability = Field(default=None, description="P value, corrected as the next columns say.")
    family: str = Field(default="", description="The comparisons that are judged together.")
    corrected_for: int = Field(default=1, ge=1, description="How many comparisons the P value allows for.")
    test: str = Field(default="", description="The test of the P value.")
    note: str = Field(default="", description="What limits it, for example the end of an interval that is open.")

    @property
    def detected(self) -> bool:
        """Whether the test rejects at 0.05 and the interval leaves out 0."""
        clear = self.low is not None and self.high is not None and (self.low > 0 or self.high < 0)
        return self.p_value is not None and self.p_value < _LEVEL and clear

    def plain(self) -> dict[str, Any]:
        """The row as JSON holds it: ten columns always, the others where they are no defaults."""
        kept = self.model_dump(mode="json", include=_ALWAYS)
        return kept | super().plain()


def clearness(row: Estimate) -> tuple[float, float]:
    """Sorts the clearest difference first: the smallest P value, without a test last, and of equal ones the largest."""
    return 2.0 if row.p_value is None else row.p_value, -abs(row.value or 0.0)


def detected_said(rows: Iterable[Estimate], what: str) -> str:
    """How many of how many were detected; empty if none was tested."""
    judged = [row for row in rows if row.p_value is not None]
    return f"{sum(row.detected for row in judged)} of {len(judged)} {what} detected." if judged else ""


_LEVEL = 0.05
"""Level of every test."""

_ALWAYS = {"quantity", "agent", "condition", "unit", "n", "value", "low", "high", "p_value", "test"}
"""Columns that every row of ``results.json`` has."""


class Curve(_Measured):
    """A number along an axis, such as the share solved by each step, with its band."""

    x: tuple[float, ...] = Field(description="Places on the axis, ascending.")
    value: tuple[Number, ...] = Field(description="The number at each of them.")
    low: tuple[Number, ...] = Field(default=(), description="Lower end of its 95 % band; empty without one.")
    high: tuple[Number, ...] = Field(default=(), description="Upper end.")


class Fact(Part):
    """A property of an agent, the plant or the study, or a sentence that does not follow from rows."""

    about: str = Field(description="What it is a property of, or the section of a sentence.")
    name: str = Field(description="Its name.")
    text: str = Field(description="Its value.")
    source: str = Field(default="", description="The package that gives it; empty for Lockprobe.")


Row = Estimate | Curve | Fact
"""What a section of a report gives."""


def measured_row(quantity: str, found: Any, **columns: Any) -> Estimate:
    """The row of what statistics found: its value, interval, P value and sizes, as far as it has them."""
    return Estimate(quantity=quantity, **measured(found) | columns)


def measured(found: Any) -> dict[str, Any]:
    """The columns of what statistics found, as far as it has them."""
    own = ("value", "low", "high", "p_value", "n", "count", "clusters")
    return {name: getattr(found, name) for name in own if hasattr(found, name)}


def share_rows(quantity: str, found: Proportion, **columns: Any) -> list[Estimate]:
    """The row of a share with its interval; none if it is a share of nothing."""
    return [measured_row(quantity, found, **columns)] if found.n else []

"""``results.json`` as types: what a program may rely on, with its JSON schema.

Keys that are not described here may be there too, and may change with any release.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

from lockprobe.report.page import content_of

__all__ = [
    "ConditionResult",
    "CrossingResult",
    "EffectResult",
    "GridAxis",
    "GridCellResult",
    "GridResult",
    "MeasureResult",
    "Progress",
    "Results",
    "SeriesResult",
    "results",
]

Share = Annotated[float | None, Field(ge=0, le=1)]
Count = Annotated[int, Field(ge=0)]
Difference = Annotated[float, Field(ge=-2, le=2)]


class _Described(BaseModel):
    model_config = ConfigDict(extra="allow", frozen=True)


class Progress(_Described):
    """How far the study has come."""

    planned: Count = Field(description="Trials that the settings ask for, but for those of people.")
    finished: Count = Field(description="Of these, trials that are not owed (any more).")
    partial: bool = Field(description="Whether trials are still owed.")


class ConditionResult(_Described):
    """One agent under one condition."""

    key: str = Field(description="Readable name, for example flips/random/p=0.4.")
    agent: str = Field(description="Agent spec.")
    condition: str = Field(description="Name of the condition: its specs, or what the experimenter calls it.")
    modality: str = Field(description="How the box was shown.")
    p: Share = Field(description="Flip rate, [0, 1]; null where other things than flips acted.")
    trials: Count = Field(description="Trials that ended as solved or out of budget.")
    solved: Count = Field(description="Of these, solved.")
    success: Share = Field(description="Share solved, [0, 1].")
    success_low: Share = Field(description="Lower end of its 95 % Wilson interval.")
    success_high: Share = Field(description="Upper end.")
    loop_rate: Share = Field(description="Share of trials with an action loop (paper, Sec. 3.3).")
    loop_rate_low: Share = Field(description="Lower end of its 95 % Wilson interval.")
    loop_rate_high: Share = Field(description="Upper end.")
    loop_rate_chance: Share = Field(description="Share by uniformly random actions in trials of exactly those lengths.")
    coverage: Share = Field(description="Share of steps in loops.")
    redundant_share: Share = Field(
        description="Share of steps that tried a joint again in the same true configuration."
    )
    misinterpretations: int | None = Field(description="Claims that contradict what was told; null if none was asked.")
    misinterpretation_rate: Share = Field(description="Their share, mean over trials (paper, Table 1).")
    median_steps: float | None = Field(description="Median steps of solved trials.")
    broken: Count = Field(description="Trials that ended as error; they are in no other number.")


class EffectResult(_Described):
    """One condition against the control, in the trials that both have."""

    agent: str = Field(description="Agent spec.")
    control: str = Field(description="Name of the control.")
    condition: str = Field(description="Name of the condition.")
    trials: Count = Field(description="Pairs of trials that share their luck.")
    difference: Difference = Field(description="Success less that under the control, [-1, 1].")
    difference_low: Difference = Field(description="Lower end of its interval, corrected for the conditions compared.")
    difference_high: Difference = Field(description="Upper end.")
    p_value: Share = Field(description="Permutation and interval, the larger, corrected alike.")
    corrected_for: Count = Field(description="Conditions that are compared with the control.")
    detectable: bool = Field(description="Whether the P value is below 0.05.")


class CrossingResult(_Described):
    """Two interventions, alone and together."""

    agent: str = Field(description="Agent spec.")
    neither: str = Field(description="Name of the condition without both.")
    first: str = Field(description="That with the first.")
    second: str = Field(description="That with the second.")
    both: str = Field(description="That with both.")
    difference: Difference | None = Field(description="What the second does beside the first, less alone, [-2, 2].")
    difference_low: Difference | None = Field(description="Lower end of its 95 % interval, not corrected.")
    difference_high: Difference | None = Field(description="Upper end.")
    p_value: Share = Field(description="Exchange of signs of whole blocks of luck, not corrected.")
    detectable: bool = Field(description="Whether test and interval show it.")


class GridAxis(_Described):
    """One of two crossed doses."""

    intervention: str = Field(description="Name of the intervention.")
    dose: str = Field(description="The option that is the dose.")
    values: list[float] = Field(description="The doses, ascending; 0 where the intervention is missing.")


class GridCellResult(_Described):
    """One combination of two doses."""

    row: float = Field(description="Dose of the first intervention.")
    column: float = Field(description="Dose of the second.")
    condition: str = Field(description="Name of the condition.")
    trials: Count = Field(description="Trials that ended as solved or out of budget.")
    solved: Count = Field(description="Of these, solved.")
    success: Share = Field(description="Share solved, [0, 1].")
    success_low: Share = Field(description="Lower end of its 95 % Wilson interval.")
    success_high: Share = Field(description="Upper end.")


class GridResult(_Described):
    """Doses of two interventions that are crossed, of one agent."""

    agent: str = Field(description="Agent spec.")
    modality: str = Field(description="How the box was shown.")
    name: str = Field(description="What is crossed, with a multiplication sign between.")
    rows: GridAxis = Field(description="The dose of the first.")
    columns: GridAxis = Field(description="The dose of the second.")
    rest: str = Field(description="What else acts in all of them.")
    cells: list[GridCellResult] = Field(description="Every combination that was played.")
    trials: Count = Field(description="Blocks of equal luck that have a trial in every cell.")
    difference: float | None = Field(
        description="Interaction: what the range of the second dose does at the highest of the first less at the "
        "lowest, on straight lines through all cells; null where a combination was not played."
    )
    difference_low: float | None = Field(description="Lower end of its interval, corrected for the agent's grids.")
    difference_high: float | None = Field(description="Upper end.")
    p_value: Share = Field(description="Exchange of signs of whole blocks of luck, corrected alike.")
    corrected_for: Count = Field(description="Grids of this agent.")
    detectable: bool = Field(description="Whether test and interval show it.")


class SeriesResult(_Described):
    """Conditions that differ in one dose alone, or agents in one option alone."""

    intervention: str = Field(description="Name of the intervention; agent for an option of agents.")
    dose: str = Field(description="The option that is the dose.")
    rest: str = Field(description="What else acts in all of them.")
    name: str = Field(description="What sentences and figures call the dose.")
    conditions: dict[str, float] = Field(description="Condition, or agent spec -> dose, ascending.")
    findings: list[str] = Field(description="What the dose does to success, a text for each agent.")


class MeasureResult(_Described):
    """A measure that an installed package adds, of one agent under one condition."""

    agent: str = Field(description="Agent spec.")
    condition: str = Field(description="The condition, as keys of records say it.")
    measure: str = Field(description="Its name.")
    kind: str = Field(description="share of a yes or no, mean of a number, or broken.")
    trials: Count = Field(description="Trials to which it applies.")
    value: float | None = Field(description="The mean.")
    low: float | None = Field(description="Lower end of its 95 % interval; null where there is none.")
    high: float | None = Field(description="Upper end.")


class Results(_Described):
    """The numbers of a study: the content of ``results.json``."""

    schema_version: int = Field(description="Version of this layout.")
    lockprobe: str = Field(description="Release that made it.")
    study: dict[str, Any] = Field(description="The settings, as in study.json.")
    progress: Progress
    subjects: list[str] = Field(description="The agents that the study is about.")
    findings: list[str] = Field(description="What was found, in sentences.")
    conditions: list[ConditionResult] = Field(description="Every agent under every condition.")
    effects: list[EffectResult] = Field(default=[], description="Of a study of conditions: each against the control.")
    measures: list[MeasureResult] = Field(default=[], description="What installed packages measure.")
    crossings: list[CrossingResult] = Field(default=[], description="Of a study of conditions: crossed ones.")
    grids: list[GridResult] = Field(default=[], description="Of a study of conditions: crossed doses.")
    series: list[SeriesResult] = Field(default=[], description="Of a study of conditions: doses.")


def results(directory: Path | str) -> Results:
    """The numbers of a study, from its records; equal records give equal results.

    Args:
        directory: The directory of a study.

    Raises:
        BadFile: If it is none.
    """
    return Results.model_validate(content_of(Path(directory)))

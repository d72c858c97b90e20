"""``results.json`` as types: the one value that tables, pages and programs read, with its JSON schema.

Fields with a description make the published schema: programs may rely on them. The others may change with any release.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any, Self

from pydantic import (
    BaseModel,
    Field,
    ModelWrapValidatorHandler,
    ValidationError,
    model_validator,
)

from lockprobe.analysis.clustered import ClusteredProportion
from lockprobe.analysis.curves import Relative
from lockprobe.analysis.incidence import Area
from lockprobe.analysis.misinterpretation import ClaimCount
from lockprobe.analysis.reference import Reference
from lockprobe.analysis.robot import Verdicts
from lockprobe.analysis.rules import RuleBreaks
from lockprobe.report import details
from lockprobe.report.described import Change, Counted, DescribedResult, FiniteNumber, Share
from lockprobe.report.examples import ExampleTrial
from lockprobe.report.excursions import LieResult
from lockprobe.report.forks import ForkResult
from lockprobe.report.leaderboard import ComparisonResult, InteractionResult, LeaderboardResult
from lockprobe.report.overview import Overview
from lockprobe.report.people import PeopleResult
from lockprobe.report.sample_pictures import SeenModality
from lockprobe.report.why import WhyResult

__all__ = [
    "RESULTS_VERSION",
    "ConditionResult",
    "CrossingResult",
    "EffectResult",
    "FlipDesign",
    "GridAxis",
    "GridCellResult",
    "GridResult",
    "MeasureResult",
    "Results",
    "SectionLeftOut",
    "SeriesResult",
    "StudyProgress",
    "plain_json",
]

RESULTS_VERSION = 3
"""Version of the layout of ``results.json``."""


class StudyProgress(DescribedResult):
    """How far the study has come."""

    planned: Counted = Field(description="Planned trials; for people, the places to be filled.")
    finished: Counted = Field(description="Of these, finished trials.")
    partial: bool = Field(description="Whether planned trials are unfinished.")


class SectionLeftOut(DescribedResult):
    """A section of the report that could not be made; the others do not depend on it."""

    section: str = Field(description="What it is called.")
    reason: str = Field(description="Why, in one line.")


class ConditionResult(DescribedResult):
    """One agent under one condition."""

    key: str = Field(description="Readable name, for example flips/random/flip?p=0.4.")
    agent: str = Field(description="Agent spec.")
    condition: str = Field(description="Name of the condition: its specs, or what the experimenter calls it.")
    modality: str = Field(description="How the box was shown.")
    p: Share = Field(description="Flip rate, [0, 1]; null under interventions other than flips.")
    same_at_every_p: bool
    trials: Counted = Field(description="Trials that ended as solved or out of budget.")
    solved: Counted = Field(description="Of these, solved.")
    success: Share = Field(description="Share solved, [0, 1].")
    success_low: Share = Field(description="Lower end of its 95 % Wilson interval.")
    success_high: Share = Field(description="Upper end.")
    looping: int
    loop_rate: Share = Field(description="Share of trials with an action loop (paper, Sec. 3.3).")
    loop_rate_low: Share = Field(description="Lower end of its 95 % Wilson interval.")
    loop_rate_high: Share = Field(description="Upper end.")
    loop_rate_chance: Share = Field(
        description="Expected share for uniformly random actions in trials of the same lengths."
    )
    loop_rate_chance_no_repeat: Share
    loop_rate_chance_markov: Share
    loop_rate_chance_permutation: Share
    loop_rate_chance_error: Mapping[str, float]
    loop_rate_by_symbol: Mapping[str, float]
    coverage: Share = Field(description="Mean over trials of the share of steps in loops.")
    redundant_share: Share = Field(
        description="Mean over trials of the share of steps that tried a joint again in the same true configuration."
    )
    loops_left: details.AgainstChance
    loop_escape: details.TestedAgainstChance
    repeated_after_blocked: details.TestedAgainstChance
    policy_entropy: FiniteNumber
    policy_entropy_steps: int
    misinterpretations: int | None = Field(description="Claims that contradict what was told; null if none was asked.")
    misinterpretation_rate: Share = Field(description="Their share, mean over trials (paper, Table 1).")
    misinterpretation_rate_sd: FiniteNumber
    misinterpretation_rate_pooled: Share
    misinterpretation_trials: int
    misinterpretation_trials_affected: int
    misinterpretation_trials_not_asked: int
    claims: int
    claims_against_truth: int
    misread: ClusteredProportion
    said_moved_told_blocked: ClusteredProportion
    said_blocked_told_moved: ClusteredProportion
    said_moved_of_misread: ClusteredProportion
    false_report: ClusteredProportion
    false_report_of_all_steps: ClusteredProportion
    false_belief: ClusteredProportion
    false_reports_believed: details.CountOf
    false_reports_undone: int
    claim_kinds: Sequence[ClaimCount]
    median_steps: FiniteNumber = Field(description="Median steps of solved trials.")
    median_steps_all: FiniteNumber
    mean_steps: FiniteNumber
    mean_steps_all: FiniteNumber
    steps_to_80: int | None
    steps_to_80_interval: tuple[int | None, int | None]
    area: Area | None
    relative: Relative | None
    errors: Mapping[str, int]
    broken: Counted = Field(description="Trials that ended as error; excluded from all other numbers.")
    steps: Counted = Field(description="Steps of these trials.")
    changed_steps: int | None = Field(
        description="Of these, steps at which the agent was told, asked or remembered something else than without "
        "interventions, or another joint than the chosen one was attempted; null if the records do not say."
    )
    changed: dict[str, int] = Field(description="Spec of every intervention: the steps that it changed.")
    never_acted: bool = Field(
        description="Whether nothing was changed, or no report was false at a flip rate above 0. Then nothing is "
        "concluded from it, unless it is the control."
    )
    against_rules: int | None = Field(
        description="Attempts against the rules of the box, in broken trials too: a free joint did not move, a locked "
        "one did, or another one moved; null if the box is not known."
    )
    rules: RuleBreaks | None
    curve: details.CurveResult
    repetitions: Sequence[details.RepetitionResult]
    distinct_sequences: Counted = Field(description="Different sequences of actions among the trials that ended.")
    label: str
    acts: str = ""


class EffectResult(DescribedResult):
    """One condition against the control, in the trials that both have."""

    agent: str = Field(description="Agent spec.")
    modality: str
    control: str = Field(description="Name of the control.")
    condition: str = Field(description="Name of the condition.")
    trials: Counted = Field(description="Pairs of trials with common random numbers.")
    control_solved: int
    solved: int
    difference: Change = Field(description="Success minus that under the control, [-1, 1].")
    difference_low: Change = Field(description="Lower end of its interval, corrected for conditions and agents.")
    difference_high: Change = Field(description="Upper end.")
    p_value: Share = Field(description="The larger of a permutation test's and the interval's, corrected alike.")
    corrected_for: Counted = Field(description="Conditions that are compared with the control.")
    agents: Counted = Field(description="Agents that are judged together; P value and interval are corrected for them.")
    detectable: bool = Field(description="Whether the P value is below 0.05.")


class CrossingResult(DescribedResult):
    """Two interventions, alone and together."""

    agent: str = Field(description="Agent spec.")
    modality: str
    neither: str = Field(description="Name of the condition without both.")
    first: str = Field(description="That with the first.")
    second: str = Field(description="That with the second.")
    both: str = Field(description="That with both.")
    trials: int
    difference: Change | None = Field(
        description="Interaction: effect of the second with the first minus its effect alone, [-2, 2]."
    )
    difference_low: Change | None = Field(description="Lower end of its interval, corrected for the interactions.")
    difference_high: Change | None = Field(description="Upper end.")
    p_value: Share = Field(description="Sign-flip permutation test over blocks, corrected alike.")
    corrected_for: Counted = Field(description="Interactions of all agents that are judged together.")
    detectable: bool = Field(description="Whether the test rejects and the interval excludes 0.")


class GridAxis(DescribedResult):
    """One of two crossed doses."""

    intervention: str = Field(description="Name of the intervention.")
    dose: str = Field(description="The option that is the dose.")
    values: list[float] = Field(description="The doses, ascending; 0 where the intervention is missing.")


class GridCellResult(DescribedResult):
    """One combination of two doses."""

    row: float = Field(description="Dose of the first intervention.")
    column: float = Field(description="Dose of the second.")
    condition: str = Field(description="Name of the condition.")
    trials: Counted = Field(description="Trials that ended as solved or out of budget.")
    solved: Counted = Field(description="Of these, solved.")
    success: Share = Field(description="Share solved, [0, 1].")
    success_low: Share = Field(description="Lower end of its 95 % Wilson interval.")
    success_high: Share = Field(description="Upper end.")


class GridResult(DescribedResult):
    """Doses of two interventions that are crossed, of one agent."""

    agent: str = Field(description="Agent spec.")
    modality: str = Field(description="How the box was shown.")
    name: str = Field(description="The two doses, with a multiplication sign between.")
    rows: GridAxis = Field(description="The dose of the first.")
    columns: GridAxis = Field(description="The dose of the second.")
    rest: str = Field(description="Other interventions in all of them.")
    cells: list[GridCellResult] = Field(description="Every combination that was played.")
    trials: Counted = Field(description="Blocks that have a trial in every cell.")
    difference: float | None = Field(
        description="Interaction: effect of the range of the second dose at the highest of the first minus that at the "
        "lowest, from linear trends over all cells; null where a combination was not played."
    )
    difference_low: float | None = Field(description="Lower end of its interval, corrected for the interactions.")
    difference_high: float | None = Field(description="Upper end.")
    p_value: Share = Field(description="Sign-flip permutation test over blocks, corrected alike.")
    corrected_for: Counted = Field(description="Interactions of all agents that are judged together.")
    detectable: bool = Field(description="Whether the test rejects and the interval excludes 0.")


class SeriesResult(DescribedResult):
    """Conditions that differ in one dose alone, or agents in one option alone."""

    intervention: str = Field(description="Name of the intervention; agent for an option of agents.")
    dose: str = Field(description="The option that is the dose.")
    rest: str = Field(description="Other interventions in all of them.")
    modality: str
    name: str = Field(description="What sentences and figures call the dose.")
    conditions: dict[str, float] = Field(description="Condition, or agent spec -> dose, ascending.")
    findings: list[str] = Field(description="The effect of the dose on success, a text for each agent.")
    loop_findings: list[str]
    conclusions: list[list[str]]
    courses_said: str
    fits: list[details.FitResult]
    tests: list[details.TestRow]
    contrasts: list[details.ContrastResult]
    courses: list[details.CourseResult]


class MeasureResult(DescribedResult):
    """A measure that an installed package adds, of one agent under one condition."""

    agent: str = Field(description="Agent spec.")
    condition: str = Field(description="The condition, as in the keys of records.")
    measure: str = Field(description="Its name.")
    what: str
    kind: str = Field(description="share of a yes or no, mean of a number, or broken.")
    trials: Counted = Field(description="Trials to which it applies.")
    value: FiniteNumber = Field(description="The mean.")
    low: float | None = Field(description="Lower end of its 95 % interval; null where there is none.")
    high: float | None = Field(description="Upper end.")


class FlipDesign(DescribedResult):
    """What the conditions of a flip study vary."""

    p: list[float] = Field(description="The flip rates.")
    kind: str = Field(description="What becomes of a false report: transient, sticky or outcome-only.")
    modalities: list[str] = Field(description="How the box is shown.")


class Results(DescribedResult):
    """The numbers of a study: the content of ``results.json``."""

    schema_version: int = Field(description="Version of this layout.")
    lockprobe: str = Field(description="Release that made it.")
    study: dict[str, Any] = Field(description="The settings, as in study.json.")
    flips: FlipDesign | None = Field(default=None, description="Of a flip study: what its conditions vary.")
    settings_hash: str = Field(description="Hash of the settings, as lockprobe verify DIR --settings takes it.")
    results_hash: str = Field(description="Hash of settings and records, as lockprobe verify DIR --results takes it.")
    joints: int
    overview: Overview | None = Field(default=None, description="The first screen of the report.")
    sections_left_out: list[SectionLeftOut] = Field(
        default=[], description="Sections of the report that could not be made."
    )
    answers: dict[str, str] = {}
    progress: StudyProgress
    left_out: details.LeftOutResult
    panel_said: str = ""
    modality_findings: list[str] = []
    findings: list[str] = Field(description="What was found, in sentences.")
    condition_findings: list[str] = Field(default=[], description="The same of conditions beside flip rates.")
    loop_findings: list[str] = []
    conclusions: list[list[str]] = []
    ranking_said: str = ""
    comparisons_said: list[list[str]] = []
    beside: str = ""
    courses_said: str = ""
    box: Reference | None
    conditions: list[ConditionResult] = Field(description="Every agent under every condition.")
    effects: list[EffectResult] = Field(default=[], description="Of a study of conditions: each against the control.")
    crossings: list[CrossingResult] = Field(default=[], description="Of a study of conditions: crossed ones.")
    grids: list[GridResult] = Field(default=[], description="Of a study of conditions: crossed doses.")
    series: list[SeriesResult] = Field(default=[], description="Of a study of conditions: doses.")
    why: list[WhyResult] = Field(default=[], description="Of a study of controls: why false reports change success.")
    forks: list[ForkResult] = Field(default=[], description="Effects of one report, from forked trials.")
    forks_said: list[str] = Field(default=[], description="The detected effects of one report, in sentences.")
    leaderboard: list[LeaderboardResult] = []
    comparisons: list[ComparisonResult] = []
    interactions: list[InteractionResult] = []
    rationality: list[details.RationalityResult] = []
    judged: details.JudgedResult | None = None
    lies: list[LieResult] = Field(default=[], description="Of a flip study: effects of one false report.")
    paces: list[details.PaceResult] = []
    modalities: list[details.ModalityResult] = []
    people: PeopleResult | None = None
    rules_said: str = Field(default="", description="Attempts against the rules of the box; empty if there are none.")
    not_judged: str = Field(
        default="", description="Why no sentence judges an agent, as attempts broke the rules; empty if none did."
    )
    verdicts: Verdicts | None = None
    verdicts_said: str = ""
    fits: list[details.FitResult] = []
    tests: list[details.TestRow] = []
    contrasts: list[details.ContrastResult] = []
    courses: list[details.CourseResult] = []
    claims: list[details.ClaimResult] = []
    detectors: list[details.DetectorResult] = []
    examples: list[ExampleTrial]
    measures: list[MeasureResult] = Field(default=[], description="What installed packages measure.")
    errors: list[details.BrokenTrials]
    tidied: list[details.TidiedReplies] = []
    agents: dict[str, dict[str, str]]
    plants: dict[str, dict[str, str]]
    seen: list[SeenModality]
    subjects: list[str] = Field(description="The agents that the study is about.")
    audit: details.AuditResult

    @model_validator(mode="wrap")
    @classmethod
    def _read_nulls(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Read a null as not a number where the analysis has a float."""
        try:
            return handler(data)
        except ValidationError as error:
            wrong = error.errors(include_url=False)
            if any(one["type"] != "float_type" or one["input"] is not None for one in wrong):
                raise
            for *path, last in (one["loc"] for one in wrong):
                parent = data
                for name in path:
                    parent = parent[name]
                parent[last] = math.nan
            return handler(data)

    def __eq__(self, other: object) -> bool:
        """Whether both have the same content, where a missing number equals a missing number."""
        return isinstance(other, Results) and self.plain() == other.plain()

    def __hash__(self) -> int:
        """Equal results have the same records."""
        return hash((self.lockprobe, self.progress, *self.findings))

    @property
    def has_conditions(self) -> bool:
        """Whether the study has conditions beside flip rates."""
        return "effects" in self.model_fields_set

    def plain(self) -> dict[str, Any]:
        """The content of ``results.json``: all that was set."""
        content: dict[str, Any] = plain_json(self)
        return content


def plain_json(value: Any) -> Any:
    """The value as JSON holds it: null for what is not a number, lists for tuples, objects for records."""
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, BaseModel):
        return {name: plain_json(inner) for name, inner in value if name in value.model_fields_set}
    if is_dataclass(value):
        return {field.name: plain_json(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {key: plain_json(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [plain_json(inner) for inner in value]
    return value

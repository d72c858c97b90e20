"""The parts of a study's results that the published schema does not describe: rows of tables and figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from lockprobe.analysis.clustered import ClusteredMean, ClusteredProportion
from lockprobe.analysis.inference.association import Correlation
from lockprobe.analysis.inference.difference import AnyDifference, Bound
from lockprobe.analysis.inference.hazard import LoopEffect, NaiveAssociation
from lockprobe.analysis.inference.logrank import LogRanks
from lockprobe.analysis.inference.peak import Peak
from lockprobe.analysis.inference.shape import BinomialOrders
from lockprobe.analysis.inference.trend import TrendFit
from lockprobe.analysis.inference.ushape import LindMehlum, TwoLines
from lockprobe.analysis.modalities import ModalityPair
from lockprobe.analysis.pace import Pace

__all__ = [
    "AgainstChance",
    "AuditResult",
    "AuditedRate",
    "AuditedSentence",
    "AuditedSentences",
    "BrokenAt",
    "BrokenByCondition",
    "BrokenTrials",
    "ClaimResult",
    "ContrastResult",
    "CountOf",
    "CourseResult",
    "CurveResult",
    "DetectorResult",
    "FitResult",
    "JudgedResult",
    "LeftOutResult",
    "LoopedByStep",
    "ModalityResult",
    "PaceResult",
    "RationalityResult",
    "RepetitionResult",
    "TestRow",
    "TestedAgainstChance",
    "TidiedReplies",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class CountOf:
    """How many of how many."""

    count: int
    n: int


@dataclass(frozen=True, slots=True, kw_only=True)
class CurveResult:
    """The share of trials solved by each step, with its band."""

    steps: Sequence[int]
    share: Sequence[float]
    low: Sequence[float]
    high: Sequence[float]


@dataclass(frozen=True, slots=True, kw_only=True)
class RepetitionResult:
    """One repetition of a condition; p is None where other things than flips acted."""

    p: float | None
    repetition: int
    n: int
    success: float
    loop_rate: float


@dataclass(frozen=True, slots=True, kw_only=True)
class AgainstChance(ClusteredProportion):
    """A share with what chance gives."""

    by_chance: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class TestedAgainstChance(AgainstChance):
    """A share of actions, with the test against uniformly random actions and those without immediate repeats."""

    __test__ = False  # no test of this package, whatever its name begins with

    by_chance_no_repeat: float | None
    p_value: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class BrokenAt:
    """The share of broken trials at one flip rate."""

    p: float
    count: int
    n: int
    value: float
    low: float
    high: float


@dataclass(frozen=True, slots=True, kw_only=True)
class BrokenByCondition:
    """Whether conditions differ in how many trials broke."""

    at: Sequence[BrokenAt]
    p_value: float | None
    differ: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopedByStep:
    """The share that has looped by a step, at the lowest flip rate and at the higher ones."""

    lowest: float
    higher: float


@dataclass(frozen=True, slots=True, kw_only=True)
class FitResult:
    """What runs over the flip rate for one agent: the paper's fits and those of the tests."""

    agent: str
    modality: str
    reference: bool
    blind: bool
    success: TrendFit
    loop_rate: TrendFit
    correlation: Correlation
    binomial: BinomialOrders
    two_lines: TwoLines
    lind_mehlum: LindMehlum
    peak: Peak
    difference_from_lowest: AnyDifference
    steps_to_solve: LogRanks
    loop_onset: LogRanks
    loop_onset_two_lines: TwoLines
    looped_by_step_12: LoopedByStep | None
    after_a_loop: LoopEffect
    after_a_loop_by_step_10: LoopEffect
    looped_against_solved: NaiveAssociation
    broken: BrokenByCondition | None
    label: str


@dataclass(frozen=True, slots=True, kw_only=True)
class TestRow:
    """One test of one agent, with the false-positive rates that the audit measured."""

    agent: str
    modality: str
    asks: str
    name: str
    question: str
    recommended: bool
    p_value: float | None
    effect: float | None
    low: float | None
    high: float | None
    baseline: float | None
    unit: str
    direction: int
    holds: bool | None
    note: str
    rejects: bool
    false_positives_low: float | None
    false_positives_high: float | None
    false_positives_worst: str | None
    label: str


@dataclass(frozen=True, slots=True, kw_only=True)
class RationalityResult:
    """The actions of one condition before one ideal observer."""

    key: str
    agent: str
    modality: str
    condition: str
    p: float | None
    same_at_every_p: bool
    prior: str
    interlocks: int
    noise: str
    trials: int
    steps: int
    not_judged: int
    optimal: ClusteredProportion
    regret: ClusteredMean
    uninformative: ClusteredProportion
    gained: float
    expected: float
    best: float
    by_chance: Mapping[str, float]
    entropy_left: float
    restarts: float
    label: str


@dataclass(frozen=True, slots=True, kw_only=True)
class JudgedResult:
    """How many trials were judged at most, what was left out and why, and whether the prior fits the box."""

    trials: int
    actions: int
    left_out_beyond_that: int
    left_out_for_want_of_a_prior: int
    prior_contradicted: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class CourseResult:
    """How success and the loop rate of one agent change with the flip rate."""

    agent: str
    modality: str
    kind: str
    first: float
    highest: float
    highest_p: float
    lowest: float
    lowest_p: float
    last: float
    loops_first: float
    loops_least: float
    loops_last: float
    looping: str
    label: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ContrastResult:
    """The lowest flip rate against the one whose success differs from it most clearly."""

    agent: str
    modality: str
    baseline_p: float
    other_p: float
    choices: int
    agents: int
    farthest: bool
    all_trials: bool
    baseline_solved: int
    baseline_trials: int
    other_solved: int
    other_trials: int
    difference: float
    difference_low: float
    difference_high: float
    pairs: int | None
    only_baseline: int | None
    only_other: int | None
    mcnemar: float | None
    fisher: float
    exchange_p_value: float
    p_value: float
    if_broken_unsolved: Bound | None
    if_broken_solved: Bound | None
    detectable: bool
    label: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PaceResult(Pace):
    """Which of two agents is faster."""

    first_label: str
    second_label: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ModalityResult:
    """What the modality does to one agent."""

    agent: str
    p: float
    modalities: Sequence[str]
    direction: int
    p_value: float | None
    p_all: float | None
    pairs: Sequence[ModalityPair]
    detectable: bool
    differs_in_fidelity: bool
    spoken: Sequence[str]
    agents: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ClaimResult:
    """One claim of the paper against one agent."""

    place: str
    quote: str
    quoted: bool
    paper: str
    recomputed: str
    agent: str
    here: str
    verdict: str
    test: str
    p_value: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class DetectorResult:
    """The share of one condition's trials that each loop detector flags."""

    key: str
    agent: str
    modality: str
    condition: str
    p: float | None
    trials: int
    flagged: Mapping[str, float | None]
    label: str


@dataclass(frozen=True, slots=True, kw_only=True)
class BrokenTrials:
    """Trials of one agent that broke at one boundary, with the first message."""

    agent: str
    boundary: str
    trials: int
    message: str
    owed_again: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class TidiedReplies:
    """Replies of one agent that were tidied before they were read, and how often what was tidied."""

    agent: str
    decisions: int
    tidied: int
    what: Mapping[str, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class LeftOutResult:
    """What is on record and in no number, and what was played twice."""

    errors: int
    replayed_on_request: int
    replaced_after_an_error: int
    repeated: int
    unfinished_lines: int
    not_asked_for: int
    foreign: int


@dataclass(frozen=True, slots=True, kw_only=True)
class AuditedRate:
    """How often one test rejected in one simulated world."""

    world: str
    trials: int
    question: str
    test: str
    recommended: bool
    truth: bool
    studies: int
    rejected: int
    early: int
    rate: float
    error: float
    valid: bool | None


@dataclass(frozen=True, slots=True, kw_only=True)
class AuditedSentence:
    """How often something was said of many simulated agents."""

    world: str
    agents: int
    sentence: str
    truth: bool
    studies: int
    said: int
    rate: float
    error: float
    valid: bool | None


@dataclass(frozen=True, slots=True, kw_only=True)
class AuditedSentences:
    """The shipped audit of what is said of many agents."""

    worlds: Mapping[str, str]
    rates: Sequence[AuditedSentence]


@dataclass(frozen=True, slots=True, kw_only=True)
class AuditResult:
    """The shipped audit of every test."""

    seed: int
    worlds: Mapping[str, str]
    rates: Sequence[AuditedRate]
    many_agents: AuditedSentences

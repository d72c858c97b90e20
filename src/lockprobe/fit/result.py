"""What a fit says, as values."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["CAUTION", "AgentFit", "FitReport", "Parameter", "Predicted", "RivalFit"]

CAUTION = (
    "Models are compared only with each other: the best of them may be far from what the agent does, and a model that "
    "predicts choices need not be how they are made."
)
"""What would be wrong to conclude."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameter:
    """A fitted parameter with its 95 % interval.

    Attributes:
        name: Its name.
        value: Where the likelihood is greatest.
        low: The least value that the choices do not rule out; None if no pull is too low.
        high: The greatest; None if no pull is too high.
        at_bound: Whether the value is the least or the greatest that was allowed.
    """

    name: str
    value: float
    low: float | None
    high: float | None
    at_bound: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Predicted:
    """How well choices were predicted that the model had not been fitted to.

    Attributes:
        log_likelihood: Per choice, natural logarithm.
        gain: Bits per choice better than chance, < 0 if worse.
        low: Lower end of its 95 % interval over clusters of luck; None with fewer than two.
        high: Upper end.
        probability: Of the joint chosen: the geometric mean, [0, 1].
        hits: Share of choices that were the likeliest, [0, 1]; of equally likely ones each counts its part.
    """

    log_likelihood: float
    gain: float
    low: float | None
    high: float | None
    probability: float
    hits: float


@dataclass(frozen=True, slots=True, kw_only=True)
class RivalFit:
    """One model, fitted.

    Attributes:
        model: Its name.
        says: What it claims of the agent, the rest of a sentence.
        version: The version of it that fits best.
        versions: How many there were to choose from.
        spec: An agent that acts as fitted; None where there is none.
        parameters: As fitted.
        log_likelihood: Greatest, natural logarithm; choices count as independent.
        charged: Parameters that the criteria charge it for, at least as many as it has; more where luck is shared.
        aicc: Akaike's criterion for few choices, of the log-likelihood divided by ``AgentFit.repeats``; None with too
            few choices.
        bic: Schwarz's criterion, likewise.
        behind: ``bic`` less that of the best model, >= 0.
        held_out: Prediction of other trials; None with a single cluster of luck.
    """

    model: str
    says: str
    version: str
    versions: int
    spec: str | None
    parameters: tuple[Parameter, ...]
    log_likelihood: float
    charged: float
    aicc: float | None
    bic: float
    behind: float
    held_out: Predicted | None


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentFit:
    """All models of one agent.

    Attributes:
        agent: Agent spec.
        p: Flip probabilities of its trials, rising.
        trials: Trials fitted: solved or out of budget, with at least one step.
        left_out: Trials that ended as an error.
        passed_over: Trials not fitted because there are more than enough.
        choices: Choices fitted.
        clusters: Clusters of luck: trials of equal repetition and trial have equal labels, flips and draws; people.
        repeats: How many choices say as much as one, since luck is shared, >= 1.
        chance_bits: What random leaves to be predicted: mean binary logarithm of the number of joints.
        rivals: The best first, by ``bic``.
        described: The model that describes the agent, which is the best by ``bic``; None if it is not shown to predict
            better than chance. Parameters of any other model are no description.
        lead_by_reports: How far that model is ahead, in BIC, of itself where every attempt counts as failed, whatever
            was reported; None without such a model, or if it heeds no report.
        own: Of the probabilities that the agent itself recorded; no model can be expected to do better.
        finding: What is found, in words.
    """

    agent: str
    p: tuple[float, ...]
    trials: int
    left_out: int
    passed_over: int
    choices: int
    clusters: int
    repeats: float
    chance_bits: float
    rivals: tuple[RivalFit, ...]
    described: str | None
    lead_by_reports: float | None
    own: Predicted | None
    finding: str


@dataclass(frozen=True, slots=True, kw_only=True)
class FitReport:
    """What is found about some agents.

    Attributes:
        agents: One for each agent, or for each agent and p.
        folds: Parts of the trials that were left out in turn.
        caution: What would be wrong to conclude.
    """

    agents: tuple[AgentFit, ...]
    folds: int
    caution: str = CAUTION

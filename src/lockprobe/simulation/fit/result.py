"""The result of a fit: parameters, predictions, ranked models, and claims about an agent."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

__all__ = ["CLOSE", "PULLS", "AgentFit", "FitClaim", "FitReport", "Parameter", "Predicted", "RivalFit"]

CLOSE = 6.0
"""Difference in BIC below which two models are not distinguished: odds of 20 to 1."""

PULLS = ("target", "closed", "failure", "recent", "stay", "position")
"""The pulls of :class:`lockprobe.agents.cognitive.SoftmaxMemory`, which also has ``decay`` and ``reset``."""

_BY_REPORTS = ("closed", "failure", "stay")
"""Pulls that depend on what was reported."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameter:
    """A fitted parameter with its 95 % interval.

    Attributes:
        name: Its name.
        value: The maximum-likelihood value.
        low: Lower end of the interval; None if no pull is too low.
        high: Upper end; None if no pull is too high.
        at_bound: Whether the value lies at a bound of the parameter.
    """

    name: str
    value: float
    low: float | None
    high: float | None
    at_bound: bool

    @property
    def pull(self) -> Parameter:
        """The parameter as a pull towards a joint; ``failure`` pulls away from it, so its sign changes."""
        if self.name != "failure":
            return self
        return replace(self, value=-self.value, low=_negated(self.high), high=_negated(self.low))

    @property
    def shown(self) -> bool:
        """Whether it is a pull whose interval excludes 0."""
        clear = (self.low is not None and self.low > 0) or (self.high is not None and self.high < 0)
        return self.name in PULLS and clear


def _negated(end: float | None) -> float | None:
    return None if end is None else -end


@dataclass(frozen=True, slots=True, kw_only=True)
class Predicted:
    """The hold-out performance of a model: how well it predicts choices that it was not fitted to.

    Attributes:
        log_likelihood: Mean log-likelihood per choice, natural logarithm.
        gain: Gain over chance in bits per choice, < 0 if worse.
        low, high: Ends of its 95 % interval over clusters of luck; None with fewer than two.
        probability: Geometric mean of the probability of the joint chosen, [0, 1].
        hits: Accuracy: share of choices that were the most probable joint, [0, 1]; ties count in part.
    """

    log_likelihood: float
    gain: float
    low: float | None
    high: float | None
    probability: float
    hits: float


@dataclass(frozen=True, slots=True, kw_only=True)
class RivalFit:
    """The fit of one model.

    Attributes:
        model: Its name.
        version: The version that fits best.
        versions: Number of versions.
        spec: Spec of an agent with the fitted parameters; None if there is no such agent.
        parameters: The fitted parameters.
        log_likelihood: Maximum of the log-likelihood, natural logarithm; choices count as independent.
        charged: Effective number of parameters in the criteria, at least the number of parameters; more if luck is
            shared.
        aicc: Akaike's small-sample criterion, with the log-likelihood divided by ``AgentFit.repeats``; None with too
            few choices.
        bic: Schwarz's criterion, computed likewise.
        behind: ``bic`` minus that of the best model, >= 0.
        held_out: Prediction of held-out trials; None with a single cluster of luck.
    """

    model: str
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

    @property
    def predicts(self) -> bool:
        """Whether it is shown to predict held-out trials better than chance."""
        return bool(self.parameters) and self.held_out is not None and (self.held_out.low or 0.0) > 0


class FitClaim(NamedTuple):
    """A claim about an agent, from the best model.

    Attributes:
        about: Name of the pull; ``reports`` if the claim is that the agent heeds reports.
        direction: 1 if the pull makes a joint more likely or reports are heeded, -1 if it makes a joint less likely.
        pull: The pull; None for reports.
    """

    about: str
    direction: int
    pull: Parameter | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentFit:
    """The fits of all models to one agent.

    Attributes:
        agent: Agent spec.
        conditions: Labels of the conditions of its trials.
        trials: Trials fitted: solved or out of budget, with at least one step.
        left_out: Trials that ended as an error.
        passed_over: Trials left out of the random sample of choices.
        choices: Choices fitted.
        clusters: Clusters: trials of equal luck, or people.
        repeats: The design effect: observed choices that carry the information of one independent choice, >= 1.
        chance_bits: Entropy of random choices: mean binary logarithm of the number of joints.
        rivals: The fits by ``bic``, the best first.
        described: The model that describes the agent, the best by ``bic``; None if it is not shown to predict better
            than chance. Parameters of any other model are no description.
        lead_by_reports: The lead of that model, in BIC, over itself where every attempt counts as failed, whatever was
            reported; None without such a model, or if it ignores reports.
        own: Prediction by the probabilities that the agent itself recorded: the best that a model can do.
    """

    agent: str
    conditions: tuple[str, ...]
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

    @property
    def close(self) -> tuple[RivalFit, ...]:
        """The models that are not told apart from the best."""
        return tuple(rival for rival in self.rivals[1:] if rival.behind < CLOSE)

    @property
    def needs_no_reports(self) -> bool:
        """Whether the best model heeds reports and is no worse without them."""
        return self.lead_by_reports is not None and self.lead_by_reports < CLOSE

    @property
    def claims(self) -> tuple[FitClaim, ...]:
        """What acts on the agent, by the best model; nothing if it is not shown to predict."""
        best = self.rivals[0]
        if not best.predicts:
            return ()
        heeded = self.lead_by_reports is not None and not self.needs_no_reports
        silent = _BY_REPORTS if self.needs_no_reports else ()
        pulls = [one.pull for one in best.parameters if one.name not in silent]
        return (
            *([FitClaim("reports", 1)] if heeded else []),
            *(FitClaim(one.name, 1 if one.value > 0 else -1, one) for one in pulls if one.shown),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class FitReport:
    """Fits of some agents.

    Attributes:
        agents: One for each agent, or for each agent and condition.
        folds: Parts of the trials that were left out in turn.
        unpredicted: Conditions under which models predict nothing -> the reason; their trials are in no fit.
    """

    agents: tuple[AgentFit, ...]
    folds: int
    unpredicted: Mapping[str, str] = field(default_factory=dict)

"""The result of a fit: parameters, predictions, models in order, and their claims about an agent."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

__all__ = ["CLOSE", "PULLS", "AgentFit", "FitClaim", "FitReport", "Parameter", "Predicted", "RivalFit"]

CLOSE = 6.0
"""Difference in BIC below which a second model is not told apart from the first: odds of 20 to 1."""

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
        low: The least value that the choices do not rule out; None if no pull is too low.
        high: The greatest; None if no pull is too high.
        at_bound: Whether the value is the least or the greatest allowed.
    """

    name: str
    value: float
    low: float | None
    high: float | None
    at_bound: bool

    @property
    def pull(self) -> Parameter:
        """The same as a pull towards a joint: ``failure`` is one away from it."""
        if self.name != "failure":
            return self
        return replace(self, value=-self.value, low=_negated(self.high), high=_negated(self.low))

    @property
    def shown(self) -> bool:
        """Whether it is a pull whose interval leaves out 0."""
        clear = (self.low is not None and self.low > 0) or (self.high is not None and self.high < 0)
        return self.name in PULLS and clear


def _negated(end: float | None) -> float | None:
    return None if end is None else -end


@dataclass(frozen=True, slots=True, kw_only=True)
class Predicted:
    """How well a model predicts choices that it was not fitted to.

    Attributes:
        log_likelihood: Per choice, natural logarithm.
        gain: Bits per choice better than chance, < 0 if worse.
        low, high: Ends of its 95 % interval over clusters of luck; None with fewer than two.
        probability: Of the joint chosen: the geometric mean, [0, 1].
        hits: Share of choices that were the likeliest, [0, 1]; ties count in part.
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
        version: Its version that fits best.
        versions: Number of versions.
        spec: An agent with the fitted parameters; None where there is none.
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
    """A claim of the best model about an agent.

    Attributes:
        about: The pull that acts on it; ``reports`` if the claim is that it heeds them.
        direction: 1 if the pull makes a joint likelier or reports are heeded, -1 if it makes a joint less likely.
        pull: The pull; None for reports.
    """

    about: str
    direction: int
    pull: Parameter | None = None


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
        clusters: Clusters: trials of equal luck, or people.
        repeats: The design effect: observed choices that carry the information of one independent choice, >= 1.
        chance_bits: Entropy of random choices: mean binary logarithm of the number of joints.
        rivals: The best first, by ``bic``.
        described: The model that describes the agent, the best by ``bic``; None if it is not shown to predict better
            than chance. Parameters of any other model are no description.
        lead_by_reports: The lead of that model, in BIC, over itself where every attempt counts as failed, whatever was
            reported; None without such a model, or if it ignores reports.
        own: Prediction by the probabilities that the agent itself recorded: the best that a model can do.
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
        agents: One for each agent, or for each agent and p.
        folds: Parts of the trials that were left out in turn.
    """

    agents: tuple[AgentFit, ...]
    folds: int

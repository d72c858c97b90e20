"""Model comparison by BIC and AICc, corrected for choices that share luck.

Trials of equal repetition and trial share labels, flips and draws. So an agent may make the same choice in several of
them, and the likelihood counts it every time: a plain BIC misclassifies most random agents in the paper's design.
Therefore log-likelihoods and numbers of choices are divided by the design effect (quasi-likelihood: Lebreton et al.
1992; Burnham and Anderson 2002, Sec. 2.5). A model whose parameters have a larger design effect pays for more
parameters than it has (composite likelihood: Varin and Vidoni 2005; Gao and Song 2010).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lockprobe.agents.policy import Told
from lockprobe.simulation.fit.candidate_models import RIVALS, CandidateModel
from lockprobe.simulation.fit.choices import Choices, Heard, choices_of
from lockprobe.simulation.fit.likelihood import Model
from lockprobe.simulation.fit.optimise import Maximum, design_effects, maximum
from lockprobe.trial.record import Trial

__all__ = ["FittedCandidate", "ModelComparison", "Tell", "compare_models", "lead_by_reports"]

Tell = Callable[[str], None]

_GENERAL = "softmax-memory"
"""The most general model, from which the design effect is estimated."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedCandidate:
    """A candidate model with all its versions fitted.

    Attributes:
        rival: The candidate model.
        versions: Its versions by name.
        fitted: Their maxima.
        effective: Effective number of choices: choices over ``repeats``.
        repeats: The design effect: choices that carry the information of one independent choice.
        charged: Effective number of parameters in the criteria: its number of parameters, times the ratio of their
            design effect to ``repeats`` if that is above 1.
    """

    rival: CandidateModel
    versions: Mapping[str, Model]
    fitted: Mapping[str, Maximum]
    effective: float
    repeats: float
    charged: float

    @property
    def version(self) -> str:
        """The version that fits best."""
        return max(self.fitted, key=lambda name: self.fitted[name].log_likelihood)

    @property
    def model(self) -> Model:
        """The model in the version that fits best."""
        return self.versions[self.version]

    @property
    def best(self) -> Maximum:
        """The maximum of the version that fits best."""
        return self.fitted[self.version]

    @property
    def bic(self) -> float:
        """Schwarz's criterion (BIC), with versions equally likely a priori."""
        return self._deviance + self.charged * math.log(self.effective) + 2 * math.log(len(self.versions))

    @property
    def aicc(self) -> float | None:
        """Akaike's small-sample criterion (AICc); None with too few choices. It has no penalty for versions."""
        size, spare = self.charged, self.effective - self.charged - 1
        return self._deviance + 2 * size + 2 * size * (size + 1) / spare if spare > 0 else None

    @property
    def _deviance(self) -> float:
        return -2 * self.best.log_likelihood / self.repeats


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelComparison:
    """The comparison of all candidate models of the same choices.

    Attributes:
        competitors: The fitted candidates, in the order of the candidate models.
        repeats: The design effect, >= 1.
    """

    competitors: tuple[FittedCandidate, ...]
    repeats: float

    @property
    def ranked(self) -> list[FittedCandidate]:
        """The candidates by BIC, the best first."""
        return sorted(self.competitors, key=lambda one: one.bic)

    @property
    def best(self) -> FittedCandidate:
        """The best candidate by BIC."""
        return self.ranked[0]


def compare_models(
    choices: Choices, heard: Sequence[Heard], rivals: Sequence[CandidateModel], tell: Tell = lambda said: None
) -> ModelComparison:
    """Fit candidate models to choices and compare them; ``tell`` receives each name before its fit."""

    def fitted(rival: CandidateModel) -> tuple[Mapping[str, Model], Mapping[str, Maximum]]:
        tell(rival.name)
        return _fit_versions(rival, choices, heard)

    general = fitted(RIVALS[_GENERAL])
    repeats = _repeats(*general, choices)
    found = (
        _fitted_candidate(rival, *(general if rival.name == _GENERAL else fitted(rival)), choices, repeats)
        for rival in rivals
    )
    return ModelComparison(competitors=tuple(found), repeats=repeats)


def lead_by_reports(winner: FittedCandidate, trials: Sequence[Trial], heard: Sequence[Heard]) -> float | None:
    """The lead in BIC of a model over the same model without information from reports.

    Without information, every attempt counts as a failure and no joint as moved. An agent that ignores reports may seem
    to react to failures, because it mostly attempts joints that fail. Then both models predict it equally well.

    Args:
        winner: The model, as fitted to the reports.
        trials: The trials.
        heard: The same trials as heard.

    Returns:
        The lead, < 0 if reports make the fit worse; None for a model that ignores reports.
    """
    if not winner.rival.heeds:
        return None
    unheeded = [replace(one, told=tuple(told and _as_failure(told) for told in one.told)) for one in heard]
    choices = choices_of(trials, unheeded)
    versions, maxima = _fit_versions(winner.rival, choices, unheeded)
    size = _free_parameters(next(iter(versions.values())))
    twin = _fitted_candidate(winner.rival, versions, maxima, choices, winner.repeats, size)
    return twin.bic - winner.bic


def _as_failure(told: Told) -> Told:
    """The attempt, reported as failed."""
    return replace(told, moved=False, shifted=None if told.shifted is None else 0)


def _fit_versions(
    rival: CandidateModel, choices: Choices, heard: Sequence[Heard]
) -> tuple[Mapping[str, Model], Mapping[str, Maximum]]:
    """The versions of a rival, fitted."""
    versions = rival.versions(choices, heard)
    return versions, {name: maximum(model) for name, model in versions.items()}


def _fitted_candidate(
    rival: CandidateModel,
    versions: Mapping[str, Model],
    fitted: Mapping[str, Maximum],
    choices: Choices,
    repeats: float,
    size: int | None = None,
) -> FittedCandidate:
    """A fitted candidate with its effective number of parameters, from ``size`` parameters or all that it has."""
    size = len(next(iter(fitted.values())).values) if size is None else size
    return FittedCandidate(
        rival=rival,
        versions=versions,
        fitted=fitted,
        effective=max(len(choices) / repeats, 1.0),
        repeats=repeats,
        charged=size * max(1.0, _repeats(versions, fitted, choices) / repeats),
    )


def _free_parameters(model: Model) -> int:
    """Number of identifiable parameters: without a reported move, ``reset`` changes no probability."""
    inside = np.array([0.5 if most == 1.0 else 1.0 for _, most in model.bounds.values()])
    return int((np.abs(model.scores(inside)).max(axis=0, initial=0.0) > 1e-9).sum())


def _repeats(versions: Mapping[str, Model], fitted: Mapping[str, Maximum], choices: Choices) -> float:
    """The design effect under the version that fits best."""
    name = max(fitted, key=lambda one: fitted[one].log_likelihood)
    return design_effects(versions[name], fitted[name].values, choices.cluster).overall

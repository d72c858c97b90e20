"""Comparison of models of the same choices, by a criterion that charges them for their parameters.

Trials of equal repetition and trial share labels, flips and draws, so an agent may make the same choice in several of
them, and the likelihood counts it every time: by a plain BIC most agents that act at random in the paper's design are
something else. Log-likelihoods and numbers of choices are therefore divided by the design effect (quasi-likelihood:
Lebreton et al. 1992; Burnham and Anderson 2002, Sec. 2.5), and a model on whose parameters the choices agree even more
is charged for more parameters than it has (composite likelihood: Varin and Vidoni 2005; Gao and Song 2010).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lockprobe.agents.policy import Told
from lockprobe.fit.candidate_models import RIVALS, CandidateModel
from lockprobe.fit.choices import Choices, Heard, choices_of
from lockprobe.fit.likelihood import Model
from lockprobe.fit.optimise import Maximum, design_effects, maximum
from lockprobe.record import Trial

__all__ = ["FittedCandidate", "ModelComparison", "Tell", "compare_models", "lead_by_reports"]

Tell = Callable[[str], None]

_GENERAL = "softmax-memory"
"""The most general model, from which it is taken how far choices repeat each other."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedCandidate:
    """A rival with all its versions fitted.

    Attributes:
        rival: The rival.
        versions: Its versions by name.
        fitted: Their maxima.
        effective: Effective number of choices: choices over ``repeats``.
        repeats: The design effect: choices that carry the information of one independent choice.
        charged: Parameters that it is charged for: its own, times the ratio of their design effect to ``repeats``, if
            above 1.
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
        """That version."""
        return self.versions[self.version]

    @property
    def best(self) -> Maximum:
        """Its maximum."""
        return self.fitted[self.version]

    @property
    def bic(self) -> float:
        """Schwarz's criterion, with versions equally likely beforehand."""
        return self._deviance + self.charged * math.log(self.effective) + 2 * math.log(len(self.versions))

    @property
    def aicc(self) -> float | None:
        """Akaike's criterion for few choices; None with too few for it. Versions cost nothing in it."""
        size, spare = self.charged, self.effective - self.charged - 1
        return self._deviance + 2 * size + 2 * size * (size + 1) / spare if spare > 0 else None

    @property
    def _deviance(self) -> float:
        return -2 * self.best.log_likelihood / self.repeats


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelComparison:
    """All competitors for the same choices.

    Attributes:
        competitors: In the order of the rivals.
        repeats: The design effect, >= 1.
    """

    competitors: tuple[FittedCandidate, ...]
    repeats: float

    @property
    def ranked(self) -> list[FittedCandidate]:
        """The best first, by BIC."""
        return sorted(self.competitors, key=lambda one: one.bic)

    @property
    def best(self) -> FittedCandidate:
        """The winner by BIC."""
        return self.ranked[0]


def compare_models(
    choices: Choices, heard: Sequence[Heard], rivals: Sequence[CandidateModel], tell: Tell = lambda said: None
) -> ModelComparison:
    """Fit rivals to choices, given also the trials as heard; ``tell`` gets each name before its fit."""

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
    """The lead, in BIC, of a model over itself for an agent to which reports mean nothing.

    That agent takes every attempt for a failure and no joint for moved. An agent that ignores reports may look as if
    failures acted on it, because it mostly attempts joints that fail; then it is predicted as well without the reports.

    Args:
        winner: The model, as fitted to the reports.
        trials: The trials.
        heard: The same as heard.

    Returns:
        The lead, < 0 if reports only make it worse; None for a model that ignores them.
    """
    if not winner.rival.heeds:
        return None
    unheeded = [replace(one, told=tuple(map(_as_failure, one.told))) for one in heard]
    choices = choices_of(trials, unheeded)
    versions, maxima = _fit_versions(winner.rival, choices, unheeded)
    size = _free_parameters(next(iter(versions.values())))
    twin = _fitted_candidate(winner.rival, versions, maxima, choices, winner.repeats, size)
    return twin.bic - winner.bic


def _as_failure(told: Told) -> Told:
    """The same attempt, reported as failed."""
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
    """With its price: ``size`` parameters, or all that it has."""
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
    """Number of parameters that change any probability: ``reset`` does not where no joint was told to have moved."""
    inside = np.array([0.5 if most == 1.0 else 1.0 for _, most in model.bounds.values()])
    return int((np.abs(model.slope(inside).scores).max(axis=0, initial=0.0) > 1e-9).sum())


def _repeats(versions: Mapping[str, Model], fitted: Mapping[str, Maximum], choices: Choices) -> float:
    """The design effect under the version that fits best."""
    name = max(fitted, key=lambda one: fitted[one].log_likelihood)
    return design_effects(versions[name], fitted[name].values, choices.cluster).overall

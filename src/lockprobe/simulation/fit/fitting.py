"""Fits of all candidate models to the trials of agents."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.seeds import generator
from lockprobe.simulation.fit.candidate_models import CandidateModel, candidates_named
from lockprobe.simulation.fit.choices import Choices, choices_of, cluster_of, hear
from lockprobe.simulation.fit.held_out import folds_of, held_out, predicted
from lockprobe.simulation.fit.model_comparison import FittedCandidate, Tell, compare_models, lead_by_reports
from lockprobe.simulation.fit.optimise import parameters
from lockprobe.simulation.fit.result import AgentFit, FitReport, Parameter, RivalFit
from lockprobe.simulation.fit.unpredicted import why_unpredicted
from lockprobe.statistics.outcomes import ended
from lockprobe.trial.record import Trial

__all__ = ["ENOUGH_CHOICES", "fit_agent", "fit_agents"]

ENOUGH_CHOICES = 20_000
"""The most choices that are fitted. Beyond it, whole clusters of luck are sampled with a fixed seed."""


def fit_agents(
    trials: Sequence[Trial],
    *,
    agents: Iterable[str] | None = None,
    conditions: Iterable[str] | None = None,
    models: Iterable[str] | None = None,
    folds: int = 10,
    by_condition: bool = False,
    boxes: Mapping[str, Lockbox] | None = None,
    tell: Tell = lambda said: None,
) -> FitReport:
    """Fit candidate models to the choices of agents, given the reports that they had received.

    Args:
        trials: Trials of any agents. Trials that ended as an error are left out and counted. Conditions under which
            models predict nothing are left out and named
            (:func:`lockprobe.simulation.fit.unpredicted.why_unpredicted`).
        agents: Only these agents; by default all, sorted by name.
        conditions: Only these conditions, by label.
        models: Only these models, and ``random``.
        folds: Number of folds of the cross-validation, at least 2.
        by_condition: Whether each condition is fitted separately.
        boxes: Name -> box, for models that look at the panel.
        tell: Called with the name of each fit.

    Raises:
        UnknownName: If there is no such agent, condition or model; the message lists those that exist.
        BadValue: If there is no trial of an agent under a condition that models predict, or ``folds`` is below 2.
    """
    if folds < 2:
        raise BadValue("folds", folds, "a whole number of at least 2")
    rivals = candidates_named(models)
    kept = _under(trials, conditions)
    specs = {trial.condition: trial.specs for trial in kept}
    unpredicted = {label: why for label, acting in specs.items() if (why := why_unpredicted(acting))}
    groups = _groups(trials, [trial for trial in kept if trial.condition not in unpredicted], agents, by_condition)
    if not groups:
        left = "; ".join(f"{label}: {why}" for label, why in unpredicted.items())
        raise BadValue("trials", left or 0, "at least one of an agent under a condition that models predict")
    found = [fit_agent(agent, mine, rivals, folds=folds, boxes=boxes, tell=tell) for agent, mine in groups]
    return FitReport(agents=tuple(found), folds=folds, unpredicted=unpredicted)


def _under(trials: Sequence[Trial], conditions: Iterable[str] | None) -> list[Trial]:
    """The trials under some conditions, or under all."""
    known = list(dict.fromkeys(trial.condition for trial in trials))
    asked = known if conditions is None else list(conditions)
    for label in asked:
        if label not in known:
            raise UnknownName("condition of these trials", label, known)
    return [trial for trial in trials if trial.condition in asked]


def _groups(
    trials: Sequence[Trial], kept: Sequence[Trial], agents: Iterable[str] | None, by_condition: bool
) -> list[tuple[str, list[Trial]]]:
    """The kept trials of each agent, or of each agent under each condition."""
    there = sorted({trial.group for trial in trials})
    asked = there if agents is None else list(dict.fromkeys(agents))
    for agent in asked:
        if agent not in there:
            raise UnknownName("agent in these trials", agent, there)
    own = (trial for agent in asked for trial in kept if trial.group == agent)
    groups = grouped(own, lambda trial: (trial.group, trial.condition if by_condition else ""))
    return [(agent, mine) for (agent, _), mine in groups.items()]


def fit_agent(
    agent: str,
    trials: Sequence[Trial],
    rivals: Sequence[CandidateModel],
    *,
    folds: int = 10,
    boxes: Mapping[str, Lockbox] | None = None,
    tell: Tell = lambda said: None,
    within: float = math.inf,
) -> AgentFit:
    """Fit all candidate models to the trials of one agent, the best first. Other arguments: :func:`fit_agents`.

    Args:
        agent: Its name.
        trials: Its trials.
        rivals: The candidate models, with ``random``.
        folds: Number of folds of the cross-validation, at least 2.
        boxes: Name -> box, for models that look at the panel.
        tell: Called with the name of each fit.
        within: Models further behind the best, in BIC, get no result, which saves computing their intervals.

    Raises:
        BadValue: If no trial was played.
    """
    counted = [trial for trial in ended(trials) if trial.steps]
    if not counted:
        raise BadValue(f"trials of {agent}", f"{len(trials)} that ended as an error", "at least one that was played")
    used = _sample(counted)
    heard = [hear(trial, boxes) for trial in used]
    choices = choices_of(used, heard)
    found = compare_models(choices, heard, rivals, lambda name: tell(f"{agent}: {name}"))
    rows = []
    for one in found.ranked:
        if one.bic - found.best.bic <= within:
            tell(f"{agent}: {one.rival.name}, intervals and trials left out")
            rows.append(_row(one, found.best, choices, folds))
    shown = rows[0].predicts
    return AgentFit(
        agent=agent,
        conditions=tuple(dict.fromkeys(trial.condition for trial in used)),
        trials=len(used),
        left_out=len(trials) - len(counted),
        passed_over=len(counted) - len(used),
        choices=len(choices),
        clusters=len(np.unique(choices.cluster)),
        repeats=found.repeats,
        chance_bits=float(np.log2(choices.joints).mean()),
        rivals=tuple(rows),
        described=rows[0].model if shown else None,
        lead_by_reports=lead_by_reports(found.best, used, heard) if shown else None,
        own=predicted(choices, choices.own) if len(choices.own) else None,
    )


def _row(one: FittedCandidate, best: FittedCandidate, choices: Choices, folds: int) -> RivalFit:
    found, fold, aside = parameters(one.model, one.best, choices), folds_of(choices.cluster, folds), None
    if fold.max() > 0:
        aside = predicted(choices, held_out(one.versions, one.fitted, fold, choices.present))
    return RivalFit(
        model=one.rival.name,
        version=one.version,
        versions=len(one.versions),
        spec=_spec(one.rival.agent.format(version=one.version), found),
        parameters=found,
        log_likelihood=one.best.log_likelihood,
        charged=one.charged,
        aicc=one.aicc,
        bic=one.bic,
        behind=one.bic - best.bic,
        held_out=aside,
    )


def _sample(trials: Sequence[Trial]) -> list[Trial]:
    """All trials; or, if they hold too many choices, a random sample of whole clusters."""
    if sum(len(trial.steps) for trial in trials) <= ENOUGH_CHOICES:
        return list(trials)
    clusters = grouped(trials, cluster_of)
    keys, drawn, choices = sorted(clusters), list[Trial](), 0
    for place in generator(0, "fit", "some").permutation(len(keys)):
        mine = clusters[keys[place]]
        choices += sum(len(trial.steps) for trial in mine)
        if drawn and choices > ENOUGH_CHOICES:
            break
        drawn += mine
    return drawn


def _spec(agent: str, parameters: Sequence[Parameter]) -> str | None:
    """The spec of an agent with the fitted parameters."""
    fitted = "&".join(f"{one.name}={one.value:.4g}" for one in parameters)
    return f"{agent}{'&' if '?' in agent else '?'}{fitted}" if agent and fitted else agent or None

"""Recovery studies: parameters, models and claims in simulated trials of known agents.

recover_parameters({"target": 0.5, "failure": 2.0, "decay": 0.7, "reset": 0.5}, sets=200)
recover_models({"random": "random", "human-inspired": "human-inspired?lapse=0.15"}, sets=40)
recover_findings(sets=40)
"""

from __future__ import annotations

import asyncio
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from lockprobe.agents.catalogue import resolve
from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.families import box
from lockprobe.foundation.spec import Spec
from lockprobe.interventions.conditions import flips, interventions_in, tells_positions
from lockprobe.interventions.flip import DEFAULT, FlipKind
from lockprobe.interventions.words import TextChannel
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.simulation.fit.candidate_models import RIVALS, candidates_named
from lockprobe.simulation.fit.choices import choices_of, hear
from lockprobe.simulation.fit.fitting import fit_agent
from lockprobe.simulation.fit.known_agents import WORLDS, KnownAgent
from lockprobe.simulation.fit.model_comparison import FittedCandidate, compare_models
from lockprobe.simulation.fit.optimise import maximum, parameters
from lockprobe.simulation.fit.result import CLOSE, FitClaim, Parameter
from lockprobe.trial.condition import Condition
from lockprobe.trial.loop import play
from lockprobe.trial.plan import Plan
from lockprobe.trial.protocols import Agent, Intervention
from lockprobe.trial.record import Trial

__all__ = [
    "ClaimRecovery",
    "ModelRecovery",
    "ParameterRecovery",
    "RecoveryDesign",
    "recover_findings",
    "recover_models",
    "recover_parameters",
    "simulate",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class RecoveryDesign:
    """The trials to play: the paper's flip study, without claims of the agent.

    Attributes:
        box: The box.
        p: Flip probabilities.
        flip: Kind of outcome flip.
        repetitions: Repetitions.
        trials: Trials per repetition and p.
        budget: Budget of a trial in steps.
    """

    box: Lockbox = field(default_factory=box)
    p: tuple[float, ...] = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
    flip: FlipKind = DEFAULT
    repetitions: int = 3
    trials: int = 10
    budget: int = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterRecovery:
    """The recovery of one parameter over many fits.

    Attributes:
        name: Its name.
        truth: Its true value.
        median: Median of the fitted values.
        spread: Standard deviation of the fitted values.
        covered: Coverage: share of 95 % intervals that hold the truth, [0, 1].
        error: Monte Carlo standard error of that share.
    """

    name: str
    truth: float
    median: float
    spread: float
    covered: float
    error: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelRecovery:
    """The recovery of one model: how often each candidate won for its agent.

    Attributes:
        model: The true model.
        sets: Studies played.
        bic: Model -> how often it was the best by BIC.
        aicc: Model -> how often it was the best by AICc.
    """

    model: str
    sets: int
    bic: Mapping[str, int]
    aicc: Mapping[str, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class ClaimRecovery:
    """The claims about agents of one kind, compared with the truth.

    Attributes:
        world: Name of the kind of agent.
        sets: Studies played.
        best: Model -> how often it was the best by BIC.
        described: Studies in which the best model was shown to predict.
        claims: Claim -> number of studies. A claim is the name of the effect, with ``+`` if it makes a joint more
            likely and ``-`` if less likely.
        false: The false claims among them.
        misled: Studies with at least one false claim.
    """

    world: str
    sets: int
    best: Mapping[str, int]
    described: int
    claims: Mapping[str, int]
    false: Mapping[str, int]
    misled: int


def simulate(agent: str | Agent, design: RecoveryDesign, seed: int) -> list[Trial]:
    """Simulate one study of an agent, or of its spec."""
    spec, player = (agent, resolve(agent).make()) if isinstance(agent, str) else (repr(agent), agent)
    plans = [
        Plan(
            study="recovery",
            agent=spec,
            box=design.box,
            condition=condition,
            repetition=repetition,
            trial=trial,
            seed=seed,
            budget=design.budget,
        )
        for condition in flips(design.p, design.flip)
        for repetition in range(1, design.repetitions + 1)
        for trial in range(1, design.trials + 1)
    ]

    async def all_of_them() -> list[Trial]:
        return [
            await play(plan, plant=SymbolicPlant(plan.box), interventions=_acting(plan.condition), agent=player)
            for plan in plans
        ]

    return asyncio.run(all_of_them())


def _acting(condition: Condition) -> tuple[Intervention, ...]:
    """What acts, without words, which no model reads; of a blind modality, that positions are not told."""
    hidden = () if tells_positions(condition.modality) else (TextChannel(tell="outcome"),)
    return (*interventions_in(condition), *hidden)


def recover_parameters(
    truth: Mapping[str, float], *, sets: int, design: RecoveryDesign | None = None, seed: int = 1
) -> list[ParameterRecovery]:
    """Fit the softmax over a fading memory to its own trials, and compare parameter by parameter.

    Args:
        truth: Its parameters; those left out have their default.
        sets: Number of studies to play and fit.
        design: The trials of each study; by default the paper's.
        seed: Seed of the first study; the others follow.
    """
    model = "softmax-memory"
    spec = str(Spec("cognitive", model, {name: repr(value) for name, value in truth.items()}))
    known = {"decay": 1.0, "reset": 1.0} | dict(truth)
    found = []
    for trials in _studies(spec, sets, design or RecoveryDesign(), seed):
        heard = [hear(trial) for trial in trials]
        choices = choices_of(trials, heard)
        fitted = RIVALS[model].versions(choices, heard)[model]
        found.append(parameters(fitted, maximum(fitted), choices))
    return [_parameter_recovery(known.get(same[0].name, 0.0), same) for same in zip(*found, strict=True)]


def _studies(agent: str | Agent, sets: int, design: RecoveryDesign, seed: int) -> Iterator[list[Trial]]:
    return (simulate(agent, design, seed + i) for i in range(sets))


def _parameter_recovery(truth: float, same: Sequence[Parameter]) -> ParameterRecovery:
    values = np.array([one.value for one in same])
    held = [(one.low is None or one.low <= truth) and (one.high is None or truth <= one.high) for one in same]
    covered = sum(held) / len(held)
    return ParameterRecovery(
        name=same[0].name,
        truth=truth,
        median=float(np.median(values)),
        spread=float(values.std()),
        covered=covered,
        error=math.sqrt(covered * (1 - covered) / len(held)),
    )


def recover_models(
    agents: Mapping[str, str | Agent], *, sets: int, design: RecoveryDesign | None = None, seed: int = 1
) -> list[ModelRecovery]:
    """Count how often the true model wins against all others.

    Args:
        agents: True model -> an agent that acts by it, or its spec.
        sets: Number of studies to play and fit for each agent.
        design: The trials of each study; by default the paper's.
        seed: Seed of the first study of each agent; the others follow.

    Raises:
        UnknownName: If there is no such model.
    """
    candidates_named(agents)
    asked, found = design or RecoveryDesign(), []
    for model, agent in agents.items():
        bic: Counter[str] = Counter()
        aicc: Counter[str] = Counter()
        for trials in _studies(agent, sets, asked, seed):
            heard = [hear(trial, {asked.box.name: asked.box}) for trial in trials]
            held = compare_models(choices_of(trials, heard), heard, candidates_named())
            bic[held.best.rival.name] += 1
            aicc[min(held.competitors, key=_aicc).rival.name] += 1
        found.append(ModelRecovery(model=model, sets=sets, bic=dict(bic), aicc=dict(aicc)))
    return found


def _aicc(one: FittedCandidate) -> float:
    return math.inf if one.aicc is None else one.aicc


def recover_findings(
    worlds: Mapping[str, KnownAgent] = WORLDS, *, sets: int, design: RecoveryDesign | None = None, seed: int = 1
) -> Iterator[ClaimRecovery]:
    """Count how often fits lead to false claims about an agent, one kind of agent after the other.

    Other arguments as for :func:`recover_models`; ``worlds`` holds agents and the truth about them, by name.
    """
    asked = design or RecoveryDesign()
    for name, world in worlds.items():
        best: Counter[str] = Counter()
        told: Counter[str] = Counter()
        false: Counter[str] = Counter()
        described = misled = 0
        for trials in _studies(world.agent, sets, asked, seed):
            fit = fit_agent(name, trials, candidates_named(), boxes={asked.box.name: asked.box}, within=CLOSE)
            found = fit.claims
            wrong = [claim for claim in found if not _true(claim, world)]
            best[fit.rivals[0].model] += 1
            described += fit.described is not None
            told.update(map(_signed, found))
            false.update(map(_signed, wrong))
            misled += bool(wrong)
        yield ClaimRecovery(
            world=name,
            sets=sets,
            best=dict(best),
            described=described,
            claims=dict(told),
            false=dict(false),
            misled=misled,
        )


def _true(claim: FitClaim, world: KnownAgent) -> bool:
    return world.pulls.get(claim.about, 0) in (None, claim.direction)


def _signed(claim: FitClaim) -> str:
    return f"{claim.about} {'+' if claim.direction > 0 else '-'}"

"""A study directory as the numbers of ``results.json``. They depend on the records alone, not on any clock."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from lockprobe.analysis.finding import finding
from lockprobe.analysis.summary import AgentSummary, ConditionSummary, StudySummary, summarise
from lockprobe.record import Trial
from lockprobe.report.tables import percent
from lockprobe.studies.journal import load, planned_trials, read_settings

__all__ = ["RESULTS_VERSION", "LoadedStudy", "numbers", "read", "results"]

RESULTS_VERSION = 1
"""Version of the layout of ``results.json``."""

PAPER = (
    ("Fig. 3", "80 % solved by step (human-inspired)", "9", "human-inspired"),
    ("Table 1", "misinterpretation rate per trial, symbolic state", "4.9 % ± 6.9 % (GPT o1)", "misinterpretation"),
    ("Fig. 4", "success when told the truth", "23.3 % (GPT-4o)", "baseline"),
    ("Fig. 4", "p of the highest success", "0.4", "best"),
    ("Fig. 4", "highest success over that at p = 0", "≈ 2.85", "ratio"),
    ("Fig. 4", "order of the fit by AIC / by cross-validation", "2", "order"),
    ("Fig. 5b", "trials with a loop when told the truth", "≈ 80 %", "loops"),
    ("Fig. 5a", "r of loop rate and success", "\N{MINUS SIGN}0.69", "r"),
)
"""What the paper reports: place, quantity, its value, and the name under which :func:`_measured` has ours."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadedStudy:
    """What a directory holds.

    Attributes:
        settings: As in ``study.json``.
        trials: By agent in the order of the settings, then by condition.
        summary: Their numbers.
        planned: Trials that the settings ask for; None if they do not say.
    """

    settings: Mapping[str, Any]
    trials: tuple[Trial, ...]
    summary: StudySummary
    planned: int | None

    @property
    def finished(self) -> int:
        """Trials that are not owed (any more)."""
        return sum(not trial.owed_again for trial in self.trials)

    @property
    def partial(self) -> bool:
        """Whether trials are still owed."""
        return self.planned is not None and self.finished < self.planned


def read(directory: Path | str) -> LoadedStudy:
    """Read and summarise a study directory."""
    settings: dict[str, Any] = read_settings(directory)
    order = {name: i for i, name in enumerate(settings.get("agents") or ())}
    trials = sorted(
        load(directory),
        key=lambda trial: (
            order.get(trial.agent, len(order)),
            trial.agent,
            trial.modality,
            trial.p,
            trial.repetition,
            trial.trial,
        ),
    )
    return LoadedStudy(
        settings=settings, trials=tuple(trials), summary=summarise(trials), planned=planned_trials(settings)
    )


def results(directory: Path | str) -> dict[str, Any]:
    """The numbers of a study as JSON holds them; equal records give equal results.

    Raises:
        BadFile: If the directory is not that of a study.
    """
    return numbers(read(directory))


def numbers(study: LoadedStudy) -> dict[str, Any]:
    """The content of ``results.json``."""
    agents = study.summary.agents
    content = {
        "schema_version": RESULTS_VERSION,
        "lockprobe": version("lockprobe"),
        "study": dict(study.settings),
        "progress": {"planned": study.planned, "finished": study.finished, "partial": study.partial},
        "findings": [finding(agent) for agent in study.summary.subjects],
        "conditions": [_condition(condition) for condition in study.summary.conditions],
        "fits": [
            {
                "agent": agent.agent,
                "modality": agent.modality,
                "reference": agent.reference,
                "blind": agent.blind,
                "success": asdict(agent.success_fit),
                "loop_rate": asdict(agent.loop_fit),
                "correlation": asdict(agent.correlation),
            }
            for agent in agents
        ],
        "tests": [_test(agent) for agent in agents if agent.contrast],
        "paper": _beside_paper(study.summary),
    }
    plain: dict[str, Any] = _plain(content)
    return plain


def _plain(value: Any) -> Any:
    """The value with nulls for what is not a number, and lists for tuples."""
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Mapping):
        return {key: _plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(inner) for inner in value]
    return value


def _condition(condition: ConditionSummary) -> dict[str, Any]:
    success, loops, said = condition.success, condition.behaviour.loops, condition.claims
    return {
        "key": condition.key,
        "agent": condition.agent,
        "modality": condition.modality,
        "p": condition.p,
        "trials": success.n,
        "solved": success.count,
        "success": success.value,
        "success_low": success.low,
        "success_high": success.high,
        "looping": loops.count,
        "loop_rate": loops.value,
        "loop_rate_low": loops.low,
        "loop_rate_high": loops.high,
        "loop_rate_chance": condition.behaviour.chance_uniform,
        "loop_rate_chance_no_repeat": condition.behaviour.chance_no_repeat,
        "coverage": condition.behaviour.coverage,
        "redundant_share": condition.behaviour.redundant_share,
        "policy_entropy": condition.behaviour.entropy,
        "policy_entropy_steps": condition.behaviour.entropy_steps,
        "misinterpretations": said.total,
        "misinterpretation_rate": said.mean_rate,
        "misinterpretation_rate_sd": said.sd_rate,
        "misinterpretation_rate_pooled": said.pooled.value,
        "misinterpretation_trials": said.trials,
        "misinterpretation_trials_affected": said.affected,
        "claims": said.pooled.n,
        "claims_against_truth": said.against_truth.count,
        "median_steps": condition.curve.median_steps,
        "mean_steps": condition.curve.mean_steps,
        "steps_to_80": condition.curve.steps_to(0.8),
        "errors": dict(condition.errors),
        "curve": {
            "steps": condition.curve.steps,
            "share": condition.curve.share,
            "low": condition.curve.low,
            "high": condition.curve.high,
        },
        "repetitions": [asdict(point) for point in condition.points],
    }


def _test(agent: AgentSummary) -> dict[str, Any]:
    contrast = agent.contrast
    assert contrast is not None
    return {
        "test": "Fisher's exact, two-sided; Bonferroni over the choice of the other p",
        "agent": agent.agent,
        "modality": agent.modality,
        "baseline_p": contrast.baseline.p,
        "other_p": contrast.other.p,
        "choices": contrast.choices,
        "difference": contrast.difference.value,
        "difference_low": contrast.difference.low,
        "difference_high": contrast.difference.high,
        "p_value": contrast.difference.p_value,
        "p_adjusted": contrast.p_adjusted,
        "detectable": contrast.detectable,
    }


def _beside_paper(summary: StudySummary) -> list[dict[str, Any]]:
    """The paper's numbers beside what was measured for the agents that the study is about."""
    rows = []
    for place, quantity, value, name in PAPER:
        agents = (
            [a for a in summary.agents if a.agent.startswith("human-inspired")]
            if name == "human-inspired"
            else list(summary.subjects)
        )
        here = {agent.agent: said for agent in agents if (said := _measured(agent)[name])}
        rows.append({"place": place, "quantity": quantity, "paper": value, "here": here})
    return rows


def _measured(agent: AgentSummary) -> dict[str, str]:
    counted = [condition for condition in agent.conditions if condition.success.n]
    if not counted or counted[0].p != 0:
        return dict.fromkeys((name for *_, name in PAPER), "")
    first, fit = counted[0], agent.success_fit
    loops = first.behaviour
    best = max(counted, key=lambda condition: condition.success.value)
    said, r, several = first.claims, agent.correlation.r, len(counted) > 1 and not agent.blind
    ratio = best.success.value / first.success.value if first.success.count else None
    return {
        "human-inspired": str(first.curve.steps_to(0.8) or "not reached"),
        "misinterpretation": ""
        if said.mean_rate is None
        else percent(said.mean_rate) + ("" if said.sd_rate is None else f" ± {percent(said.sd_rate)}"),
        "baseline": f"{percent(first.success.value)} (n = {first.success.n})",
        "best": f"{best.p:g}" if several else "the same at every p" if agent.blind else "",
        "ratio": "" if not several else "undefined: none solved at p = 0" if ratio is None else f"{ratio:.2f}",
        "order": "" if fit.order_by_aic is None else f"{fit.order_by_aic} / {fit.order_by_cv}",
        "loops": f"{percent(loops.loops.value, 0)} (chance {percent(loops.chance_uniform, 0)} to "
        f"{percent(loops.chance_no_repeat, 0)})",
        "r": ""
        if r is None or agent.blind
        else f"{r:.2f}".replace("-", "\N{MINUS SIGN}") + f" (n = {agent.correlation.n})",
    }

"""Scores and metrics of trials in an Inspect log, and the trial in words.

The score has five values. ``success``: 1 or 0. ``steps``: the number of steps, or the whole budget if the box was not
opened, as in the comparisons of the report. ``loop``: 1 if there is an action loop (Sec. 3.3), by the exact cover in
linear time. ``loop_chance``: the probability of one in a random trial of that length, without which a loop rate says
nothing. ``misinterpretation``: share of its claims that contradict what it was told (Sec. 3.1), unscored where it made
none. A trial that broke is unscored as a whole, so an error is never counted as a failure to solve. The score's
metadata holds the whole record, where neither a crash nor ``eval-retry`` loses it.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from lockprobe.foundation.errors import needing
from lockprobe.foundation.formatting import markdown_table
from lockprobe.trial.record import Outcome, Step, Trial
from lockprobe.trial.told_outcome import in_words
from lockprobe.trial.trial_json import trial_from_json, trial_to_json

with needing("Inspect logs", "providers"):
    from inspect_ai.scorer import Metric, Score, Scorer, Target, grouped, mean, scorer, stderr
    from inspect_ai.solver import TaskState

if TYPE_CHECKING:
    from lockprobe.studies.study import Study

__all__ = [
    "SCORER",
    "TRIAL",
    "VALUES",
    "metrics_header",
    "metrics_of",
    "played",
    "score_of",
    "step_as_markdown",
    "step_metadata",
    "trial_as_markdown",
]

SCORER = "played"
"""Name of the scorer."""

TRIAL = "trial"
"""The key of a trial's record in the metadata of its score and in the store of its sample."""

VALUES = ("success", "steps", "loop", "loop_chance", "misinterpretation")
"""The values of a score."""

_APART = ("success", "loop", "loop_chance")
"""The values that are also summarised by condition."""


def score_of(trial: Trial) -> Score:
    """The score of a trial."""
    from lockprobe.statistics.loops import any_loop
    from lockprobe.statistics.misinterpretation import trial_claims

    metadata = {"ending": trial.ending, "steps_played": len(trial.steps), TRIAL: trial_to_json(trial).decode()}
    answer, explanation = _answer(trial), trial_as_markdown(trial)
    if trial.error is not None:
        reason = "invalid_response_format" if trial.error.boundary == "reply" else str(trial.error.boundary)
        return Score.unscored(reason=reason, answer=answer, explanation=explanation, metadata=metadata)
    rate = trial_claims(trial).rate
    value: dict[str, str | int | float | bool | None] = {
        "success": int(trial.solved),
        "steps": len(trial.steps) if trial.solved else trial.budget,
        "loop": int(any_loop(trial.actions)),
        "loop_chance": _loop_chance(len(trial.steps), len(trial.joints)),
        "misinterpretation": float("nan") if rate is None else rate,
    }
    return Score(value=value, answer=answer, explanation=explanation, metadata=metadata)


@cache
def _loop_chance(length: int, joints: int) -> float:
    from lockprobe.statistics.loops.chance import chance_level

    return chance_level(length, joints).probability


def _answer(trial: Trial) -> str:
    if trial.error is not None:
        return f"broke in step {trial.error.step} ({trial.error.boundary}): {trial.error.message}"
    return f"{'opened' if trial.solved else 'not opened'} in {len(trial.steps)} steps"


def trial_as_markdown(trial: Trial) -> str:
    """A trial in Markdown, one row per step: the truth, the report and the agent's claim."""
    names = dict(zip(trial.joints, trial.labels, strict=True))
    said = [step.decision.claimed for step in trial.steps[1:]] + [None] * bool(trial.steps)
    heading = f"{_answer(trial).capitalize()}. The target is **{names[trial.target]}** ({trial.target})."
    head = ["#", "attempted", "true", "told", "said afterwards", "state before", "hypothesis"]
    rows = [
        [
            str(step.step),
            f"{step.decision.joint} ({step.joint})",
            in_words(step.moved),
            _told(step),
            _said(step, claimed),
            step.state,
            _in_a_cell(step.decision.hypothesis),
        ]
        for step, claimed in zip(trial.steps, said, strict=True)
    ]
    return f"{heading}\n\n{markdown_table(head, *rows)}"


def step_as_markdown(step: Step) -> str:
    """One step in Markdown, for the transcript: truth and report."""
    true = in_words(step.moved)
    return f"Step {step.step}: {step.decision.joint} ({step.joint}). True: {true}. Told: {_told(step)}."


def step_metadata(step: Step) -> dict[str, object]:
    """Truth and report as metadata of the message that chose the joint; a model never sees metadata."""
    return {
        "step": step.step,
        "attempted": f"{step.decision.joint} ({step.joint})",
        "true": in_words(step.moved),
        "told": _told(step).replace("**", ""),
    }


def _told(step: Step) -> str:
    told = in_words(step.told_moved)
    return f"**{told}** (false report)" if step.told_falsely else told


def _said(step: Step, claimed: Outcome | None) -> str:
    if claimed is None:
        return ""
    agrees = step.told_moved is None or claimed == ("moved" if step.told_moved else "blocked")
    return in_words(claimed) if agrees else f"**{in_words(claimed)}** (misread)"


def _in_a_cell(text: str) -> str:
    """Words of a model on one line, so that they cannot end a row or a cell."""
    return " ".join(text.split()).replace("\\", "\\\\").replace("|", "\\|")


def metrics_of(study: Study) -> dict[str, list[Metric]]:
    """The metrics of a log, by value of the score: means, standard errors, and means of every condition.

    Standard errors are clustered by repetition, as Inspect AI has them. In a study of one repetition they are clustered
    by trial, since the same trial of all conditions shares its luck. With a single cluster Inspect says 0. Repetition,
    trial and condition stand in the metadata of each sample.
    """
    summed: list[Metric] = [mean(), stderr(cluster=_cluster(study))]
    apart: list[Metric] = [grouped(mean(), "condition", all=False)]
    return {value: summed + (apart if value in _APART else []) for value in VALUES}


def metrics_header(study: Study) -> dict[str, list[dict[str, object]]]:
    """The metrics by name, as in the header of a log."""
    summed: list[dict[str, object]] = [
        {"name": "inspect_ai/mean", "options": {}},
        {"name": "inspect_ai/stderr", "options": {"cluster": _cluster(study)}},
    ]
    options = {"metric": {"type": "metric", "name": "mean", "params": {}}, "group_key": "condition", "all": False}
    apart: dict[str, object] = {"name": "inspect_ai/grouped", "options": options}
    return {value: summed + ([apart] if value in _APART else []) for value in VALUES}


def _cluster(study: Study) -> str:
    return "repetition" if study.repetitions > 1 else "trial"


@scorer(metrics={value: [mean()] for value in VALUES})
def played() -> Scorer:
    """Score a played trial; a sample that was cut off before its end stays unscored."""

    async def score(state: TaskState, target: Target) -> Score:
        line = state.store.get(TRIAL)
        if line is None:
            return Score.unscored(reason="scoring_failed", explanation="the trial did not come to its end")
        return score_of(trial_from_json(str(line)))

    return score

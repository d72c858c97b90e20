"""Trials as rows, one per trial, for whoever compares conditions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from lockprobe.analysis.loops import measure
from lockprobe.analysis.misinterpretation import trial_claims
from lockprobe.export.tidy import TidyCell
from lockprobe.record import Trial

__all__ = ["TRIAL_COLUMNS", "trial_columns", "trial_rows"]

TRIAL_COLUMNS = (
    "key",
    "agent",
    "box",
    "modality",
    "p",
    "repetition",
    "trial",
    "ending",
    "solved",
    "steps",
    "budget",
    "moves",
    "false_reports",
    "claims",
    "misinterpretations",
    "any_loop",
    "loop_coverage",
    "error",
)
"""Names of the columns, in order; :data:`lockprobe.export.data_dictionary.COLUMN` says what stands in each."""


def trial_columns(trials: Sequence[Trial]) -> tuple[str, ...]:
    """The columns of the rows of these trials: :data:`TRIAL_COLUMNS`, and their conditions where they have names."""
    return (*TRIAL_COLUMNS, *(("condition",) if any(trial.condition for trial in trials) else ()))


def trial_rows(trials: Iterable[Trial]) -> Iterator[dict[str, TidyCell]]:
    """One row per trial, one that broke before its first step too.

    ``solved`` is 1 or 0, and empty where the trial ended as an error, which is no failure to solve.
    ``misinterpretations`` counts the claims that contradict what had been told. In studies of other things than flip
    rates the last column is ``condition``, and ``p`` is empty unless nothing but flips acted.

    Args:
        trials: The trials.

    >>> import lockprobe
    >>> (row,) = trial_rows([lockprobe.run_trial(agent="human-inspired", p=0.0, seed=1)])
    >>> row["solved"], row["budget"], row["false_reports"]
    (1, 20, 0)
    """
    trials = list(trials)
    loops = measure([trial.actions for trial in trials])
    named = any(trial.condition for trial in trials)
    for place, trial in enumerate(trials):
        said = trial_claims(trial)
        yield {
            "key": trial.key,
            "agent": trial.agent,
            "box": trial.box,
            "modality": trial.modality,
            "p": "" if trial.p is None else trial.p,
            "repetition": trial.repetition,
            "trial": trial.trial,
            "ending": trial.ending,
            "solved": "" if trial.error else int(trial.solved),
            "steps": said.steps,
            "budget": trial.budget,
            "moves": sum(step.moved for step in trial.steps),
            "false_reports": said.false_reports,
            "claims": len(said.claims),
            "misinterpretations": said.misinterpreted,
            "any_loop": int(loops.any_loop[place]),
            "loop_coverage": float(loops.share[place]) if trial.steps else "",
            "error": trial.error.boundary if trial.error else "",
            **({"condition": trial.condition} if named else {}),
        }

"""Trials as tidy rows, one per step or one per trial, for any statistics package."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.terminal_text import readable
from lockprobe.statistics.loops import measure
from lockprobe.statistics.misinterpretation import claims
from lockprobe.trial.record import Trial
from lockprobe.trial.source import CAMERA, VERDICT

_WHICH = ("key", "agent", "box", "modality", "p", "repetition", "trial")
"""The columns that identify a trial, in both tables."""

COLUMNS = (
    *_WHICH,
    "step",
    "joint",
    "label",
    "moved",
    "told",
    "claimed",
    "misread",
    "state",
    "target",
    "ending",
    "reply",
)
"""Names of the columns of steps, in order."""

TRIAL_COLUMNS = (
    *_WHICH,
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
"""Names of the columns, in order; :data:`lockprobe.interfaces.export.data_dictionary.COLUMN` describes them."""

TidyCell = str | int | float

NO_SECONDS: Mapping[str, float] = MappingProxyType({})
"""No durations of trials, by key."""


def tidy_rows(trials: Iterable[Trial]) -> Iterator[dict[str, TidyCell]]:
    """One row per step.

    ``agent`` is its name if it has one, else its spec. ``moved`` (the truth), ``told`` (what the report implied),
    ``claimed`` (what the agent said of this step in its next decision) and ``misread`` (whether that contradicts the
    report) are 0, 1 or empty. ``state`` is the true configuration before the step, a bit string in panel order.
    ``target`` is 1 on the row that moved the target. ``reply`` is the model's reply that chose the joint. A trial that
    broke before its first step has no row. In a modality with pictures ``told`` is what the picture shows: the truth.

    Columns that come last, and only where they say something: ``condition``, its name, where flip rates
    do not tell all apart (``p`` is empty for other interventions); ``chosen``, the joint that the agent had chosen,
    where an intervention had another one attempted; ``panel``, the joints in the panel order of the trial,
    where trials have different panels (``--layout shuffled``); ``verdict``, what a robot took to have happened (moved,
    blocked or failed), where one played; ``camera``, the positions that a camera read after the step, in panel order
    with ``?`` for an unclear joint, where reports have a named source.
    """
    trials = list(trials)
    more = tidy_columns(trials)[len(COLUMNS) :]
    for trial in trials:
        label = dict(zip(trial.joints, trial.labels, strict=True))
        for step, said in zip(trial.steps, trial.said, strict=True):
            told, claimed = _mark(step.told_moved), _mark(None if said is None else said == "moved")
            last: dict[str, TidyCell] = {
                "condition": trial.condition,
                "chosen": step.chosen or "",
                "panel": " ".join(trial.joints),
                "verdict": str(step.sensed.get(VERDICT, "")),
                "camera": str(step.sensed.get(CAMERA, "")),
            }
            row: dict[str, TidyCell] = {
                **_which(trial),
                "step": step.step,
                "joint": step.joint,
                "label": label[step.joint],
                "moved": int(step.moved),
                "told": told,
                "claimed": claimed,
                "misread": "" if "" in (told, claimed) else int(told != claimed),
                "state": step.state,
                "target": int(step.moved and step.joint == trial.target),
                "ending": trial.ending,
                "reply": step.decision.replies[-1] if step.decision.replies else "",
                **{name: last[name] for name in more},
            }
            yield {name: readable(cell) if isinstance(cell, str) else cell for name, cell in row.items()}


def _mark(value: bool | None) -> TidyCell:
    return "" if value is None else int(value)


def tidy(trials: Trial | Iterable[Trial]) -> list[dict[str, TidyCell]]:
    """The steps of one or several trials as a table for pandas, polars or R: one row per step, truth and report.

    ``pandas.DataFrame(lockprobe.tidy(trials))``. The columns are those of :func:`tidy_rows`.
    """
    return list(tidy_rows(_several(trials)))


def _several(trials: Trial | Iterable[Trial]) -> list[Trial]:
    """One or several trials as a list."""
    if isinstance(trials, str | Path) or not isinstance(trials, Trial | Iterable):
        raise BadValue("trials", trials, "a trial or several, for example those of lockprobe.load(DIR)")
    return [trials] if isinstance(trials, Trial) else list(trials)


def _which(trial: Trial) -> dict[str, TidyCell]:
    found = {name: "" if (value := getattr(trial, name)) is None else value for name in _WHICH}
    return {**found, "agent": trial.called or trial.agent}


def _are_named(trials: Sequence[Trial]) -> bool:
    """Whether flip rate and modality do not tell all conditions apart."""
    conditions = {(trial.modality, trial.condition) for trial in trials}
    rates = {(trial.modality, trial.p) for trial in trials}
    return any(trial.p is None for trial in trials) or len(conditions) > len(rates)


def tidy_columns(trials: Sequence[Trial]) -> tuple[str, ...]:
    """The columns of the tidy rows of these trials: :data:`COLUMNS`, then the optional ones that apply."""
    says = {
        "condition": _are_named(trials),
        "chosen": any(step.chosen for trial in trials for step in trial.steps),
        "panel": len({(trial.box, trial.joints) for trial in trials}) > len({trial.box for trial in trials}),
        "verdict": any(VERDICT in step.sensed for trial in trials for step in trial.steps),
        "camera": any(CAMERA in step.sensed for trial in trials for step in trial.steps),
    }
    return (*COLUMNS, *(name for name, something in says.items() if something))


def trial_columns(trials: Sequence[Trial], seconds: Mapping[str, float] = NO_SECONDS) -> tuple[str, ...]:
    """The columns of the rows of these trials: :data:`TRIAL_COLUMNS`, the condition if it has a name, durations."""
    named = ("condition",) if _are_named(trials) else ()
    return (*TRIAL_COLUMNS, *named, *(("trial_seconds",) if seconds else ()))


def trial_rows(
    trials: Trial | Iterable[Trial], seconds: Mapping[str, float] = NO_SECONDS
) -> Iterator[dict[str, TidyCell]]:
    """One row per trial, including trials that broke before their first step.

    ``solved`` is 1 or 0, and empty if the trial ended as an error, which is not a failure to solve.
    ``misinterpretations`` counts the claims that contradict the report. Where flip rates do not tell all
    conditions apart there is a column ``condition``, and ``p`` is empty unless only flips acted. ``trial_seconds`` is
    how long each box took, by key, where people played (``seconds``).

    >>> import lockprobe
    >>> (row,) = trial_rows([lockprobe.run_trial(agent="human-inspired", p=0.0, seed=1)])
    >>> row["solved"], row["budget"], row["false_reports"]
    (1, 20, 0)
    """
    trials = _several(trials)
    loops = measure([trial.actions for trial in trials])
    named = _are_named(trials)
    for place, trial in enumerate(trials):
        said = claims(trial)
        yield {
            **_which(trial),
            "ending": trial.ending,
            "solved": "" if trial.error else int(trial.solved),
            "steps": len(trial.steps),
            "budget": trial.budget,
            "moves": sum(step.moved for step in trial.steps),
            "false_reports": sum(step.told_falsely for step in trial.steps),
            "claims": len(said),
            "misinterpretations": sum(one.misread for one in said),
            "any_loop": int(loops.any_loop[place]),
            "loop_coverage": float(loops.share[place]) if trial.steps else "",
            "error": trial.error.boundary if trial.error else "",
            **({"condition": trial.condition} if named else {}),
            **({"trial_seconds": seconds.get(trial.key, "")} if seconds else {}),
        }

"""The tables of trials: a row per step, or a row per trial, for any statistics package."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from lockprobe.foundation.errors import BadValue
from lockprobe.interfaces.export.table import Cell, Column, Table, count, mark, number, text
from lockprobe.people.diary import Attempt, Did
from lockprobe.statistics.loops import cover
from lockprobe.statistics.misinterpretation import claims
from lockprobe.trial.record import Outcome, Step, Trial
from lockprobe.trial.source import CAMERA, VERDICT

PAGE = "by the monotonic clock of the participant's browser (performance.now)"
SERVER = "by the clock of the server"

NOBODY: Mapping[tuple[str, int], Did] = MappingProxyType({})
"""The acts of people behind the steps of trials that nobody played."""


class StepRow(NamedTuple):
    """One step, what the agent said of it in its next decision, and the acts of a person behind this and the next."""

    trial: Trial
    step: Step
    said: Outcome | None
    did: Did | None = None
    next_did: Did | None = None

    @property
    def claimed(self) -> bool | None:
        """Whether the agent said that the joint moved; None if it was not asked."""
        return None if self.said is None else self.said == "moved"


class TrialRow(NamedTuple):
    """One trial, its loops, and how long a person took for it, seconds."""

    trial: Trial
    any_loop: bool
    loop_coverage: float
    seconds: float | None = None


def identity(trial: Trial) -> str:
    """The participant who played a trial; empty if no person did."""
    return trial.player.removeprefix(f"{trial.group}:")


PARTICIPANT = "The participant: a random ID from the server, independent of the person."

_OF_TRIAL: Sequence[Column] = (
    text("participant", PARTICIPANT, lambda row: identity(row.trial), optional=True),
    text("key", "The trial: its readable name in the study. A trial is one box, played from its start.",
         lambda row: row.trial.key),
    text("agent", "The agent that played: participant:ID for people; its name, or its spec if it has none, for others.",
         lambda row: row.trial.called or row.trial.agent),
    text("box", "Name of the lockbox.", lambda row: row.trial.box),
    text("modality", "How the box was shown: symbolic (reports), rgb or rgbd (pictures).",
         lambda row: row.trial.modality),
    text("condition", "The condition: its name, or its interventions.", lambda row: row.trial.condition),
    number("p", "Flip rate: probability that a report says the opposite, independent for each step. Empty if other "
           "interventions acted.", lambda row: row.trial.p, most=1),
    count("repetition", "Repetition of the study, from 1.", lambda row: row.trial.repetition),
    count("trial", "Trial within repetition and condition, from 1. Trials of one repetition and number share their "
          "luck.", lambda row: row.trial.trial),
)  # fmt: skip
"""What identifies a trial, in both tables."""

_OF_PERSON: Sequence[Column] = (
    count("position", "Number of the box in the participant's order, from 1.",
          lambda row: row.trial.facts.get("position") if identity(row.trial) else None, optional=True),
    text("view", "How the page showed the box: text, panel (drawn) or pictures.",
         lambda row: row.trial.facts.get("view") if identity(row.trial) else None, optional=True),
)  # fmt: skip


def _misread(row: StepRow) -> bool | None:
    return None if None in (row.claimed, row.step.told_moved) else row.claimed != row.step.told_moved


def _claim_time(did: Did | None) -> float | None:
    """The response time of the claim of an act; None without one."""
    return did.act.claimed_rt if did is not None and isinstance(did.act, Attempt) else None


STEPS: Sequence[Column] = (
    *_OF_TRIAL,
    count("step", "Step within the trial, from 1: one attempt to move one joint.", lambda row: row.step.step),
    text("joint", "The attempted joint, by its name in the box.", lambda row: row.step.joint),
    text("label", "The attempted joint, by the letter that the agent knew it by.",
         lambda row: row.trial.labels[row.trial.joints.index(row.step.joint)]),
    mark("moved", "whether the joint really moved.", lambda row: row.step.moved),
    mark("told_moved", "whether the report after the step said that it moved; with pictures, whether the picture shows "
         "that. Empty if nothing was reported.", lambda row: row.step.told_moved),
    mark("claimed", "whether the agent then said that it moved, when it chose the next joint. Empty for the last step, "
         "and if it was not asked.", lambda row: row.claimed),
    mark("misread", "whether it said the opposite of the report: claimed differs from told. Empty if one of them is.",
         _misread),
    text("state", "True configuration before the step: 0 or 1 for each joint, in panel order. CSV files have b in "
         "front (b0110), so that no program reads it as a number and drops leading zeros.",
         lambda row: row.step.state, kind="bits"),
    mark("target", "whether this step moved the target joint, which opens the box.",
         lambda row: row.step.moved and row.step.joint == row.trial.target),
    text("ending", "How the trial ended: solved, budget (steps ran out), error (broken, not a failure to solve).",
         lambda row: row.trial.ending),
    text("panel", "The joints in the panel order of the trial.", lambda row: " ".join(row.trial.joints)),
    text("reply", "The reply of a model that chose the joint, word for word. Replies before it that could not be read "
         "stand in study.db. Empty for all other agents.",
         lambda row: row.step.decision.replies[-1] if row.step.decision.replies else "", optional=True),
    text("chosen", "The chosen joint, if an intervention replaced it by another one; else empty.",
         lambda row: row.step.chosen, optional=True),
    text("verdict", "A robot's own verdict on the attempt: moved, blocked or failed. Empty without a robot.",
         lambda row: row.step.sensed.get(VERDICT), optional=True),
    text("camera", "The positions that a camera read after the step: 0 or 1 for each joint, ? for an unclear one, in "
         "panel order. Empty if no camera was read.",
         lambda row: row.step.sensed.get(CAMERA), kind="bits", optional=True),
    *_OF_PERSON,
    text("report", "The report after the step, word for word. Empty with pictures.",
         lambda row: row.step.told if row.did else "", optional=True),
    text("shown", "What the participant read of the step, in their language: the sentences of the page, and a remark. "
         "Empty if the step ended the box.", lambda row: row.did.shown if row.did else "", optional=True),
    number("rt_ms", "Response time, from painting the scene to the choice of the joint; without the time for the "
           f"claim, {PAGE}.", lambda row: row.did.act.rt if row.did else None, "ms", optional=True),
    number("claimed_rt_ms", f"Response time of what stands in claimed, from painting the scene to the claim, {PAGE}. "
           "Empty without it.", lambda row: _claim_time(row.next_did), "ms", optional=True),
    number("at", f"Time of arrival at the server, counted from the participant's consent, {SERVER}.",
           lambda row: row.did.at if row.did else None, "s", optional=True),
)  # fmt: skip

TRIALS: Sequence[Column] = (
    *_OF_TRIAL,
    text("ending", "How the trial ended: solved, budget (steps ran out), error (broken, not a failure to solve).",
         lambda row: row.trial.ending),
    mark("solved", "whether the target joint moved. Empty if the trial ended as error, which is not a failure to "
         "solve.", lambda row: None if row.trial.error else row.trial.solved),
    count("steps", "Steps taken; each is one attempt to move a joint.", lambda row: len(row.trial.steps), least=0),
    count("budget", "The most steps of the trial.", lambda row: row.trial.budget),
    count("moves", "Attempts that really moved their joint.", lambda row: sum(step.moved for step in row.trial.steps),
          least=0),
    count("false_reports", "Steps whose report said the opposite of the truth.",
          lambda row: sum(step.told_falsely for step in row.trial.steps), least=0),
    count("claims", "Number of claims about the previous step.", lambda row: len(claims(row.trial)), least=0),
    count("misinterpretations", "Number of claims that contradict the report (not the truth).",
          lambda row: sum(one.misread for one in claims(row.trial)), least=0),
    mark("any_loop", "whether the attempts contain an action loop: a run of three or more that occurs twice.",
         lambda row: row.any_loop),
    number("loop_coverage", "The largest share of attempts that action loops cover. Empty without an attempt.",
           lambda row: row.loop_coverage if row.trial.steps else None, most=1),
    text("error", "The boundary at which a trial broke: model, reply, refusal, plant, channel or participant.",
         lambda row: row.trial.error.boundary if row.trial.error else ""),
    number("trial_seconds", "Time that a person took for the box, from when it was shown to its last step, "
           f"{SERVER}. Empty for others.", lambda row: row.seconds, "s", optional=True),
    *_OF_PERSON,
)  # fmt: skip


def steps_table(trials: Sequence[Trial], acts: Mapping[tuple[str, int], Did] = NOBODY) -> Table:
    """A row per step of finished trials, truth and report.

    A trial that broke before its first step has no row. ``acts`` are those of people, by key of the trial and step.
    """

    def rows() -> Iterator[StepRow]:
        for trial in trials:
            for step, said in zip(trial.steps, trial.said, strict=True):
                here, after = (acts.get((trial.key, number)) for number in (step.step, step.step + 1))
                yield StepRow(trial, step, said, here, after)

    return Table("a step of a finished trial: truth and report", STEPS, rows)


def trials_table(trials: Sequence[Trial], seconds: Mapping[str, float] = MappingProxyType({})) -> Table:
    """A row per finished trial, also of those that broke before their first step; ``seconds`` of people, by key."""
    rows = [
        TrialRow(trial, (loops := cover(trial.actions)).any_loop, loops.share, seconds.get(trial.key))
        for trial in trials
    ]
    about = "a finished trial: whether the box was opened, in how many steps, with which claims and loops"
    return Table(about, TRIALS, lambda: rows)


def tidy(trials: Trial | Iterable[Trial]) -> list[dict[str, Cell]]:
    """The steps of one or several trials as a table for pandas, polars or R: one row per step, truth and report.

    ``pandas.DataFrame(lockprobe.tidy(trials))``. The columns are those of ``lockprobe export``: ``moved`` (the truth),
    ``told_moved`` (what the report implied), ``claimed`` (what the agent said of this step in its next decision) and
    ``misread`` (whether that contradicts the report) are 0, 1 or empty.
    """
    return list(steps_table(_several(trials)).rows())


def trial_rows(trials: Trial | Iterable[Trial]) -> list[dict[str, Cell]]:
    """One row per trial, including trials that broke before their first step.

    ``solved`` is 1 or 0, and empty if the trial ended as an error, which is not a failure to solve.

    >>> import lockprobe
    >>> (row,) = trial_rows([lockprobe.run_trial(agent="human-inspired", p=0.0, seed=1)])
    >>> row["solved"], row["budget"], row["false_reports"]
    (1, 20, 0)
    """
    return list(trials_table(_several(trials)).rows())


def _several(trials: Any) -> list[Trial]:
    """One or several trials as a list."""
    if isinstance(trials, str | Path) or not isinstance(trials, Trial | Iterable):
        raise BadValue("trials", trials, "a trial or several, for example those of lockprobe.load(DIR)")
    return [trials] if isinstance(trials, Trial) else list(trials)

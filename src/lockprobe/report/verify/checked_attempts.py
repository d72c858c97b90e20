"""Trials of people and of clients with tools, held against the logs of the servers that wrote them step by step."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from lockprobe.foundation.spec import MCP, spec_kind
from lockprobe.people.diary import Diary
from lockprobe.people.responses import Attempt
from lockprobe.people.step_times import key_of
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.verify.check import Check, also, check_of
from lockprobe.studies.records.attempt_log import AttemptLog
from lockprobe.studies.running.paused_trial import RecordedAttempt
from lockprobe.trial.record import Trial


def attempts_check(opened: OpenedStudy) -> Iterator[Check]:
    """Whether steps of people and clients are the attempts in their diaries and in ``attempts.jsonl``, and all of them.

    Nothing where neither took part.

    Raises:
        BadFile: If a log is damaged.
    """
    trials, logged = {trial.key: trial for trial in opened.trials}, AttemptLog.read(opened.directory)
    clients = [trial for trial in opened.trials if spec_kind(trial.agent) == MCP]
    people = [trial for trial in opened.trials if trial.player]
    if not (clients or people or logged or opened.diaries):
        return
    planned = {plan.key for agent in opened.study.run_agents for plan in opened.study.plans(agent)}
    diaries = {diary.spec: diary for diary in opened.diaries}
    failed = [
        *(f"{trial.key}: {why}" for trial in clients if (why := _unlike(trial, logged.get(trial.key, ())))),
        *(f"{key}: attempts of no trial of this study" for key in logged if key not in trials and key not in planned),
        *(f"{trial.key}: its player has no diary" for trial in people if diaries and trial.agent not in diaries),
        *(why for diary in opened.diaries for why in _against_diary(opened, trials, diary)),
    ]
    held = len(clients) + (len(people) if diaries else 0)
    rest = also(0 if diaries else len(people), "have no diaries")
    holds = f"{held} trials of clients and people are as their servers wrote them step by step{rest}"
    yield check_of("attempts", failed, holds, "contradictions between trials.jsonl and the logs of attempts")


def _unlike(trial: Trial, attempts: Sequence[RecordedAttempt]) -> str:
    """The first difference between a trial and the attempts in a log; empty without one."""
    if trial.owed_again:  # its box broke: the log starts anew
        return ""
    if len(attempts) != len(trial.steps):
        return f"{len(trial.steps)} steps, and {len(attempts)} attempts in its log"
    for step, attempt in zip(trial.steps, attempts, strict=True):
        said = step.decision
        if (said.joint, said.claimed, said.hypothesis, step.told) != (
            attempt.joint,
            attempt.claimed,
            attempt.hypothesis,
            attempt.told,
        ):
            return f"step {step.step} is another one in its log"
    return ""


def _against_diary(opened: OpenedStudy, trials: Mapping[str, Trial], diary: Diary) -> Iterator[str]:
    """What a diary and the records have differently."""
    for box in range(1, len(diary.joined.slots) + 1):
        acts = diary.attempts(box)
        key = key_of(opened.study, diary, box)
        trial = trials.get(key)
        if trial is not None and trial.agent == diary.spec:
            attempts = [
                RecordedAttempt(act.act.joint, act.act.claimed, act.told)
                for act in acts
                if isinstance(act.act, Attempt)
            ]
            if why := _unlike(trial, attempts):
                yield f"{key}: {why}"
        elif trial is None and acts and acts[-1].ended is not None:
            yield f"{key}: it ended in the diary of {diary.spec} and is not on record"
